// SPDX-License-Identifier: BSD-3-Clause
// Shapes, ground and trees of boxes against analytic cases and brute force.
#include <gtest/gtest.h>

#include <cmath>

#include "ladar_perception/sim/primitive.h"
#include "ladar_perception/sim/random.h"
#include "ladar_perception/sim/scene.h"

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

Vector3d randomUnit(Random* random) {
  while (true) {
    const Vector3d p = randomPoint(random, 1.0);
    if (p.norm() > 0.1 && p.norm() < 1.0) return p.normalized();
  }
}

Primitive randomPrimitive(Random* random) {
  const Vector3d a = randomPoint(random, 3.0);
  const Vector3d b = a + randomPoint(random, 1.0);
  const Vector3d c = a + randomPoint(random, 1.0);
  const double size = random->uniform(0.01, 0.6);
  switch (random->below(6)) {
    case 0:
      return makeSphere(a, size, kAny);
    case 1:
      return makeCapsule(a, b, 0.3 * size, kAny);
    case 2:
      return makeCylinder(a, b, 0.3 * size, kAny);
    case 3:
      return makeBox(a, (c - a).cwiseAbs() + Vector3d::Constant(0.02), size * 9.0, kAny, size);
    case 4:
      return makeDisc(a, (b - a), size, kAny);
    default:
      return makeTriangle(a, b, c, kAny);
  }
}

TEST(SimPrimitive, SphereIsMetAtItsNearSide) {
  const Primitive sphere = makeSphere({5, 0, 0}, 1.0, kAny);
  EXPECT_DOUBLE_EQ(intersect(sphere, {{0, 0, 0}, {1, 0, 0}}), 4.0);
  EXPECT_EQ(intersect(sphere, {{0, 1.01, 0}, {1, 0, 0}}), kMiss);
  EXPECT_EQ(intersect(sphere, {{10, 0, 0}, {1, 0, 0}}), kMiss);
  EXPECT_EQ(intersect(sphere, {{5, 0, 0}, {1, 0, 0}}), kMiss) << "not seen from within";
}

TEST(SimPrimitive, CapsuleHasRoundEndsAndCylinderFlatOnes) {
  const Primitive capsule = makeCapsule({0, 0, 0}, {0, 0, 2}, 0.5, kAny);
  const Primitive cylinder = makeCylinder({0, 0, 0}, {0, 0, 2}, 0.5, kAny);
  const Ray side{{3, 0, 1}, {-1, 0, 0}};
  EXPECT_DOUBLE_EQ(intersect(capsule, side), 2.5);
  EXPECT_DOUBLE_EQ(intersect(cylinder, side), 2.5);
  const Ray down{{0, 0, 5}, {0, 0, -1}};
  EXPECT_DOUBLE_EQ(intersect(capsule, down), 2.5);
  EXPECT_DOUBLE_EQ(intersect(cylinder, down), 3.0);
  const Ray beside_the_end{{3, 0, 2.2}, {-1, 0, 0}};
  EXPECT_NEAR(intersect(capsule, beside_the_end), 3.0 - std::sqrt(0.25 - 0.04), 1e-6);
  EXPECT_EQ(intersect(cylinder, beside_the_end), kMiss);
}

TEST(SimPrimitive, BoxIsTurnedByItsYaw) {
  const Primitive straight = makeBox({5, 0, 0}, {2, 2, 2}, 0.0, kAny);
  const Primitive turned = makeBox({5, 0, 0}, {2, 2, 2}, std::acos(-1.0) / 4.0, kAny);
  const Ray ray{{0, 0, 0}, {1, 0, 0}};
  EXPECT_DOUBLE_EQ(intersect(straight, ray), 4.0);
  EXPECT_NEAR(intersect(turned, ray), 5.0 - std::sqrt(2.0), 1e-6);
  EXPECT_TRUE(normalAt(straight, {4, 0.2, 0}).isApprox(Vector3d(-1, 0, 0)));
}

TEST(SimPrimitive, DiscAndTriangleAreSeenFromBothSides) {
  const Primitive disc = makeDisc({2, 0, 0}, {1, 0, 0}, 0.5, kAny);
  const Primitive triangle = makeTriangle({2, -1, -1}, {2, 1, -1}, {2, 0, 1}, kAny);
  for (const Primitive& leaf : {disc, triangle}) {
    EXPECT_DOUBLE_EQ(intersect(leaf, {{0, 0, 0}, {1, 0, 0}}), 2.0);
    EXPECT_DOUBLE_EQ(intersect(leaf, {{4, 0, 0}, {-1, 0, 0}}), 2.0);
    EXPECT_EQ(intersect(leaf, {{0, 0, 1.1}, {1, 0, 0}}), kMiss);
  }
}

TEST(SimPrimitive, HitsLieInsideTheBoundsOnASurfaceThatFacesTheRay) {
  Random random(11);
  int hits = 0;
  for (int i = 0; i < 30000; ++i) {
    const Primitive primitive = randomPrimitive(&random);
    const Eigen::Vector3d origin = randomPoint(&random, 6.0);
    const Eigen::Vector3d target = primitive.a.cast<double>() + 0.4 * randomUnit(&random);
    const Ray ray{origin, (target - origin).normalized()};
    const double t = intersect(primitive, ray);
    if (t == kMiss) continue;
    ++hits;
    const Vector3d p = ray.origin + t * ray.direction;
    const Bounds bounds = boundsOf(primitive);
    ASSERT_TRUE((p.array() >= bounds.low.cast<double>().array() - 1e-5).all());
    ASSERT_TRUE((p.array() <= bounds.high.cast<double>().array() + 1e-5).all());
    const Vector3d normal = normalAt(primitive, p);
    ASSERT_NEAR(normal.norm(), 1.0, 1e-5);
    const bool solid = primitive.shape != Shape::kDisc && primitive.shape != Shape::kTriangle;
    // Rims of flat ends may be given to either side.
    if (solid && primitive.shape != Shape::kCylinder) {
      ASSERT_LT(normal.dot(ray.direction), 1e-3);
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST(SimHeightField, MeetsAPlaneWhereAlgebraSays) {
  const HeightField plane(
      20.0, [](double x, double y) { return 0.5 + 0.125 * x - 0.25 * y; },
      [](double, double) { return Material::kSoil; });
  const Vector3d n(-0.125, 0.25, 1.0);
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    Vector3d origin = randomPoint(&random, 8.0);
    origin.z() = 6.0;
    Vector3d direction = randomUnit(&random);
    direction.z() = -std::abs(direction.z()) - 0.3;
    const double expected = (0.5 - n.dot(origin)) / n.dot(direction);
    const Vector3d p = origin + expected * direction;
    if (std::abs(p.x()) > 19.9 || std::abs(p.y()) > 19.9) continue;
    EXPECT_NEAR(plane.intersect({origin, direction}, 100.0), expected, 1e-5);
  }
  EXPECT_EQ(plane.intersect({{0, 0, 6}, {0, 0, 1}}, 100.0), kMiss);
  EXPECT_EQ(plane.intersect({{0, 0, 6}, {0, 0, -1}}, 5.0), kMiss) << "beyond the limit";
}

TEST(SimHeightField, FirstCrossingOfBumpsAgreesWithMarching) {
  const HeightField bumps(
      20.0, [](double x, double y) { return 0.8 * valueNoise(x / 2.0, y / 2.0, 5); },
      [](double, double) { return Material::kSoil; });
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    Vector3d origin = randomPoint(&random, 15.0);
    origin.z() = 1.2;
    Vector3d direction = randomUnit(&random);
    direction.z() = -0.12 * std::abs(direction.z());
    const double t = bumps.intersect({origin, direction}, 30.0);
    const double end = std::min(t, 30.0);
    for (double s = 0.0; s < end - 1e-6; s += 0.01) {
      const Vector3d p = origin + s * direction;
      if (p.head<2>().cwiseAbs().maxCoeff() > 20.0) break;
      ASSERT_GE(p.z() - bumps.height(p.x(), p.y()), -1e-6) << "went through at " << s;
    }
    if (t == kMiss) continue;
    const Vector3d p = origin + t * direction;
    ASSERT_NEAR(p.z(), bumps.height(p.x(), p.y()), 1e-6);
  }
}

Scene randomScene(uint64_t seed) {
  Random random(seed);
  Scene scene(HeightField(
      20.0, [](double x, double y) { return -3.0 + 0.5 * valueNoise(x, y, 9); },
      [](double, double) { return Material::kSoil; }));
  for (int model = 0; model < 4; ++model) {
    std::vector<Primitive> parts;
    for (int i = 0; i < 60; ++i) parts.push_back(randomPrimitive(&random));
    scene.addModel(std::move(parts));
  }
  for (int i = 0; i < 20; ++i) {
    const Vector3d p = randomPoint(&random, 10.0);
    const double yaw = random.uniform(-4.0, 4.0);
    const double scale = random.uniform(0.3, 2.0);
    scene.place(static_cast<uint32_t>(random.below(4)), {p, yaw, scale});
  }
  scene.finish();
  return scene;
}

TEST(SimScene, TreesOfBoxesGiveExactlyTheHitsOfBruteForce) {
  const Scene scene = randomScene(21);
  Random random(22);
  int hits = 0;
  for (int i = 0; i < 15000; ++i) {
    Ray ray{randomPoint(&random, 14.0), randomUnit(&random)};
    if (i % 10 == 0) ray.direction = Vector3d::Unit(random.below(3));  // parallel to faces
    const Hit fast = scene.castRay(ray, 25.0);
    const Hit slow = scene.castRayBruteForce(ray, 25.0);
    ASSERT_EQ(fast.range, slow.range) << "ray " << i;
    ASSERT_EQ(fast.rgb, slow.rgb);
    ASSERT_EQ(fast.truth, slow.truth);
    ASSERT_EQ(fast.incidence, slow.incidence);
    hits += fast.valid() ? 1 : 0;
  }
  EXPECT_GT(hits, 4000);
}

TEST(SimScene, PlacementTurnsScalesAndMoves) {
  Scene scene{HeightField()};
  const uint32_t model = scene.addModel({makeSphere({1, 0, 0}, 0.5, Material::kBark)});
  scene.place(model, {{10, 0, 0}, std::acos(-1.0) / 2.0, 2.0});
  scene.finish();  // a sphere of radius 1 at (10, 2, 0)
  const Hit hit = scene.castRay({{0, 2, 0}, {1, 0, 0}}, 50.0);
  EXPECT_NEAR(hit.range, 9.0, 1e-6);
  EXPECT_NEAR(hit.incidence, 1.0, 1e-6);
  EXPECT_EQ(hit.truth, Truth::kLinear);
  EXPECT_FALSE(scene.castRay({{0, 2, 0}, {1, 0, 0}}, 8.9).valid());
  EXPECT_NEAR(scene.reachBelow(model, 1.0), 1.58, 0.1);
}

}  // namespace
}  // namespace ladar_perception::sim
