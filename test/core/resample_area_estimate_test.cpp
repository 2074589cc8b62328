// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "crust_clouds.h"
#include "ladar_perception/resample/area_estimate.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::Cloud;
using test::TestRandom;

double areaOf(const Cloud& cloud, double cell_m, const std::vector<float>& weights = {}) {
  const AreaEstimate estimate(sortIntoGrid(cloud, test::gridFrame(cell_m)), weights);
  return estimate.area_m2(std::numeric_limits<double>::max());
}

TEST(ResampleAreaEstimate, OfTooFewPointsIsNothing) {
  EXPECT_EQ(areaOf({}, 0.1), 0.0);
  EXPECT_EQ(areaOf({{1, 2, 3}}, 0.1), 0.0);
  EXPECT_EQ(areaOf({{1, 2, 3}, {1, 2, 4}, {5, 2, 3}}, 0.1), 0.0);
}

TEST(ResampleAreaEstimate, OfPlanes) {
  // An estimate to start from: within a third.
  for (const double tilt : {0.0, 20.0, 45.0, 54.7}) {
    for (const std::size_t count : {3000u, 30000u}) {
      TestRandom random(7);
      const test::PlaneFrame plane({3.3, 4.4, 5.5}, test::tilted(tilt, 30.0));
      const Cloud cloud = test::patch(plane, 12.0, 8.0, count, 0.0, &random);
      EXPECT_NEAR(areaOf(cloud, 0.02) / 96.0, 1.0, 0.33) << tilt << " " << count;
    }
  }
}

TEST(ResampleAreaEstimate, GrowsWithTheSquareOfTheCell) {
  TestRandom random(8);
  const Cloud small = test::patch({}, 10.0, 10.0, 4000, 0.0, &random);
  Cloud large = small;
  for (Vector3d& p : large) p *= 8.0;
  EXPECT_NEAR(areaOf(large, 0.8), 64.0 * areaOf(small, 0.1), 1e-6 * areaOf(large, 0.8));
}

TEST(ResampleAreaEstimate, IsSharedByPointsAsTheirWeights) {
  TestRandom random(9);
  const Cloud near = test::patch({}, 10.0, 10.0, 4000, 0.0, &random);
  const Cloud far =
      test::patch({Vector3d(500, 500, 0), Vector3d(0, 0, 1)}, 10.0, 10.0, 4000, 0.0, &random);
  const double near_m2 = areaOf(near, 0.1);
  const double far_m2 = areaOf(far, 0.1);
  const Cloud both = test::joined(near, far);
  EXPECT_NEAR(areaOf(both, 0.1), near_m2 + far_m2, 1e-9 * near_m2);
  std::vector<float> weights(both.size(), 1.0F);
  EXPECT_NEAR(areaOf(both, 0.1, weights), near_m2 + far_m2, 1e-9 * near_m2);
  std::fill(weights.begin() + 4000, weights.end(), 0.25F);
  EXPECT_NEAR(areaOf(both, 0.1, weights), near_m2 + 0.25 * far_m2, 1e-6 * near_m2);
  std::fill(weights.begin() + 4000, weights.end(), 0.0F);
  EXPECT_NEAR(areaOf(both, 0.1, weights), near_m2, 1e-6 * near_m2);
}

TEST(ResampleAreaEstimate, DuplicatesCountAsTheCellTheyAreIn) {
  const Cloud cloud(1000, Vector3d(0.05, 0.05, 0.05));
  EXPECT_LT(areaOf(cloud, 0.1), 0.02);
  EXPECT_GT(areaOf(cloud, 0.1), 0.0);
}

/// Points too far apart for a crust of such cells are pieces of their own.
TEST(ResampleAreaEstimate, OfPointsApartIsThatOfTheirPieces) {
  Cloud cloud;
  for (int x = 0; x < 40; ++x) {
    for (int y = 0; y < 40; ++y) cloud.emplace_back(2.0 * x, 2.0 * y, 0.0);
  }
  const AreaEstimate estimate(sortIntoGrid(cloud, test::gridFrame(0.05)), {});
  // 80 m x 80 m for cells that bridge 2 m, a disc of 0.75 cells radius around each for those that
  // do not.
  EXPECT_NEAR(estimate.area_m2(2.0) / 6400.0, 1.0, 0.33);
  const double piece_m2 = M_PI * std::pow(0.75 * 0.1, 2);
  EXPECT_NEAR(estimate.area_m2(0.1) / (1600 * piece_m2), 1.0, 0.05);
  double before = 0.0;
  for (double cell_m = 0.01; cell_m < 3.0; cell_m *= 1.1) {
    EXPECT_GE(estimate.area_m2(cell_m), before);
    before = estimate.area_m2(cell_m);
  }
}

/// A crust bridges gaps where points lie in a plane, and not in foliage as sparse.
TEST(ResampleAreaEstimate, OfSparsePointsDependsOnWhetherTheyLieInAPlane) {
  TestRandom random(11);
  constexpr std::size_t kPoints = 25600;
  const Cloud plane =
      test::patch({Vector3d(0, 0, 0.025), Vector3d(0, 0, 1)}, 80.0, 80.0, kPoints, 0.005, &random);
  const Cloud foliage = test::patch({}, 80.0, 80.0, kPoints, 3.0, &random);
  const auto estimated = [](const Cloud& cloud) {
    return AreaEstimate(sortIntoGrid(cloud, test::gridFrame(0.05)), {}).area_m2(0.1);
  };
  EXPECT_NEAR(estimated(plane) / 6400.0, 1.0, 0.33);
  const double piece_m2 = M_PI * std::pow(0.75 * 0.1, 2);
  EXPECT_NEAR(estimated(foliage) / (kPoints * piece_m2), 1.0, 0.2);
}

TEST(ResampleAreaEstimate, FewerPointsStandForAll) {
  TestRandom random(10);
  const Cloud cloud = test::patch({}, 10.0, 10.0, 40000, 0.0, &random);
  const GridFrame frame = test::gridFrame(0.02);
  const AreaEstimate all(sortIntoGrid(cloud, frame), {});
  const AreaEstimate fourth(sortIntoGrid(cloud, frame, 4), {}, 4);
  for (const double cell_m : {0.002, 0.2}) {
    EXPECT_NEAR(fourth.area_m2(cell_m) / all.area_m2(cell_m), 1.0, 0.25) << cell_m;
  }
}

}  // namespace
}  // namespace ladar_perception
