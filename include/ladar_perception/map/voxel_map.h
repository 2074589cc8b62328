// SPDX-License-Identifier: BSD-3-Clause
// The scrolling voxel map: a window of the world that holds the moments of the points seen in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/moments.h"
#include "ladar_perception/map/record_arena.h"

namespace ladar_perception {

/// Voxels along each axis of the window.
struct MapShape {
  int nx = 0;
  int ny = 0;
  int nz = 0;
};

/// Names an inserted point's voxel until the window scrolls: column * nz + height.
using CellId = uint32_t;
constexpr CellId kNoCell = UINT32_MAX;

/// Column-compact voxel map after the idea of a scrolling 2-D grid.
///
/// A column (x, y) is a mask of its occupied voxels and a run of their records sorted by z; the
/// record of height z is at rank popcount(mask below z). Columns are ring-indexed by world
/// coordinates, so scrolling in x and y moves nothing: it clears the columns that left. Scrolling
/// in z shifts the masks. Memory follows the occupied voxels (2 to 7 % in real scenes).
class VoxelMap {
 public:
  /// `shape` has 1 to 4096 voxels along x and y and 1 to 1024 along z;
  /// a voxel takes no more than `max_points_per_voxel` points.
  VoxelMap(const MapShape& shape, uint32_t max_points_per_voxel);

  const MapShape& shape() const { return shape_; }
  /// World index of the window's lowest voxel.
  const VoxelIndex& minCorner() const { return min_; }
  std::size_t occupied() const { return occupied_; }
  std::size_t memoryBytes() const;

  /// Moves the window. Voxels in both windows keep their records, the others are forgotten.
  void scrollTo(const VoxelIndex& min_corner);
  /// Forgets every point; the window stays.
  void clear();

  enum class InsertResult : uint8_t { kInserted, kOutside, kSaturated };
  /// Adds a point. `*cell` is its voxel (also when saturated), or kNoCell outside the window.
  InsertResult insert(const FixedPoint& q, CellId* cell);

  /// Records of a voxel, or nullptr if it is empty or outside.
  const Moments* find(const VoxelIndex& voxel) const;

  // Access by column, for the passes over the whole map. Local coordinates run from 0 at the
  // window's lowest corner; `column` is the ring index they map to.
  int columnCount() const { return shape_.nx * shape_.ny; }
  int columnAt(int x_local, int y_local) const {
    return wrap(x_local + ring_x_, shape_.nx) + shape_.nx * wrap(y_local + ring_y_, shape_.ny);
  }
  int maskWords() const { return words_; }
  const uint64_t* mask(int column) const {
    return masks_.data() + static_cast<std::size_t>(column) * words_;
  }
  int recordCount(int column) const { return runs_[column].count; }
  /// recordCount(column) records by ascending z.
  const Moments* records(int column) const { return arena_.records(runs_[column]); }

  int columnOf(CellId cell) const { return static_cast<int>(cell / shape_.nz); }
  /// Position of the cell's record among its column's records.
  int rankOf(CellId cell) const {
    return rank(mask(columnOf(cell)), static_cast<int>(cell % shape_.nz));
  }

 private:
  static int wrap(int i, int n) { return i < n ? i : i - n; }
  static int rank(const uint64_t* mask, int z);

  uint64_t* maskOf(int column) { return masks_.data() + static_cast<std::size_t>(column) * words_; }
  void clearColumn(int column);
  void clearColumns(int x_begin, int x_end, int y_begin, int y_end);
  void scrollHeight(int dz);
  void setMin(const VoxelIndex& min_corner);

  MapShape shape_;
  uint32_t max_points_per_voxel_;
  int words_;  // 64-bit words of a column's mask
  VoxelIndex min_;
  int ring_x_ = 0;  // ring index of the window's lowest x
  int ring_y_ = 0;
  std::size_t occupied_ = 0;
  std::vector<uint64_t> masks_;
  std::vector<RecordArena::Run> runs_;
  RecordArena arena_;
};

}  // namespace ladar_perception
