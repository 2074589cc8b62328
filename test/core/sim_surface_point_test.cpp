// SPDX-License-Identifier: BSD-3-Clause
// The true surface: nearest points against clouds of ray hits, faces against the rays that meet
// them.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "ladar_perception/sim/random.h"
#include "ladar_perception/sim/surface_point.h"
#include "ladar_perception/sim/world.h"

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

constexpr Material kAny = Material::kRock;

Vector3d randomPoint(Random* random, double reach) {
  const double x = random->uniform(-reach, reach);
  const double y = random->uniform(-reach, reach);
  const double z = random->uniform(-reach, reach);
  return {x, y, z};
}

std::vector<Primitive> oneOfEach() {
  return {makeSphere({0.2, 0.1, 0.0}, 0.5, kAny),
          makeCapsule({-0.4, 0.1, 0.0}, {0.5, 0.3, 0.2}, 0.2, kAny),
          makeCylinder({-0.4, 0.1, 0.0}, {0.5, 0.3, 0.2}, 0.3, kAny),
          makeBox({0.1, 0.0, 0.0}, {0.6, 1.0, 0.4}, 0.7, kAny, 0.3),
          makeDisc({0.0, 0.2, 0.0}, {0.3, 0.2, 1.0}, 0.5, kAny),
          makeTriangle({-0.5, 0.0, 0.0}, {0.6, 0.1, 0.2}, {0.0, 0.7, -0.3}, kAny)};
}

/// Places where rays from all around, aimed at all parts, meet the shape.
std::vector<Vector3d> surfaceHits(const Primitive& shape) {
  Random random(5);
  std::vector<Vector3d> hits;
  while (hits.size() < 40000) {
    const Vector3d from = 4.0 * randomPoint(&random, 1.0).normalized();
    const Vector3d to = randomPoint(&random, 0.9);
    const Ray ray{from, (to - from).normalized()};
    const double t = intersect(shape, ray);
    if (t < kMiss) hits.push_back(ray.origin + t * ray.direction);
  }
  return hits;
}

TEST(SimSurfacePoint, NoHitIsNearerThanTheNearestPointOfAShape) {
  for (const Primitive& shape : oneOfEach()) {
    const std::vector<Vector3d> hits = surfaceHits(shape);
    Random random(6);
    for (int i = 0; i < 60; ++i) {
      const Vector3d p = randomPoint(&random, 1.0);
      const double distance = (nearestOnShape(shape, p) - p).norm();
      double least = kMiss;
      for (const Vector3d& hit : hits) least = std::min(least, (hit - p).norm());
      const auto name = static_cast<int>(shape.shape);
      EXPECT_GE(least, distance - 1e-6) << "shape " << name << " at " << p.transpose();
      // The hits are about 1 cm apart.
      EXPECT_LE(least, distance + 0.02) << "shape " << name << " at " << p.transpose();
    }
  }
}

TEST(SimSurfacePoint, CentresAndAxesHaveANearestPoint) {
  for (const Primitive& shape : oneOfEach()) {
    const Vector3d centre = shape.a.cast<double>();
    const Vector3d nearest = nearestOnShape(shape, centre);
    ASSERT_TRUE(nearest.allFinite());
    const Vector3d again = nearestOnShape(shape, nearest);
    EXPECT_LT((again - nearest).norm(), 1e-6) << "its nearest point is itself";
  }
  const Primitive sphere = makeSphere({1, 2, 3}, 0.5, kAny);
  EXPECT_NEAR((nearestOnShape(sphere, {1, 2, 3}) - Vector3d(1, 2, 3)).norm(), 0.5, 1e-9);
  const Primitive capsule = makeCapsule({0, 0, 0}, {1, 0, 0}, 0.25, kAny);
  EXPECT_NEAR((nearestOnShape(capsule, {0.5, 0, 0}) - Vector3d(0.5, 0, 0)).norm(), 0.25, 1e-9);
}

TEST(SimSurfacePoint, SidesOfABoxPointOutward) {
  const Primitive box = makeBox({1, 2, 3}, {2, 4, 6}, 0.4, kAny, 0.2);
  double area = 0.0;
  for (int side = 0; side < 6; ++side) {
    const Rectangle face = boxSide(box, side);
    const Vector3d middle = face.corner_m + 0.5 * (face.edge_u_m + face.edge_v_m);
    EXPECT_GT(face.normal().dot(middle - box.a.cast<double>()), 0.9) << side;
    EXPECT_LT((normalAt(box, middle) - face.normal()).norm(), 1e-5) << side;
    EXPECT_EQ(sideOfBox(box, middle), side);
    EXPECT_NEAR(face.edge_u_m.dot(face.edge_v_m), 0.0, 1e-5);
    area += face.area();
  }
  EXPECT_NEAR(area, 2.0 * (8.0 + 12.0 + 24.0), 1e-4);
}

TEST(SimSurfacePoint, GroundIsFoundWhereItIsNearest) {
  const auto tilted = [](double x, double) { return 0.5 * x; };
  const auto soil = [](double, double) { return Material::kSoil; };
  const HeightField ground(6.0, tilted, soil);
  Vector3d nearest;
  // 2 m above a slope of 1 : 2, the nearest place is not the one below.
  const double distance = ground.nearest({0.0, 0.0, 2.0}, kMiss, &nearest);
  EXPECT_NEAR(distance, 2.0 / std::sqrt(1.25), 1e-4);
  EXPECT_LT((nearest - Vector3d(0.8, 0.0, 0.4)).norm(), 1e-3);
  EXPECT_EQ(ground.nearest({0.0, 0.0, 2.0}, 1.7, &nearest), kMiss);
  EXPECT_EQ(HeightField().nearest({0.0, 0.0, 2.0}, kMiss, &nearest), kMiss);
}

/// A scene of boxes, tubes and leaves, placed turned and scaled.
Scene placedShapes() {
  Scene scene{HeightField(
      10.0, [](double x, double y) { return 0.1 * std::sin(x) + 0.05 * y; },
      [](double, double) { return Material::kLawn; })};
  const uint32_t model = scene.addModel(oneOfEach());
  Random random(9);
  for (int i = 0; i < 12; ++i) {
    Placement placement;
    placement.p_world = randomPoint(&random, 4.0);
    placement.p_world.z() += 5.0;
    placement.yaw_rad = random.uniform(0.0, 6.0);
    placement.scale = random.uniform(0.5, 2.0);
    scene.place(model, placement);
  }
  scene.finish();
  return scene;
}

TEST(SimSurfacePoint, WhatARayMeetsIsTheNearestSurface) {
  const Scene scene = placedShapes();
  Random random(10);
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d from = Vector3d(0, 0, 6) + 9.0 * randomPoint(&random, 1.0).normalized();
    if (from.z() < 1.0) continue;
    const Vector3d to = randomPoint(&random, 4.0);
    const Ray ray{from, (to - from).normalized()};
    Hit hit;
    const SurfacePoint met = scene.castRayToSurface(ray, 40.0, &hit);
    const Hit same = scene.castRay(ray, 40.0);
    ASSERT_EQ(met.valid(), same.valid());
    if (!met.valid()) continue;
    ++hits;
    EXPECT_EQ(hit.range, same.range);
    EXPECT_EQ(met.distance_m, same.range);
    EXPECT_NEAR(std::abs(met.normal.dot(ray.direction)), same.incidence, 1e-6);
    EXPECT_NEAR(met.normal.norm(), 1.0, 1e-6);
    // The very place, and off the surface by 1 cm.
    EXPECT_LT(scene.nearestSurface(met.p_world).distance_m, 1e-4);
    const SurfacePoint off = scene.nearestSurface(met.p_world - 0.01 * ray.direction);
    EXPECT_LE(off.distance_m, 0.0101);
    EXPECT_LT((off.p_world - met.p_world).norm(), 0.03);
    EXPECT_FALSE(scene.nearestSurface(off.p_world - 0.02 * ray.direction, 1e-6).valid());
  }
  EXPECT_GT(hits, 1500);
}

TEST(SimSurfacePoint, NearestOfAPlacedSceneIsThatOfItsParts) {
  // One model, one placement: in the model's own coordinates the answer is known.
  for (const Primitive& shape : oneOfEach()) {
    Scene scene{HeightField()};
    const Placement placement{{3.0, -2.0, 1.0}, 0.8, 1.7};
    scene.place(scene.addModel({shape}), placement);
    scene.finish();
    Random random(11);
    const Eigen::AngleAxisd turn(placement.yaw_rad, Vector3d::UnitZ());
    for (int i = 0; i < 50; ++i) {
      const Vector3d p_model = randomPoint(&random, 1.5);
      const Vector3d p_world = placement.p_world + placement.scale * (turn * p_model);
      const Vector3d expected =
          placement.p_world + placement.scale * (turn * nearestOnShape(shape, p_model));
      const SurfacePoint found = scene.nearestSurface(p_world);
      ASSERT_TRUE(found.valid());
      EXPECT_LT((found.p_world - expected).norm(), 1e-5);
      EXPECT_NEAR(found.distance_m, (expected - p_world).norm(), 1e-6);
    }
  }
  EXPECT_FALSE(Scene(HeightField()).nearestSurface({0, 0, 0}).valid());
}

TEST(SimSurfacePoint, FacesAreWhereRaysMeetThem) {
  const World campus = makeWorld("campus", 1);
  const std::vector<PlanarFace> faces = campus.scene.planarFaces();
  for (std::size_t i = 0; i < faces.size(); ++i) ASSERT_EQ(faces[i].id, i + 1);
  const Eigen::Vector2d beside = campus.circuit.beside(152.0, -4.5);
  const Vector3d sensor(beside.x(), beside.y(),
                        campus.scene.ground().height(beside.x(), beside.y()) + 1.7);
  Random random(12);
  std::map<uint32_t, std::set<uint32_t>> faces_of_plane;
  int on_faces = 0;
  for (int i = 0; i < 20000; ++i) {
    const Ray ray{sensor, randomPoint(&random, 1.0).normalized()};
    const SurfacePoint met = campus.scene.castRayToSurface(ray, 50.0);
    if (!met.valid() || met.face == 0) continue;
    ++on_faces;
    ASSERT_LE(met.face, faces.size());
    const PlanarFace& face = faces[met.face - 1];
    const Vector3d offset = met.p_world - face.rectangle.corner_m;
    const Vector3d& u = face.rectangle.edge_u_m;
    const Vector3d& v = face.rectangle.edge_v_m;
    EXPECT_NEAR(offset.dot(face.rectangle.normal()), 0.0, 1e-4);
    EXPECT_NEAR(offset.dot(u) / u.norm(), 0.5 * u.norm(), 0.5 * u.norm() + 1e-4);
    EXPECT_NEAR(offset.dot(v) / v.norm(), 0.5 * v.norm(), 0.5 * v.norm() + 1e-4);
    EXPECT_LT((met.normal - face.rectangle.normal()).norm(), 1e-4);
    EXPECT_EQ(met.material, face.material);
    faces_of_plane[face.plane].insert(face.id);
  }
  EXPECT_GT(on_faces, 1000);
  // A wall is many pieces between its windows, all in one plane.
  std::size_t most = 0;
  for (const auto& [plane, pieces] : faces_of_plane) most = std::max(most, pieces.size());
  EXPECT_GT(most, 40u);
}

}  // namespace
}  // namespace ladar_perception::sim
