// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ladar_perception/sim/random.h"

namespace ladar_perception::sim {
namespace {

constexpr uint32_t kNothing = 0xfffffffe;
constexpr uint32_t kBoxSides = 6;

/// Names the patch of 0.1 m that a point of a large surface lies in, for its colour.
uint64_t patchKey(const Eigen::Vector3d& p) {
  const auto cell = [](double v) { return static_cast<uint64_t>(std::llround(v * 10.0)); };
  return streamSeed(1, {cell(p.x()), cell(p.y()), cell(p.z())});
}

/// Largest horizontal distance of a box's corners from the z axis.
double reachOf(const Bounds& part) {
  return part.low.cwiseAbs().cwiseMax(part.high.cwiseAbs()).head<2>().cast<double>().norm();
}

}  // namespace

uint32_t Scene::addModel(std::vector<Primitive> primitives) {
  Model model;
  std::vector<Bounds> parts;
  parts.reserve(primitives.size());
  for (const Primitive& primitive : primitives) {
    model.boxes_before.push_back(model.boxes);
    if (primitive.shape == Shape::kBox) ++model.boxes;
    parts.push_back(boundsOf(primitive));
    model.bounds.add(parts.back());
    model.reach = std::max(model.reach, reachOf(parts.back()));
  }
  model.primitives = std::move(primitives);
  model.tree = Bvh(parts);
  models_.push_back(std::move(model));
  return static_cast<uint32_t>(models_.size() - 1);
}

void Scene::place(uint32_t model, const Placement& placement) {
  instances_.push_back({placement.p_world, std::cos(placement.yaw_rad), std::sin(placement.yaw_rad),
                        placement.scale, model, next_face_});
  next_face_ += kBoxSides * models_[model].boxes;
}

void Scene::finish() {
  std::vector<Bounds> bounds;
  bounds.reserve(instances_.size());
  for (const Instance& instance : instances_) bounds.push_back(boundsOfInstance(instance));
  tree_ = Bvh(bounds);
}

Bounds Scene::boundsOfInstance(const Instance& instance) const {
  const Model& model = models_[instance.model];
  const double c = instance.cos_yaw;
  const double s = instance.sin_yaw;
  const Eigen::Vector3d centre = 0.5 * (model.bounds.low + model.bounds.high).cast<double>();
  const Eigen::Vector3d half = 0.5 * (model.bounds.high - model.bounds.low).cast<double>();
  const Eigen::Vector3d turned(c * centre.x() - s * centre.y(), s * centre.x() + c * centre.y(),
                               centre.z());
  const Eigen::Vector3d extent(std::abs(c) * half.x() + std::abs(s) * half.y(),
                               std::abs(s) * half.x() + std::abs(c) * half.y(), half.z());
  // The turned box is tight for hedges and walls, the cylinder of the reach for round plants.
  const Eigen::Vector3d reach(model.reach, model.reach, kMiss);
  const Eigen::Vector3d low = (turned - extent).cwiseMax(-reach);
  const Eigen::Vector3d high = (turned + extent).cwiseMin(reach);
  Bounds bounds;
  bounds.add((instance.p_world + instance.scale * low).cast<float>());
  bounds.add((instance.p_world + instance.scale * high).cast<float>());
  return bounds;
}

Ray Scene::toModel(const Instance& instance, const Ray& ray_world) {
  const double shrink = 1.0 / instance.scale;
  const double c = shrink * instance.cos_yaw;
  const double s = shrink * instance.sin_yaw;
  const auto turn = [&](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(c * v.x() + s * v.y(), -s * v.x() + c * v.y(), shrink * v.z());
  };
  // The direction shrinks with the scale, so that t is the same in both frames.
  return {turn(ray_world.origin - instance.p_world), turn(ray_world.direction)};
}

void Scene::test(const Primitive& primitive, const Ray& ray, uint32_t instance, uint32_t index,
                 Nearest* nearest) {
  const double t = intersect(primitive, ray);
  if (t > nearest->t || t == kMiss) return;
  // Equal distances go to the lower number, so that the order of tests does not matter.
  const bool tie_lost =
      t == nearest->t &&
      std::make_pair(instance, index) >= std::make_pair(nearest->instance, nearest->primitive);
  if (!tie_lost) *nearest = {t, instance, index};
}

Scene::Nearest Scene::nearestGround(const Ray& ray, double t_limit, bool with_ground) const {
  const double t = with_ground ? ground_.intersect(ray, t_limit) : kMiss;
  if (t <= t_limit) return {t, kGround, 0};
  return {t_limit, kNothing, 0};
}

Hit Scene::castRay(const Ray& ray, double t_limit, bool with_ground) const {
  return describe(ray, nearestHit(ray, t_limit, with_ground));
}

Scene::Nearest Scene::nearestHit(const Ray& ray, double t_limit, bool with_ground) const {
  Nearest nearest = nearestGround(ray, t_limit, with_ground);
  tree_.traverse(ray, nearest.t, [&](uint32_t i) {
    const Instance& instance = instances_[i];
    const Model& model = models_[instance.model];
    const Ray local = toModel(instance, ray);
    model.tree.traverse(local, nearest.t,
                        [&](uint32_t k) { test(model.primitives[k], local, i, k, &nearest); });
  });
  return nearest;
}

Hit Scene::castRayBruteForce(const Ray& ray, double t_limit, bool with_ground) const {
  Nearest nearest = nearestGround(ray, t_limit, with_ground);
  for (uint32_t i = 0; i < instances_.size(); ++i) {
    const Model& model = models_[instances_[i].model];
    const Ray local = toModel(instances_[i], ray);
    for (uint32_t k = 0; k < model.primitives.size(); ++k) {
      test(model.primitives[k], local, i, k, &nearest);
    }
  }
  return describe(ray, nearest);
}

Hit Scene::describe(const Ray& ray, const Nearest& nearest) const {
  Hit hit;
  if (nearest.instance == kNothing) return hit;
  hit.range = nearest.t;
  const Eigen::Vector3d p_world = ray.origin + nearest.t * ray.direction;
  Eigen::Vector3d normal;
  Eigen::Vector3d direction = ray.direction;
  uint64_t variant = patchKey(p_world);
  if (nearest.instance == kGround) {
    hit.material = ground_.material(p_world.x(), p_world.y());
    normal = ground_.normal(p_world.x(), p_world.y());
  } else {
    const Instance& instance = instances_[nearest.instance];
    const Primitive& primitive = models_[instance.model].primitives[nearest.primitive];
    const Ray local = toModel(instance, ray);
    hit.material = primitive.material;
    normal = normalAt(primitive, local.origin + nearest.t * local.direction);
    direction = local.direction;
    if (propertiesOf(primitive.material).truth != Truth::kSurface) {
      variant = streamSeed(2, {nearest.instance, nearest.primitive});
    }
  }
  hit.incidence = std::abs(normal.dot(direction)) / direction.norm();
  hit.truth = propertiesOf(hit.material).truth;
  hit.rgb = colourOf(hit.material, variant);
  return hit;
}

double Scene::reachBelow(uint32_t model, double height_m) const {
  double reach = 0.0;
  for (const Primitive& primitive : models_[model].primitives) {
    const Bounds part = boundsOf(primitive);
    if (part.low.z() > height_m) continue;
    reach = std::max(reach, reachOf(part));
  }
  return reach;
}

std::size_t Scene::primitiveCount() const {
  std::size_t count = 0;
  for (const Model& model : models_) count += model.primitives.size();
  return count;
}

}  // namespace ladar_perception::sim
