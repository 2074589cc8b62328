// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/map/voxel_map.h"

#include <algorithm>
#include <cassert>
#include <cstdlib>

#include "ladar_perception/map/bit_mask.h"

namespace ladar_perception {
namespace {

int floorModulo(int32_t value, int n) {
  const int remainder = value % n;
  return remainder < 0 ? remainder + n : remainder;
}

}  // namespace

VoxelMap::VoxelMap(const MapShape& shape, uint32_t max_points_per_voxel)
    : shape_(shape),
      max_points_per_voxel_(max_points_per_voxel),
      words_((shape.nz + 63) / 64),
      masks_(static_cast<std::size_t>(shape.nx) * shape.ny * words_, 0),
      runs_(static_cast<std::size_t>(shape.nx) * shape.ny) {
  assert(shape.nx > 0 && shape.ny > 0 && shape.nz > 0);
}

std::size_t VoxelMap::memoryBytes() const {
  return masks_.capacity() * sizeof(uint64_t) + runs_.capacity() * sizeof(RecordArena::Run) +
         arena_.bytes();
}

void VoxelMap::scrollTo(const VoxelIndex& min_corner) {
  const int64_t dx = int64_t{min_corner.x} - min_.x;
  const int64_t dy = int64_t{min_corner.y} - min_.y;
  const int64_t dz = int64_t{min_corner.z} - min_.z;
  if (std::llabs(dx) >= shape_.nx || std::llabs(dy) >= shape_.ny ||
      std::llabs(dz) >= shape_.nz) {
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

void VoxelMap::clear() {
  std::fill(masks_.begin(), masks_.end(), 0);
  std::fill(runs_.begin(), runs_.end(), RecordArena::Run());
  arena_.clear();
  occupied_ = 0;
}

VoxelMap::InsertResult VoxelMap::insert(const FixedPoint& q, CellId* cell) {
  // Compared as 64-bit integers: a position far outside must not wrap into the window.
  const int64_t x = (q.x >> kStepsPerVoxelLog2) - min_.x;
  const int64_t y = (q.y >> kStepsPerVoxelLog2) - min_.y;
  const int64_t z = (q.z >> kStepsPerVoxelLog2) - min_.z;
  if (x < 0 || x >= shape_.nx || y < 0 || y >= shape_.ny || z < 0 || z >= shape_.nz) {
    *cell = kNoCell;
    return InsertResult::kOutside;
  }
  const int column = columnAt(static_cast<int>(x), static_cast<int>(y));
  const int height = static_cast<int>(z);
  *cell = static_cast<CellId>(column) * shape_.nz + height;
  uint64_t* column_mask = maskOf(column);
  const int record_rank = rank(column_mask, height);
  uint64_t& word = column_mask[height / 64];
  const uint64_t bit = uint64_t{1} << (height % 64);
  if ((word & bit) == 0) {
    word |= bit;
    ++occupied_;
    arena_.insert(&runs_[column], record_rank).add(q);
    return InsertResult::kInserted;
  }
  Moments& record = arena_.records(runs_[column])[record_rank];
  if (record.count() >= max_points_per_voxel_) return InsertResult::kSaturated;
  record.add(q);
  return InsertResult::kInserted;
}

const Moments* VoxelMap::find(const VoxelIndex& voxel) const {
  const int64_t x = int64_t{voxel.x} - min_.x;
  const int64_t y = int64_t{voxel.y} - min_.y;
  const int64_t z = int64_t{voxel.z} - min_.z;
  if (x < 0 || x >= shape_.nx || y < 0 || y >= shape_.ny || z < 0 || z >= shape_.nz) {
    return nullptr;
  }
  const int column = columnAt(static_cast<int>(x), static_cast<int>(y));
  if (!bit_mask::test(mask(column), static_cast<int>(z))) return nullptr;
  return records(column) + rank(mask(column), static_cast<int>(z));
}

int VoxelMap::rank(const uint64_t* mask, int z) { return bit_mask::countBelow(mask, z); }

void VoxelMap::clearColumn(int column) {
  RecordArena::Run& run = runs_[column];
  if (run.count == 0) return;
  occupied_ -= run.count;
  arena_.keep(&run, 0, 0);
  std::fill_n(maskOf(column), words_, 0);
}

void VoxelMap::clearColumns(int x_begin, int x_end, int y_begin, int y_end) {
  for (int y = y_begin; y < y_end; ++y) {
    for (int x = x_begin; x < x_end; ++x) clearColumn(columnAt(x, y));
  }
}

void VoxelMap::scrollHeight(int dz) {
  for (int column = 0; column < columnCount(); ++column) {
    RecordArena::Run& run = runs_[column];
    if (run.count == 0) continue;
    uint64_t* column_mask = maskOf(column);
    // Heights [lowest, highest) stay inside the window.
    const int lowest = std::max(dz, 0);
    const int highest = std::min(shape_.nz, shape_.nz + dz);
    const int below = rank(column_mask, lowest);
    const int kept = rank(column_mask, highest) - below;
    occupied_ -= run.count - kept;
    arena_.keep(&run, below, kept);
    bit_mask::shift(column_mask, words_, -dz);
    bit_mask::clearFrom(column_mask, words_, shape_.nz);
  }
}

void VoxelMap::setMin(const VoxelIndex& min_corner) {
  min_ = min_corner;
  ring_x_ = floorModulo(min_.x, shape_.nx);
  ring_y_ = floorModulo(min_.y, shape_.ny);
}

}  // namespace ladar_perception
