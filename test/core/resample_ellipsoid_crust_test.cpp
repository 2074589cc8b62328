// SPDX-License-Identifier: BSD-3-Clause
// The paper's crust: cells inside ellipsoids around the nearest points.
#include <gtest/gtest.h>

#include <cmath>

#include "crust_checks.h"
#include "crust_clouds.h"
#include "ladar_perception/resample/crust.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::PlaneFrame;
using test::TestRandom;

constexpr int kNeighbors = 12;
const Vector3f kAbove(0, 0, 500);

Crust crustOf(const Cloud& cloud, const Vector3f& sensor = kAbove, int threads = 1,
              const std::vector<float>& weights = {}) {
  ThreadPool pool(threads);
  return makeEllipsoidCrust(sortIntoGrid(cloud, test::gridFrame(1.0)), weights, kNeighbors, sensor,
                            &pool);
}

/// Distance of the nearest point to every cell.
std::vector<double> distancesTo(const Cloud& cloud, const Crust& crust) {
  std::vector<double> distances;
  for (const Vector3f& position : crust.positions) {
    double least2 = 1e18;
    for (const Vector3d& p : cloud) {
      least2 = std::min(least2, (p - position.cast<double>()).squaredNorm());
    }
    distances.push_back(std::sqrt(least2));
  }
  return distances;
}

TEST(EllipsoidCrust, OfAPlaneIsOnePartOnIt) {
  TestRandom random(1);
  for (const double tilt : {0.0, 20.0, 54.7}) {
    const PlaneFrame plane({0, 0, 0.3}, test::tilted(tilt, 20.0));
    const Cloud cloud = test::patch(plane, 30, 30, 3000, 0.03, &random);
    const Vector3f sensor = (100.0 * plane.normal).cast<float>();
    const Crust crust = crustOf(cloud, sensor);
    test::expectSoundCrust(crust, sensor);
    EXPECT_EQ(test::countParts(crust), 1u);
    EXPECT_GT(crust.size(), 800u);
    EXPECT_LT(crust.size(), 3u * 900u);
    for (std::size_t i = 0; i < crust.size(); ++i) {
      ASSERT_NEAR(plane.height(crust.positions[i].cast<double>()), 0.0, 0.2);
      ASSERT_GT(crust.normals[i].cast<double>().dot(plane.normal), 0.9);
      ASSERT_EQ(crust.levels[i], 0);
    }
  }
}

TEST(EllipsoidCrust, HoldsTheMiddleOfEveryEllipsoid) {
  // The mean of a point and its nearest ones is in their ellipsoid, hence in a cell of the crust
  // or beside one whose middle is in it.
  TestRandom random(2);
  const Cloud cloud = test::patch({{0, 0, 0}, {1, 1, 2}}, 20, 20, 500, 0.1, &random);
  const Crust crust = crustOf(cloud);
  for (const Vector3d& p : cloud) {
    Cloud by_distance = cloud;
    std::sort(by_distance.begin(), by_distance.end(), [&](const Vector3d& a, const Vector3d& b) {
      return (a - p).squaredNorm() < (b - p).squaredNorm();
    });
    Vector3d mean = Vector3d::Zero();
    for (int i = 0; i < kNeighbors; ++i) mean += by_distance[std::size_t(i)] / kNeighbors;
    double least = 1e9;
    for (const uint64_t key : crust.keys) {
      least = std::min(least, (cubeCenter(key, 0).cast<double>() - mean).norm());
    }
    ASSERT_LT(least, 0.9);
  }
}

TEST(EllipsoidCrust, ReachesNoFartherThanTheLargestEllipsoid) {
  // The nearest of twelve points, on a circle of 100 cells, all have their mean in its middle.
  Cloud cloud;
  for (int i = 0; i < kNeighbors; ++i) {
    const double angle = 2.0 * M_PI * i / kNeighbors;
    cloud.emplace_back(100.0 * std::cos(angle), 100.0 * std::sin(angle), 0.5);
  }
  const Crust crust = crustOf(cloud);
  test::expectSoundCrust(crust, kAbove);
  EXPECT_EQ(test::countParts(crust), 1u);
  EXPECT_GT(crust.size(), 150u);  // one disc, as all ellipsoids are the same
  for (const uint64_t key : crust.keys) {
    ASSERT_LE((cubeCenter(key, 0) - Vector3f(0, 0, 0.5F)).norm(), kLargestEllipsoidCells + 0.01F);
  }
}

TEST(EllipsoidCrust, PatchesApartAreNotBridged) {
  TestRandom random(4);
  const Cloud left = test::patch({{0, 0, 0.5}, {0, 0, 1}}, 12, 12, 600, 0.03, &random);
  const Cloud right = test::patch({{40, 0, 0.5}, {0, 0, 1}}, 12, 12, 600, 0.03, &random);
  const Cloud cloud = test::joined(left, right);
  const Crust crust = crustOf(cloud);
  test::expectSoundCrust(crust, kAbove);
  EXPECT_EQ(test::countParts(crust), 2u);
  for (const double distance : distancesTo(cloud, crust)) ASSERT_LT(distance, 2.0);
}

TEST(EllipsoidCrust, AWireStaysALine) {
  TestRandom random(5);
  const Vector3d direction = Vector3d(1, 1, 1).normalized();
  const Crust crust = crustOf(test::segment(-20 * direction, 20 * direction, 400, 0.02, &random));
  test::expectSoundLinks(crust);
  EXPECT_EQ(test::countParts(crust), 1u);
  for (const Vector3f& position : crust.positions) {
    const Vector3d p = position.cast<double>();
    ASSERT_LT((p - p.dot(direction) * direction).norm(), 1.5);
  }
}

TEST(EllipsoidCrust, WeightsAreThoseOfThePoints) {
  TestRandom random(6);
  const Cloud cloud = test::patch({}, 40, 20, 4000, 0.03, &random);
  std::vector<float> weights;
  for (const Vector3d& p : cloud) weights.push_back(p.x() < 0.0 ? 0.25F : 1.0F);
  const Crust crust = crustOf(cloud, kAbove, 1, weights);
  for (std::size_t i = 0; i < crust.size(); ++i) {
    if (crust.positions[i].x() < -3.0F) {
      ASSERT_NEAR(crust.weight(i), 0.25F, 1e-4F);
    }
    if (crust.positions[i].x() > 3.0F) {
      ASSERT_NEAR(crust.weight(i), 1.0F, 1e-4F);
    }
  }
}

TEST(EllipsoidCrust, OfFewAndEqualPoints) {
  EXPECT_EQ(crustOf({}).size(), 0u);
  const Cloud three = {{0.5, 0.5, 0.5}, {1.5, 0.5, 0.5}, {0.5, 1.5, 0.5}};
  for (std::size_t count = 1; count <= 3; ++count) {
    const Cloud few(three.begin(), three.begin() + std::ptrdiff_t(count));
    const Crust crust = crustOf(few);
    test::expectSoundLinks(crust);
    ASSERT_GE(crust.size(), 1u) << count;
    EXPECT_EQ(test::countParts(crust), 1u);
    for (const double distance : distancesTo(few, crust)) EXPECT_LT(distance, 1.5);
  }
  const Cloud equal(100, Vector3d(3.5, 4.5, 5.5));
  const Crust crust = crustOf(equal);
  test::expectSoundLinks(crust);
  ASSERT_GE(crust.size(), 1u);
  for (const double distance : distancesTo(equal, crust)) EXPECT_LT(distance, 1.5);
}

TEST(EllipsoidCrust, IsTheSameForAnyNumberOfThreads) {
  TestRandom random(7);
  const Cloud cloud = test::joined(test::patch({{0, 0, 0}, {1, 2, 3}}, 40, 40, 5000, 0.2, &random),
                                   test::ball({0, 0, 20}, 10, 1000, &random));
  test::expectSameCrust(crustOf(cloud), crustOf(cloud, kAbove, 3));
}

}  // namespace
}  // namespace ladar_perception
