// SPDX-License-Identifier: BSD-3-Clause
// Sets of a map's columns, as one bit per column.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {

/// A set of columns in local coordinates: row y is `words()` 64-bit words, bit x of them is column
/// (x, y).
class ColumnSet {
 public:
  /// Empties the set.
  void resize(int nx, int ny);

  int words() const { return words_; }
  const uint64_t* row(int y) const { return bits_.data() + static_cast<std::size_t>(y) * words_; }
  void add(int x, int y) { rowOf(y)[x / 64] |= uint64_t{1} << (x % 64); }
  bool contains(int x, int y) const { return bit_mask::test(row(y), x); }
  /// Number of columns in the set.
  std::size_t size() const;

  /// Every column.
  void assignAll(int nx, int ny);
  /// Every column whose box sums can be other than before the map's `changedColumns`: those within
  /// `radius` of one, along x and along y.
  template <typename Map>
  void assignAffected(const Map& map, int radius) {
    assignAffected(map.changedColumns(), map.minCorner(), map.shape(), radius);
  }
  /// The columns within `radius` of one of `other`, along x and along y.
  void assignDilated(const ColumnSet& other, int radius);
  /// The columns of `other`, too, which is of as many rows and columns.
  void add(const ColumnSet& other);

 private:
  uint64_t* rowOf(int y) { return bits_.data() + static_cast<std::size_t>(y) * words_; }
  void assignAffected(const std::vector<ColumnIndex>& changed, const VoxelIndex& min,
                      const MapShape& shape, int radius);

  int nx_ = 0;
  int ny_ = 0;
  int words_ = 0;
  std::vector<uint64_t> bits_;
};

/// `out` gets the bits of `in` and those within `radius` of one; both have `words` words, and bits
/// moved out of them are lost. `out` is not `in`.
void dilateBits(const uint64_t* in, int words, int radius, uint64_t* out);

}  // namespace ladar_perception
