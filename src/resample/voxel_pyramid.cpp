// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/voxel_pyramid.h"

#include <algorithm>

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

std::vector<uint32_t> unchangedBricks(const VoxelLevel& now, const VoxelLevel& before) {
  const std::vector<SparseGrid::Brick>& bricks = now.grid.bricks();
  std::vector<uint32_t> unchanged(bricks.size(), kNoIndex);
  std::vector<uint64_t> gone;
  auto old = before.grid.bricks().begin();
  const auto skipTo = [&](uint64_t key) {
    for (; old != before.grid.bricks().end() && old->key < key; ++old) gone.push_back(old->key);
  };
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    skipTo(bricks[i].key);
    if (old == before.grid.bricks().end() || old->key != bricks[i].key) continue;
    const auto first = now.sums.begin() + bricks[i].first;
    const auto last = now.sums.begin() + now.grid.brickEnd(i);
    if (old->mask == bricks[i].mask && std::equal(first, last, before.sums.begin() + old->first)) {
      unchanged[i] = old->first;
    }
    ++old;
  }
  skipTo(~uint64_t{0});
  for (const uint64_t key : gone) {
    for (int step = 0; step < 27; ++step) {
      const uint32_t near = now.grid.findBrick(morton::around(key, step));
      if (near != kNoIndex) unchanged[near] = kNoIndex;
    }
  }
  return unchanged;
}

VoxelPyramid::VoxelPyramid(const GridPoints& points, const std::vector<float>& weights,
                           int levels) {
  levels_.push_back(groupPoints(points, weights));
  while (this->levels() < levels) {
    levels_.push_back(groupVoxels(levels_.back(), this->levels() - 1));
  }
}

}  // namespace ladar_perception
