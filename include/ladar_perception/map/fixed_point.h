// SPDX-License-Identifier: BSD-3-Clause
// World positions as integers: the map stores and sums nothing else, so that sums are exact.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// Quantisation steps per voxel edge (0.39 mm at 10 cm voxels).
constexpr int64_t kStepsPerVoxel = 256;
constexpr int kStepsPerVoxelLog2 = 8;
/// Positions farther from the map's origin than this are refused, so that indices stay exact.
constexpr double kMaxCoordinate_m = 1e7;
/// Smallest voxel: indices of kMaxCoordinate_m still fit into 32 bits.
constexpr double kMinVoxelSize_m = 0.01;

/// A position in steps of voxel_size / kStepsPerVoxel from the origin of the map frame.
struct FixedPoint {
  int64_t x = 0;
  int64_t y = 0;
  int64_t z = 0;
};

/// Index of a voxel in the map frame; voxel i covers [i, i + 1) voxel sizes along each axis.
struct VoxelIndex {
  int32_t x = 0;
  int32_t y = 0;
  int32_t z = 0;

  bool operator==(const VoxelIndex& other) const {
    return x == other.x && y == other.y && z == other.z;
  }
  bool operator!=(const VoxelIndex& other) const { return !(*this == other); }
};

/// Largest integer not above `value`; a cast alone would round negatives towards zero.
LADAR_INLINE int64_t floorToInt(double value) {
  const auto truncated = static_cast<int64_t>(value);
  return truncated - (value < static_cast<double>(truncated) ? 1 : 0);
}

/// `p_map` in metres, each |coordinate| <= kMaxCoordinate_m; `steps_per_m` = 256 / voxel size.
LADAR_INLINE FixedPoint toFixedPoint(const Eigen::Vector3d& p_map, double steps_per_m) {
  return {floorToInt(p_map.x() * steps_per_m), floorToInt(p_map.y() * steps_per_m),
          floorToInt(p_map.z() * steps_per_m)};
}

/// The voxel a position lies in. Shifting a negative integer right is a floor on every compiler
/// this package supports (and by rule from C++20 on).
LADAR_INLINE VoxelIndex voxelOf(const FixedPoint& q) {
  return {static_cast<int32_t>(q.x >> kStepsPerVoxelLog2),
          static_cast<int32_t>(q.y >> kStepsPerVoxelLog2),
          static_cast<int32_t>(q.z >> kStepsPerVoxelLog2)};
}

}  // namespace ladar_perception
