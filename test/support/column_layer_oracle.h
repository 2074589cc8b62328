// SPDX-License-Identifier: BSD-3-Clause
// Layers of columns by their definition, column by column.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "ladar_perception/map/column_layer.h"

namespace ladar_perception::test {

class ColumnLayerOracle {
 public:
  explicit ColumnLayerOracle(const VoxelMap& map)
      : nx_(map.shape().nx),
        ny_(map.shape().ny),
        lowest_(static_cast<std::size_t>(nx_) * ny_, kNothing),
        occupied_(lowest_.size(), 0) {
    const VoxelIndex& min = map.minCorner();
    map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t /*slot*/) {
      const std::size_t i = index(voxel.x - min.x, voxel.y - min.y);
      lowest_[i] = std::min(lowest_[i], voxel.z);
      ++occupied_[i];
    });
  }

  int32_t at(ColumnQuantity quantity, int radius, int x, int y) const {
    std::vector<int32_t>& values = kept_[{quantity, radius}];
    if (values.empty()) values.resize(lowest_.size(), kNotYet);
    int32_t& value = values[index(x, y)];
    if (value == kNotYet) value = compute(quantity, radius, x, y);
    return value;
  }
  bool isOccupied(int x, int y) const { return occupied_[index(x, y)] > 0; }

 private:
  static constexpr int32_t kNothing = ColumnLayer::kNothing;
  static constexpr int32_t kNotYet = INT32_MIN;

  int32_t compute(ColumnQuantity quantity, int radius, int x, int y) const {
    switch (quantity) {
      case ColumnQuantity::kLowest:
        return lowest(radius, x, y);
      case ColumnQuantity::kGround:
        return ground(radius, x, y);
      case ColumnQuantity::kFill:
        return fill(radius, x, y);
    }
    return kNothing;
  }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * nx_ + x; }
  /// Calls `visit(x, y)` for every column of the map in the square.
  template <typename Visitor>
  void forSquare(int radius, int x, int y, const Visitor& visit) const {
    for (int j = std::max(y - radius, 0); j <= std::min(y + radius, ny_ - 1); ++j) {
      for (int i = std::max(x - radius, 0); i <= std::min(x + radius, nx_ - 1); ++i) visit(i, j);
    }
  }
  int32_t lowest(int radius, int x, int y) const {
    int32_t least = kNothing;
    forSquare(radius, x, y, [&](int i, int j) { least = std::min(least, lowest_[index(i, j)]); });
    return least;
  }
  /// Each of the squares that a column is in is around one of the columns of its own square.
  int32_t ground(int radius, int x, int y) const {
    int32_t greatest = kNothing;
    forSquare(radius, x, y, [&](int i, int j) {
      const int32_t least = at(ColumnQuantity::kLowest, radius, i, j);
      if (least == kNothing) return;
      greatest = greatest == kNothing ? least : std::max(greatest, least);
    });
    return greatest;
  }
  int32_t fill(int radius, int x, int y) const {
    int64_t voxels = 0;
    int64_t columns = 0;
    forSquare(radius, x, y, [&](int i, int j) {
      voxels += occupied_[index(i, j)];
      columns += occupied_[index(i, j)] > 0 ? 1 : 0;
    });
    return columns > 0 ? static_cast<int32_t>(kFillUnit * voxels / columns) : kNothing;
  }

  int nx_;
  int ny_;
  std::vector<int32_t> lowest_;
  std::vector<int32_t> occupied_;  // voxels of the column
  mutable std::map<std::pair<ColumnQuantity, int>, std::vector<int32_t>> kept_;
};

}  // namespace ladar_perception::test
