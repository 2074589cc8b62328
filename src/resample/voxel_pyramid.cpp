// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/voxel_pyramid.h"

#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

VoxelLevel groupPoints(const GridPoints& points, const std::vector<float>& weights) {
  VoxelLevel level;
  std::vector<uint64_t> keys;
  keys.reserve(points.size());
  level.sums.reserve(points.size());
  level.first_child.reserve(points.size());
  uint64_t brick = ~uint64_t{0};
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const uint64_t key = points.keys[i];
    if (keys.empty() || keys.back() != key) {
      if (key >> 6 != brick) {
        brick = key >> 6;
        center = brickCenter(brick, 0);
      }
      keys.push_back(key);
      level.sums.emplace_back();
      level.first_child.push_back(static_cast<uint32_t>(i));
    }
    level.sums.back().add(points.positions[i] - center,
                          weights.empty() ? 1.0F : weights[points.sources[i]]);
  }
  level.first_point = level.first_child;
  level.first_point.push_back(static_cast<uint32_t>(points.size()));
  level.grid.assign(std::move(keys));
  level.grid.linkBricks();
  return level;
}

VoxelLevel groupVoxels(const VoxelLevel& below, int below_level) {
  VoxelLevel level;
  std::vector<uint64_t> keys;
  const std::vector<uint64_t>& child_keys = below.grid.keys();
  uint64_t brick = ~uint64_t{0};
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();
  for (std::size_t i = 0; i < child_keys.size(); ++i) {
    const uint64_t key = child_keys[i] >> 3;
    if (keys.empty() || keys.back() != key) {
      keys.push_back(key);
      level.sums.emplace_back();
      level.first_child.push_back(static_cast<uint32_t>(i));
      level.first_point.push_back(below.first_point[i]);
    }
    if (child_keys[i] >> 6 != brick) {
      brick = child_keys[i] >> 6;
      offset = brickCenter(brick, below_level) - brickCenter(key >> 6, below_level + 1);
    }
    level.sums.back().add(below.sums[i].movedBy(offset));
  }
  level.first_point.push_back(below.first_point.back());
  level.grid.assign(std::move(keys));
  level.grid.linkBricks();
  return level;
}

}  // namespace

VoxelPyramid::VoxelPyramid(const GridPoints& points, const std::vector<float>& weights,
                           int levels) {
  levels_.push_back(groupPoints(points, weights));
  while (this->levels() < levels) {
    levels_.push_back(groupVoxels(levels_.back(), this->levels() - 1));
  }
}

}  // namespace ladar_perception
