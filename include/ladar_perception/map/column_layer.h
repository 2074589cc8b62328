// SPDX-License-Identifier: BSD-3-Clause
// What a voxel's surroundings look like from above: one number per column of a map.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {

/// What a layer tells of the square of columns around one.
enum class ColumnQuantity {
  /// World height index of the lowest occupied voxel in the square.
  kLowest,
  /// The ground under the column as a morphological opening has it: the highest of the lowest
  /// heights of all squares, around columns of the map, that the column is in. On any even slope it
  /// is the slope itself (but for what lies uphill at the map's edge, within the radius), where
  /// kLowest is as far below as the slope falls within the square.
  kGround,
  /// Occupied voxels per occupied column of the square, times kFillUnit, rounded down.
  kFill,
};
constexpr int32_t kFillUnit = 256;

/// A number for every column, about the columns up to `radius` away along x and y.
class ColumnLayer {
 public:
  /// Of columns that have nothing in their square.
  static constexpr int32_t kNothing = INT32_MAX;

  ColumnLayer(ColumnQuantity quantity, int radius) : quantity_(quantity), radius_(radius) {}

  ColumnQuantity quantity() const { return quantity_; }
  int radius() const { return radius_; }
  std::size_t memoryBytes() const;

  /// Computes the layer anew. `changed(x, y)` is called for every occupied column whose value is
  /// another than after the last call, in local coordinates. Work per column does not grow with
  /// the radius but by its logarithm.
  template <typename Changed>
  void update(const VoxelMap& map, Changed&& changed);
  /// Value of a column, in local coordinates.
  int32_t at(int x, int y) const { return values_[static_cast<std::size_t>(y) * nx_ + x]; }

 private:
  void compute(const VoxelMap& map);

  ColumnQuantity quantity_;
  int radius_;
  int nx_ = 0;
  std::vector<int32_t> values_;  // by local y, then x
  std::vector<int32_t> before_;  // by ring column
  std::vector<int32_t> scratch_;
  std::vector<int32_t> counts_;
};

template <typename Changed>
void ColumnLayer::update(const VoxelMap& map, Changed&& changed) {
  compute(map);
  const MapShape& shape = map.shape();
  before_.resize(values_.size(), kNothing);
  for (int y = 0; y < shape.ny; ++y) {
    for (int x = 0; x < shape.nx; ++x) {
      const int column = map.columnAt(x, y);
      const int32_t value = at(x, y);
      if (before_[column] == value) continue;
      before_[column] = value;
      if (map.recordCount(column) > 0) changed(x, y);
    }
  }
}

}  // namespace ladar_perception
