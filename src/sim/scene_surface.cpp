// SPDX-License-Identifier: BSD-3-Clause
// Scene: the true surface, for measuring errors.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "ladar_perception/sim/scene.h"

namespace ladar_perception::sim {
namespace {

constexpr int kBoxSides = 6;

/// Names the plane of a side: its model's placement, its material, and in the model its direction
/// and distance.
using PlaneKey = std::array<int64_t, 6>;

PlaneKey planeKey(uint32_t instance, Material material, const Rectangle& side) {
  const Eigen::Vector3d normal = side.normal();
  const auto step = [](double value) { return static_cast<int64_t>(std::llround(1e3 * value)); };
  // Models have whole millimetres mostly: steps of a centimetre that begin between these are not
  // crossed by rounding.
  const double distance_m = normal.dot(side.corner_m);
  return {instance,         static_cast<int64_t>(material),
          step(normal.x()), step(normal.y()),
          step(normal.z()), static_cast<int64_t>(std::floor(distance_m * 100.0 + 0.503))};
}

}  // namespace

Eigen::Vector3d Scene::turned(const Instance& instance, const Eigen::Vector3d& v_model) {
  const double c = instance.cos_yaw;
  const double s = instance.sin_yaw;
  return {c * v_model.x() - s * v_model.y(), s * v_model.x() + c * v_model.y(), v_model.z()};
}

Eigen::Vector3d Scene::toWorld(const Instance& instance, const Eigen::Vector3d& p_model) {
  return instance.p_world + instance.scale * turned(instance, p_model);
}

void Scene::describeSurface(const Instance& instance, uint32_t primitive,
                            const Eigen::Vector3d& seen_from_world, SurfacePoint* point) const {
  const Model& model = models_[instance.model];
  const Primitive& shape = model.primitives[primitive];
  const Eigen::Vector3d p_model =
      toModel(instance, {point->p_world, Eigen::Vector3d::UnitX()}).origin;
  point->normal = turned(instance, normalAt(shape, p_model));
  point->material = shape.material;
  point->face = 0;
  if (shape.shape == Shape::kBox) {
    point->face = instance.first_face + kBoxSides * model.boxes_before[primitive] +
                  static_cast<uint32_t>(sideOfBox(shape, p_model));
  }
  const bool two_sided = shape.shape == Shape::kDisc || shape.shape == Shape::kTriangle;
  if (two_sided && point->normal.dot(seen_from_world - point->p_world) < 0.0) {
    point->normal = -point->normal;
  }
}

SurfacePoint Scene::castRayToSurface(const Ray& ray, double t_limit, Hit* hit) const {
  const Nearest nearest = nearestHit(ray, t_limit, true);
  const Hit what = describe(ray, nearest);
  if (hit != nullptr) *hit = what;
  SurfacePoint point;
  if (!what.valid()) return point;
  point.distance_m = nearest.t;
  point.p_world = ray.origin + nearest.t * ray.direction;
  if (nearest.instance == kGround) {
    point.normal = ground_.normal(point.p_world.x(), point.p_world.y());
    point.material = what.material;
  } else {
    describeSurface(instances_[nearest.instance], nearest.primitive, ray.origin, &point);
  }
  return point;
}

SurfacePoint Scene::nearestSurface(const Eigen::Vector3d& p_world, double limit_m) const {
  SurfacePoint point;
  double least_m = limit_m;
  uint32_t nearest_instance = 0;
  uint32_t nearest_primitive = 0;
  tree_.visitNear(p_world, least_m, [&](uint32_t i) {
    const Instance& instance = instances_[i];
    const Model& model = models_[instance.model];
    const Eigen::Vector3d p_model = toModel(instance, {p_world, Eigen::Vector3d::UnitX()}).origin;
    double least_model = least_m / instance.scale;
    model.tree.visitNear(p_model, least_model, [&](uint32_t k) {
      const Eigen::Vector3d candidate = nearestOnShape(model.primitives[k], p_model);
      const double distance = (candidate - p_model).norm();
      if (distance >= least_model) return;
      least_model = distance;
      least_m = distance * instance.scale;
      nearest_instance = i;
      nearest_primitive = k;
      point.distance_m = least_m;
      point.p_world = toWorld(instance, candidate);
    });
  });
  if (point.valid()) {
    describeSurface(instances_[nearest_instance], nearest_primitive, p_world, &point);
  }
  const double ground_m = ground_.nearest(p_world, least_m, &point.p_world);
  if (ground_m == kMiss) return point;
  point.distance_m = ground_m;
  point.normal = ground_.normal(point.p_world.x(), point.p_world.y());
  point.material = ground_.material(point.p_world.x(), point.p_world.y());
  point.face = 0;
  return point;
}

std::vector<PlanarFace> Scene::planarFaces() const {
  std::vector<PlanarFace> faces;
  std::map<PlaneKey, uint32_t> planes;
  for (uint32_t i = 0; i < instances_.size(); ++i) {
    const Instance& instance = instances_[i];
    for (const Primitive& shape : models_[instance.model].primitives) {
      if (shape.shape != Shape::kBox) continue;
      for (int side = 0; side < kBoxSides; ++side) {
        const Rectangle local = boxSide(shape, side);
        PlanarFace face;
        face.id = static_cast<uint32_t>(faces.size() + 1);
        face.rectangle.corner_m = toWorld(instance, local.corner_m);
        face.rectangle.edge_u_m = instance.scale * turned(instance, local.edge_u_m);
        face.rectangle.edge_v_m = instance.scale * turned(instance, local.edge_v_m);
        face.material = shape.material;
        const auto next = static_cast<uint32_t>(planes.size());
        face.plane = planes.emplace(planeKey(i, face.material, local), next).first->second;
        faces.push_back(face);
      }
    }
  }
  return faces;
}

}  // namespace ladar_perception::sim
