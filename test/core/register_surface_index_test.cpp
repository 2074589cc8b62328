// SPDX-License-Identifier: BSD-3-Clause
// Searches that remember, against all points one by one.
#include <gtest/gtest.h>

#include "../../src/register/surface_index.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3f;

struct Points {
  std::vector<Vector3f> positions;
  std::vector<Vector3f> normals;
};

Points randomPoints(std::size_t count, float extent_m, test::TestRandom* random) {
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    points.positions.push_back(extent_m * random->normal3().cast<float>());
    points.normals.push_back(random->normal3().normalized().cast<float>());
  }
  return points;
}

int nearestOfAll(const Points& points, const Vector3f& position, float radius_squared) {
  int nearest = SurfaceIndex::kNone;
  float least = radius_squared;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const float squared = (points.positions[i] - position).squaredNorm();
    if (squared >= least) continue;
    least = squared;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

/// Searches for a point that moves by steps of `step_m` while the radius changes.
void expectNearest(const Points& points, float step_m, test::TestRandom* random) {
  const SurfaceIndex index(points.positions, points.normals, false);
  for (int walk = 0; walk < 50; ++walk) {
    SurfaceIndex::Memory memory;
    Vector3f position = random->normal3().cast<float>();
    for (int step = 0; step < 40; ++step) {
      const auto radius_m = static_cast<float>(random->real(0.05, 1.0));
      ASSERT_EQ(index.nearest(position, Vector3f::UnitZ(), radius_m * radius_m, &memory),
                nearestOfAll(points, position, radius_m * radius_m))
          << walk << " " << step;
      position += step_m * random->normal3().cast<float>();
    }
  }
}

TEST(SurfaceIndex, FindsTheNearestHoweverThePointMoves) {
  test::TestRandom random(1);
  const Points points = randomPoints(500, 1.0F, &random);
  for (const float step_m : {0.0F, 1e-5F, 1e-3F, 0.02F, 0.3F, 3.0F}) {
    expectNearest(points, step_m, &random);
  }
}

TEST(SurfaceIndex, FindsTheNearestOfFew) {
  test::TestRandom random(2);
  for (const std::size_t count : {0U, 1U, 2U, 3U}) {
    expectNearest(randomPoints(count, 0.3F, &random), 0.1F, &random);
  }
}

TEST(SurfaceIndex, RemembersNothingWrongWhereNormalsTurn) {
  test::TestRandom random(3);
  const Points points = randomPoints(2000, 1.0F, &random);
  const SurfaceIndex index(points.positions, points.normals, true);
  for (int walk = 0; walk < 50; ++walk) {
    SurfaceIndex::Memory memory;
    Vector3f position = random.normal3().cast<float>();
    Vector3f normal = random.normal3().normalized().cast<float>();
    for (int step = 0; step < 40; ++step) {
      SurfaceIndex::Memory none;
      EXPECT_EQ(index.nearest(position, normal, 0.25F, &memory),
                index.nearest(position, normal, 0.25F, &none));
      position += 0.01F * random.normal3().cast<float>();
      normal = (normal + 0.2F * random.normal3().cast<float>()).normalized();
    }
  }
}

/// A kilometre from the origin floats are steps of 0.06 mm.
TEST(SurfaceIndex, RemembersNothingWrongFarAway) {
  test::TestRandom random(4);
  Points points = randomPoints(300, 0.5F, &random);
  for (Vector3f& p : points.positions) p += Vector3f(1000.0F, -1000.0F, 100.0F);
  const SurfaceIndex index(points.positions, points.normals, false);
  SurfaceIndex::Memory memory;
  Vector3f position(1000.0F, -1000.0F, 100.0F);
  for (int step = 0; step < 2000; ++step) {
    ASSERT_EQ(index.nearest(position, Vector3f::UnitZ(), 1.0F, &memory),
              nearestOfAll(points, position, 1.0F));
    position += 1e-3F * random.normal3().cast<float>();
  }
}

}  // namespace
}  // namespace ladar_perception
