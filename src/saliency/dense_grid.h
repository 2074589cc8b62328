// SPDX-License-Identifier: BSD-3-Clause
// The dense voxel array of Lalonde et al. 2005: a record for every voxel, empty or not.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// Voxels with begin <= local index < end along x, y and z.
struct VoxelBox {
  int begin[3];
  int end[3];
};

/// Records of a map's window in local coordinates, z contiguous, then x, then y. The scan order of
/// all strategies on it is that of memory.
class DenseGrid {
 public:
  static constexpr uint32_t kEmpty = UINT32_MAX;

  void load(const VoxelMap& map);

  const MapShape& shape() const { return shape_; }
  std::size_t slotBound() const { return slot_bound_; }
  std::size_t memoryBytes() const {
    return records_.capacity() * sizeof(Moments) + slots_.capacity() * sizeof(uint32_t);
  }

  /// By z: the slot of the voxel in the map, or kEmpty. A scan for the occupied voxels reads these
  /// 4 bytes instead of the 64 of a record.
  LADAR_INLINE const uint32_t* slots(int x, int y) const {
    return slots_.data() + (static_cast<std::size_t>(y) * shape_.nx + x) * shape_.nz;
  }
  /// Box of the voxels up to r from (x, y, z), within the grid.
  LADAR_INLINE VoxelBox boxAround(int x, int y, int z, int r) const {
    return {{std::max(x - r, 0), std::max(y - r, 0), std::max(z - r, 0)},
            {std::min(x + r + 1, shape_.nx), std::min(y + r + 1, shape_.ny),
             std::min(z + r + 1, shape_.nz)}};
  }
  /// Visits and adds every voxel of the box. To test for empty ones first is slower, up to twice:
  /// it has to load the same line, and guesses wrong.
  LADAR_INLINE Moments sum(const VoxelBox& box) const {
    Moments sum;
    for (int y = box.begin[1]; y < box.end[1]; ++y) {
      for (int x = box.begin[0]; x < box.end[0]; ++x) {
        const Moments* column = records_.data() + y * row_stride_ + x * column_stride_;
        // Runs are too short for the exit of a loop to be foreseen.
#pragma GCC unroll 8
        for (int z = box.begin[2]; z < box.end[2]; ++z) sum += column[z];
      }
    }
    return sum;
  }

 private:
  MapShape shape_;
  std::size_t slot_bound_ = 0;
  // Odd numbers of cache lines: with a power of two the columns of a box evict each other.
  std::size_t column_stride_ = 0;
  std::size_t row_stride_ = 0;
  std::vector<Moments> records_;
  std::vector<uint32_t> slots_;
};

}  // namespace ladar_perception
