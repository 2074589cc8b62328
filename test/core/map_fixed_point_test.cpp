// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "ladar_perception/map/fixed_point.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::TestRandom;

TEST(FloorToInt, RoundsDownOnBothSidesOfZero) {
  EXPECT_EQ(floorToInt(0.0), 0);
  EXPECT_EQ(floorToInt(-0.0), 0);
  EXPECT_EQ(floorToInt(2.0), 2);
  EXPECT_EQ(floorToInt(2.999), 2);
  EXPECT_EQ(floorToInt(-1e-300), -1);
  EXPECT_EQ(floorToInt(-2.0), -2);
  EXPECT_EQ(floorToInt(-2.001), -3);
}

TEST(FloorToInt, EqualsFloorForRandomNumbers) {
  TestRandom random(1);
  for (int i = 0; i < 100000; ++i) {
    const double value = random.real(-1.0, 1.0) * std::pow(10.0, random.real(-3.0, 12.0));
    EXPECT_EQ(floorToInt(value), static_cast<int64_t>(std::floor(value))) << value;
  }
}

TEST(VoxelOf, VoxelCoversItsLowerFaceAndNotItsUpper) {
  for (const int64_t voxel : {-100000000, -257, -2, -1, 0, 1, 255, 100000000}) {
    const int64_t low = voxel * kStepsPerVoxel;
    for (const int64_t step : {int64_t{0}, int64_t{1}, int64_t{128}, kStepsPerVoxel - 1}) {
      const VoxelIndex index = voxelOf({low + step, low, low + kStepsPerVoxel - 1});
      EXPECT_EQ(index.x, voxel);
      EXPECT_EQ(index.y, voxel);
      EXPECT_EQ(index.z, voxel);
    }
    EXPECT_EQ(voxelOf({low - 1, 0, 0}).x, voxel - 1);
    EXPECT_EQ(voxelOf({low + kStepsPerVoxel, 0, 0}).x, voxel + 1);
  }
}

TEST(ToFixedPoint, FallsIntoTheVoxelOfThePosition) {
  const double steps_per_m = 256.0 / 0.1;
  const VoxelIndex near = voxelOf(toFixedPoint(Vector3d(0.05, -0.05, -1e-9), steps_per_m));
  EXPECT_EQ(near, (VoxelIndex{0, -1, -1}));
  const VoxelIndex far =
      voxelOf(toFixedPoint(Vector3d(1e6 + 0.05, -1e6 + 0.05, 0.25), steps_per_m));
  EXPECT_EQ(far, (VoxelIndex{10000000, -10000000, 2}));
}

TEST(ToFixedPoint, AMillionMetresAwayStepsAreStillExact) {
  const double steps_per_m = 256.0 / 0.1;
  TestRandom random(2);
  for (int i = 0; i < 10000; ++i) {
    // Middles of steps: no rounding of the sum can cross to the next step.
    const int64_t step = random.integer(-100000, 100000);
    const double p = (static_cast<double>(step) + 0.5) / steps_per_m;
    const int64_t shift = 2560000000;
    const FixedPoint near = toFixedPoint(Vector3d(p, p, p), steps_per_m);
    const FixedPoint far = toFixedPoint(Vector3d(p + 1e6, p - 1e6, p + 1e6), steps_per_m);
    EXPECT_EQ(near.x, step);
    EXPECT_EQ(far.x, step + shift);
    EXPECT_EQ(far.y, step - shift);
    EXPECT_EQ(far.z, step + shift);
  }
}

TEST(ToFixedPoint, TheFarthestCoordinateFitsTheIndexAtTheSmallestVoxel) {
  const double steps_per_m = 256.0 / kMinVoxelSize_m;
  for (const double p : {-kMaxCoordinate_m, kMaxCoordinate_m}) {
    const VoxelIndex index = voxelOf(toFixedPoint(Vector3d(p, p, p), steps_per_m));
    EXPECT_NEAR(index.x * kMinVoxelSize_m, p, 2 * kMinVoxelSize_m);
    EXPECT_EQ(index.x, index.z);
  }
}

}  // namespace
}  // namespace ladar_perception
