// SPDX-License-Identifier: BSD-3-Clause
// Definitions of BasicVoxelMap's templates; include voxel_map.h instead.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdlib>

#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {
namespace voxel_map_internal {

inline int floorModulo(int32_t value, int n) {
  const int remainder = value % n;
  return remainder < 0 ? remainder + n : remainder;
}

inline int bitsFor(int values) {
  int bits = 0;
  while (1 << bits < values) ++bits;
  return bits;
}

}  // namespace voxel_map_internal

template <typename Record>
BasicVoxelMap<Record>::BasicVoxelMap(const MapShape& shape, uint32_t max_points_per_voxel)
    : shape_(shape),
      max_points_per_voxel_(max_points_per_voxel),
      words_((shape.nz + 63) / 64),
      height_bits_(voxel_map_internal::bitsFor(shape.nz)),
      masks_(static_cast<std::size_t>(shape.nx) * shape.ny * words_, 0),
      runs_(static_cast<std::size_t>(shape.nx) * shape.ny),
      is_changed_(static_cast<std::size_t>(shape.nx) * shape.ny, 0) {
  assert(shape.nx > 0 && shape.ny > 0 && shape.nz > 0);
  assert((static_cast<uint64_t>(columnCount()) << height_bits_) < uint64_t{kNoCell});
}

template <typename Record>
std::size_t BasicVoxelMap<Record>::memoryBytes() const {
  return masks_.capacity() * sizeof(uint64_t) + runs_.capacity() * sizeof(RecordRun) +
         changed_.capacity() * sizeof(ColumnIndex) + is_changed_.capacity() + arena_.bytes();
}

template <typename Record>
void BasicVoxelMap<Record>::scrollTo(const VoxelIndex& min_corner) {
  const int64_t dx = int64_t{min_corner.x} - min_.x;
  const int64_t dy = int64_t{min_corner.y} - min_.y;
  const int64_t dz = int64_t{min_corner.z} - min_.z;
  if (std::llabs(dx) >= shape_.nx || std::llabs(dy) >= shape_.ny || std::llabs(dz) >= shape_.nz) {
    clear();
    setMin(min_corner);
    return;
  }
  const int sx = static_cast<int>(dx);
  const int sy = static_cast<int>(dy);
  if (sx > 0) clearColumns(0, sx, 0, shape_.ny);
  if (sx < 0) clearColumns(shape_.nx + sx, shape_.nx, 0, shape_.ny);
  if (sy > 0) clearColumns(0, shape_.nx, 0, sy);
  if (sy < 0) clearColumns(0, shape_.nx, shape_.ny + sy, shape_.ny);
  if (dz != 0) scrollHeight(static_cast<int>(dz));
  setMin(min_corner);
}

template <typename Record>
void BasicVoxelMap<Record>::clear() {
  std::fill(masks_.begin(), masks_.end(), 0);
  std::fill(runs_.begin(), runs_.end(), RecordRun());
  arena_.clear();
  occupied_ = 0;
  forgetChanges();  // nothing is left that they could have changed
}

template <typename Record>
LADAR_INLINE CellId BasicVoxelMap<Record>::cellOf(const FixedPoint& q) const {
  // Compared as 64-bit integers: a position far outside must not wrap into the window. As unsigned
  // ones, so that negative is too great as well.
  const auto x = static_cast<uint64_t>((q.x >> kStepsPerVoxelLog2) - min_.x);
  const auto y = static_cast<uint64_t>((q.y >> kStepsPerVoxelLog2) - min_.y);
  const auto z = static_cast<uint64_t>((q.z >> kStepsPerVoxelLog2) - min_.z);
  const bool inside = x < static_cast<uint64_t>(shape_.nx) &&
                      y < static_cast<uint64_t>(shape_.ny) && z < static_cast<uint64_t>(shape_.nz);
  if (!inside) return kNoCell;
  const int column = columnAt(static_cast<int>(x), static_cast<int>(y));
  return static_cast<CellId>(column) << height_bits_ | static_cast<CellId>(z);
}

template <typename Record>
LADAR_INLINE void BasicVoxelMap<Record>::prefetchColumn(CellId cell) const {
  __builtin_prefetch(mask(columnOf(cell)), 1);
  __builtin_prefetch(&runs_[columnOf(cell)], 1);
}

template <typename Record>
LADAR_INLINE void BasicVoxelMap<Record>::prefetchRecord(CellId cell) const {
  // Of an empty voxel it is the record that will have to move.
  __builtin_prefetch(
      records(columnOf(cell)) + bit_mask::countBelow(mask(columnOf(cell)), heightOf(cell)), 1);
}

template <typename Record>
template <typename... Payload>
LADAR_INLINE InsertResult BasicVoxelMap<Record>::insertAt(CellId cell, const FixedPoint& q,
                                                          const Payload&... payload) {
  const int column = columnOf(cell);
  const int height = heightOf(cell);
  uint64_t* column_mask = maskOf(column);
  const int rank = bit_mask::countBelow(column_mask, height);
  uint64_t& word = column_mask[height / 64];
  const uint64_t bit = uint64_t{1} << (height % 64);
  Record* record = nullptr;
  if ((word & bit) == 0) {
    word |= bit;
    ++occupied_;
    record = &arena_.insert(&runs_[column], static_cast<uint32_t>(rank));
  } else {
    record = arena_.records(runs_[column]) + rank;
    if (record->count() >= max_points_per_voxel_) return InsertResult::kSaturated;
  }
  record->add(q, payload...);
  noteChange(column, {static_cast<int32_t>(q.x >> kStepsPerVoxelLog2),
                      static_cast<int32_t>(q.y >> kStepsPerVoxelLog2)});
  return InsertResult::kInserted;
}

template <typename Record>
void BasicVoxelMap<Record>::subtract(const BasicVoxelMap& part) {
  assert(part.min_ == min_ && part.columnCount() == columnCount() && part.words_ == words_);
  for (int y = 0; y < shape_.ny; ++y) {
    for (int x = 0; x < shape_.nx; ++x) {
      const int column = columnAt(x, y);
      if (part.recordCount(column) == 0) continue;
      subtractColumn(column, part);
      noteChange(column, {min_.x + x, min_.y + y});
    }
  }
}

template <typename Record>
void BasicVoxelMap<Record>::subtractColumn(int column, const BasicVoxelMap& part) {
  uint64_t* column_mask = maskOf(column);
  RecordRun& run = runs_[column];
  Record* kept = arena_.records(run);
  const Record* record = kept;
  const Record* leaving = part.records(column);
  for (int word = 0; word < words_; ++word) {
    const uint64_t part_word = part.mask(column)[word];
    assert((part_word & ~column_mask[word]) == 0);
    for (uint64_t bits = column_mask[word]; bits != 0; bits &= bits - 1) {
      const uint64_t bit = bits & -bits;
      Record left = *record++;
      if ((part_word & bit) != 0) left -= *leaving++;
      if (left.count() == 0) {
        column_mask[word] ^= bit;
      } else {
        *kept++ = left;
      }
    }
  }
  const auto count = static_cast<uint32_t>(kept - arena_.records(run));
  occupied_ -= run.count - count;
  arena_.keep(&run, 0, count);
}

template <typename Record>
const Record* BasicVoxelMap<Record>::find(const VoxelIndex& voxel) const {
  const int64_t x = int64_t{voxel.x} - min_.x;
  const int64_t y = int64_t{voxel.y} - min_.y;
  const int64_t z = int64_t{voxel.z} - min_.z;
  if (x < 0 || x >= shape_.nx || y < 0 || y >= shape_.ny || z < 0 || z >= shape_.nz) {
    return nullptr;
  }
  const int column = columnAt(static_cast<int>(x), static_cast<int>(y));
  if (!bit_mask::test(mask(column), static_cast<int>(z))) return nullptr;
  return records(column) + bit_mask::countBelow(mask(column), static_cast<int>(z));
}

template <typename Record>
template <typename Visitor>
void BasicVoxelMap<Record>::forEachVoxel(Visitor&& visit) const {
  for (int y = 0; y < shape_.ny; ++y) {
    for (int x = 0; x < shape_.nx; ++x) {
      const int column = columnAt(x, y);
      std::size_t slot = firstSlot(column);
      bit_mask::forEachSet(mask(column), words_, [&](int z) {
        visit(VoxelIndex{min_.x + x, min_.y + y, min_.z + z}, slot++);
      });
    }
  }
}

template <typename Record>
void BasicVoxelMap<Record>::forgetChanges() {
  changed_.clear();
  std::fill(is_changed_.begin(), is_changed_.end(), 0);
}

template <typename Record>
LADAR_INLINE void BasicVoxelMap<Record>::noteChange(int column, const ColumnIndex& index) {
  if (is_changed_[column] != 0) return;
  is_changed_[column] = 1;
  changed_.push_back(index);
}

template <typename Record>
void BasicVoxelMap<Record>::clearColumns(int x_begin, int x_end, int y_begin, int y_end) {
  for (int y = y_begin; y < y_end; ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      const int column = columnAt(x, y);
      if (runs_[column].count > 0) {
        changed_.push_back({min_.x + x, min_.y + y});
        occupied_ -= runs_[column].count;
        arena_.keep(&runs_[column], 0, 0);
        std::fill_n(maskOf(column), words_, 0);
      }
      is_changed_[column] = 0;  // it stands for another place now
    }
  }
}

template <typename Record>
void BasicVoxelMap<Record>::scrollHeight(int dz) {
  // Heights [lowest, highest) stay inside the window.
  const int lowest = std::max(dz, 0);
  const int highest = std::min(shape_.nz, shape_.nz + dz);
  for (int y = 0; y < shape_.ny; ++y) {
    for (int x = 0; x < shape_.nx; ++x) {
      const int column = columnAt(x, y);
      RecordRun& run = runs_[column];
      if (run.count == 0) continue;
      uint64_t* column_mask = maskOf(column);
      const int below = bit_mask::countBelow(column_mask, lowest);
      const int kept = bit_mask::countBelow(column_mask, highest) - below;
      if (kept < run.count) {
        noteChange(column, {min_.x + x, min_.y + y});
        occupied_ -= run.count - kept;
        arena_.keep(&run, static_cast<uint32_t>(below), static_cast<uint32_t>(kept));
      }
      bit_mask::shift(column_mask, words_, -dz);
      bit_mask::clearFrom(column_mask, words_, shape_.nz);
    }
  }
}

template <typename Record>
void BasicVoxelMap<Record>::setMin(const VoxelIndex& min_corner) {
  min_ = min_corner;
  ring_x_ = voxel_map_internal::floorModulo(min_.x, shape_.nx);
  ring_y_ = voxel_map_internal::floorModulo(min_.y, shape_.ny);
}

}  // namespace ladar_perception
