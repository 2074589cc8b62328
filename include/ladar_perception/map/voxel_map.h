// SPDX-License-Identifier: BSD-3-Clause
// The scrolling voxel map: a window of the world that holds the moments of the points seen in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/bit_mask.h"
#include "ladar_perception/map/moments.h"
#include "ladar_perception/map/record_arena.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// Voxels along each axis of the window.
struct MapShape {
  int nx = 0;
  int ny = 0;
  int nz = 0;
};

/// Names an inserted point's voxel until the window scrolls.
using CellId = uint32_t;
constexpr CellId kNoCell = UINT32_MAX;

/// World indices of a column of voxels.
struct ColumnIndex {
  int32_t x = 0;
  int32_t y = 0;
};

enum class InsertResult : uint8_t { kInserted, kOutside, kSaturated };

/// Column-compact voxel map after the idea of a scrolling 2-D grid.
///
/// A column (x, y) is a mask of its occupied voxels and a run of their records sorted by z; the
/// record of height z is at rank popcount(mask below z). Columns are ring-indexed by world
/// coordinates, so scrolling in x and y moves nothing: it clears the columns that left. Scrolling
/// in z shifts the masks. Memory follows the occupied voxels (2 to 7 % in real scenes).
///
/// What a voxel holds is the policy `Record`: any additive quantity with
///   void add(const FixedPoint& q, const Payload&...);   one more point
///   Record& operator+=(const Record&), operator-=(const Record&);   exact
///   uint32_t count() const;   points in it
/// `VoxelMap` holds the moments of the points. AppearanceRecord (map/appearance_record.h) is an
/// example with intensity and colour.
///
/// A record's place in memory, its slot, stays what it is as long as its column does not change, so
/// tables by slot can keep what was computed of a voxel. `changedColumns` tells which did.
template <typename RecordPolicy>
class BasicVoxelMap {
 public:
  using Record = RecordPolicy;
  using InsertResult = ladar_perception::InsertResult;

  /// `shape` has 1 to 4096 voxels along x and y and 1 to 1024 along z, and columns times heights
  /// (rounded up to a power of two) stay below 2^32; a voxel takes no more than
  /// `max_points_per_voxel` points.
  BasicVoxelMap(const MapShape& shape, uint32_t max_points_per_voxel);

  const MapShape& shape() const { return shape_; }
  /// World index of the window's lowest voxel.
  const VoxelIndex& minCorner() const { return min_; }
  std::size_t occupied() const { return occupied_; }
  std::size_t memoryBytes() const;

  /// Moves the window. Voxels in both windows keep their records, the others are forgotten.
  void scrollTo(const VoxelIndex& min_corner);
  /// Forgets every point; the window stays.
  void clear();

  /// Adds a point. `*cell` is its voxel (also when saturated), or kNoCell outside the window.
  template <typename... Payload>
  LADAR_INLINE InsertResult insert(const FixedPoint& q, CellId* cell, const Payload&... payload) {
    *cell = cellOf(q);
    return *cell == kNoCell ? InsertResult::kOutside : insertAt(*cell, q, payload...);
  }
  // The same in steps, for loops over many points: what a later point needs can be on its way from
  // memory (`prefetch...`, in this order) while earlier ones are inserted.
  /// Voxel of a position, kNoCell outside the window.
  LADAR_INLINE CellId cellOf(const FixedPoint& q) const;
  LADAR_INLINE void prefetchColumn(CellId cell) const;
  LADAR_INLINE void prefetchRecord(CellId cell) const;
  /// `cell` is `cellOf(q)` and not kNoCell.
  template <typename... Payload>
  LADAR_INLINE InsertResult insertAt(CellId cell, const FixedPoint& q, const Payload&... payload);
  /// Takes out the points of `part`, which were all inserted here too and are still here: a map of
  /// the same shape and window. A voxel without points left is empty again.
  void subtract(const BasicVoxelMap& part);

  /// Record of a voxel, or nullptr if it is empty or outside.
  const Record* find(const VoxelIndex& voxel) const;

  // Access by slot. Slots of empty voxels are left out by forEachVoxel and hold anything.
  /// Every slot is below this.
  std::size_t slotBound() const { return arena_.size(); }
  const Record& record(std::size_t slot) const { return arena_[slot]; }
  LADAR_INLINE std::size_t slotOf(CellId cell) const {
    const int column = columnOf(cell);
    return runs_[column].offset +
           static_cast<std::size_t>(bit_mask::countBelow(mask(column), heightOf(cell)));
  }
  /// Calls `visit(voxel, slot)` for every occupied voxel: columns by ascending y, then x, then
  /// ascending z.
  template <typename Visitor>
  void forEachVoxel(Visitor&& visit) const;

  // Access by column, for the passes over the whole map. Local coordinates run from 0 at the
  // window's lowest corner; `column` is the ring index they map to.
  int columnCount() const { return shape_.nx * shape_.ny; }
  LADAR_INLINE int columnAt(int x_local, int y_local) const {
    return wrap(x_local + ring_x_, shape_.nx) + shape_.nx * wrap(y_local + ring_y_, shape_.ny);
  }
  int maskWords() const { return words_; }
  LADAR_INLINE const uint64_t* mask(int column) const {
    return masks_.data() + static_cast<std::size_t>(column) * words_;
  }
  int recordCount(int column) const { return runs_[column].count; }
  /// Slots [firstSlot, firstSlot + recordCount) hold the column's records by ascending z.
  std::size_t firstSlot(int column) const { return runs_[column].offset; }
  const Record* records(int column) const { return arena_.records(runs_[column]); }

  /// Columns of which a record was added, changed or removed since `forgetChanges` (some of them
  /// more than once), among them columns that have left the window with all their records. The list
  /// grows until it is forgotten: whoever scrolls a map for long has to.
  const std::vector<ColumnIndex>& changedColumns() const { return changed_; }
  void forgetChanges();

 private:
  LADAR_INLINE static int wrap(int i, int n) { return i < n ? i : i - n; }
  LADAR_INLINE int columnOf(CellId cell) const { return static_cast<int>(cell >> height_bits_); }
  LADAR_INLINE int heightOf(CellId cell) const {
    return static_cast<int>(cell & ((1U << height_bits_) - 1));
  }
  LADAR_INLINE uint64_t* maskOf(int column) {
    return masks_.data() + static_cast<std::size_t>(column) * words_;
  }
  LADAR_INLINE void noteChange(int column, const ColumnIndex& index);
  void clearColumns(int x_begin, int x_end, int y_begin, int y_end);
  void scrollHeight(int dz);
  void subtractColumn(int column, const BasicVoxelMap& part);
  void setMin(const VoxelIndex& min_corner);

  MapShape shape_;
  uint32_t max_points_per_voxel_;
  int words_;        // 64-bit words of a column's mask
  int height_bits_;  // of a CellId
  VoxelIndex min_;
  int ring_x_ = 0;  // ring index of the window's lowest x
  int ring_y_ = 0;
  std::size_t occupied_ = 0;
  std::vector<uint64_t> masks_;
  std::vector<RecordRun> runs_;
  RecordArena<Record> arena_;
  std::vector<ColumnIndex> changed_;
  std::vector<uint8_t> is_changed_;  // by column: stands in `changed_`
};

using VoxelMap = BasicVoxelMap<Moments>;

}  // namespace ladar_perception

#include "ladar_perception/map/voxel_map_impl.h"

namespace ladar_perception {
extern template class BasicVoxelMap<Moments>;
}  // namespace ladar_perception
