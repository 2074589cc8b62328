// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/column_mask.h"

#include <algorithm>

#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

int coordinate(uint64_t key, int axis) { return static_cast<int>(morton::compact(key >> axis)); }

}  // namespace

ColumnMask columnsWithPoints(const VoxelPyramid& pyramid, int level, uint32_t voxel, int u, int v) {
  const VoxelLevel& voxels = pyramid.level(level);
  const VoxelLevel& halves = pyramid.level(level - 1);
  const std::vector<uint64_t>& quarters = pyramid.level(level - 2).grid.keys();
  const auto firstQuarter = [&](uint32_t of) {
    return of < voxels.grid.size() ? halves.first_child[voxels.first_child[of]]
                                   : static_cast<uint32_t>(quarters.size());
  };
  const uint64_t key = voxels.grid.keys()[voxel];
  const int low_u = 4 * (coordinate(key, u) - 1);
  const int low_v = 4 * (coordinate(key, v) - 1);
  ColumnMask mask{};
  for (int step = 0; step < 27; ++step) {
    const uint32_t near = voxels.grid.find(morton::around(key, step));
    if (near == kNoIndex) continue;
    for (uint32_t i = firstQuarter(near); i < firstQuarter(near + 1); ++i) {
      mask[static_cast<std::size_t>(coordinate(quarters[i], v) - low_v)] |=
          uint32_t{1} << (coordinate(quarters[i], u) - low_u);
    }
  }
  return mask;
}

ColumnMask closeGaps(const ColumnMask& mask) {
  constexpr int kMargin = kOpenColumns - 1;  // squares reach so far out of the mask
  std::array<uint32_t, kMaskEdge + 2 * kMargin> open{};
  for (int row = -kMargin; row < kMaskEdge; ++row) {
    uint32_t free = ~uint32_t{0};  // in all rows of the squares that begin in this one
    for (int k = std::max(row, 0); k < std::min(row + kOpenColumns, kMaskEdge); ++k) {
      free &= ~(mask[static_cast<std::size_t>(k)] << kMargin);
    }
    uint32_t corners = free;
    for (int k = 1; k < kOpenColumns; ++k) corners &= free >> k;
    uint32_t squares = corners;
    for (int k = 1; k < kOpenColumns; ++k) squares |= corners << k;
    for (int k = row; k < row + kOpenColumns; ++k) {
      open[static_cast<std::size_t>(k + kMargin)] |= squares;
    }
  }
  ColumnMask closed;
  for (std::size_t row = 0; row < closed.size(); ++row) {
    closed[row] = ~(open[row + kMargin] >> kMargin) & ((uint32_t{1} << kMaskEdge) - 1);
  }
  return closed;
}

}  // namespace ladar_perception
