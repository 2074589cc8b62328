// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/map/column_layer.h"

#include <algorithm>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

struct Lesser {
  LADAR_INLINE int32_t operator()(int32_t a, int32_t b) const { return a < b ? a : b; }
  static constexpr int32_t kNeutral = INT32_MAX;
};
struct Greater {
  LADAR_INLINE int32_t operator()(int32_t a, int32_t b) const { return a > b ? a : b; }
  static constexpr int32_t kNeutral = INT32_MIN;
};

/// Least or greatest of every window of 2 r + 1 rows, in place: windows of 2, 4, 8... rows from two
/// of half the size each, at last two that overlap. A row is `width` numbers; a line of columns is
/// a picture with rows of one number.
template <typename Choose>
LADAR_INLINE void chooseInWindows(int32_t* values, int rows, int width, int r,
                                  std::vector<int32_t>* scratch) {
  const Choose choose;
  const int window = 2 * r + 1;
  const auto begin = static_cast<std::size_t>(width);
  // r rows of nothing before and behind.
  scratch->assign(begin * (rows + 2 * r), Choose::kNeutral);
  int32_t* padded = scratch->data();
  std::copy_n(values, begin * rows, padded + begin * r);
  int reach = 1;  // rows that padded[i] stands for, from i on
  for (; 2 * reach <= window; reach *= 2) {
    const std::size_t last = begin * (rows + 2 * r - 2 * reach + 1);
    // In place and in order: what lies ahead is not yet changed.
    const int32_t* ahead = padded + begin * reach;
    for (std::size_t i = 0; i < last; ++i) padded[i] = choose(padded[i], ahead[i]);
  }
  const int32_t* __restrict__ second = padded + begin * (window - reach);
  for (std::size_t i = 0; i < begin * rows; ++i) values[i] = choose(padded[i], second[i]);
}

template <typename Choose>
void chooseInSquares(int nx, int ny, int r, std::vector<int32_t>* values,
                     std::vector<int32_t>* scratch) {
  dispatch([&]() LADAR_INLINE_LAMBDA {
    for (int y = 0; y < ny; ++y) {
      chooseInWindows<Choose>(values->data() + static_cast<std::size_t>(y) * nx, nx, 1, r, scratch);
    }
    chooseInWindows<Choose>(values->data(), ny, nx, r, scratch);
  });
}

/// Sums over windows of 2 r + 1 rows, in place.
LADAR_INLINE void sumInWindows(int32_t* __restrict__ values, int rows, int width, int r,
                               std::vector<int32_t>* scratch) {
  const auto size = static_cast<std::size_t>(width);
  // The running sum, and behind it the rows as they were.
  scratch->assign(size, 0);
  scratch->insert(scratch->end(), values, values + size * rows);
  int32_t* __restrict__ sum = scratch->data();
  const int32_t* __restrict__ before = sum + size;
  for (int row = -r; row < rows; ++row) {
    if (row + r < rows) {
      const int32_t* entering = before + (row + r) * size;
      for (std::size_t i = 0; i < size; ++i) sum[i] += entering[i];
    }
    if (row >= 0) std::copy_n(sum, size, values + row * size);
    if (row >= r) {
      const int32_t* leaving = before + (row - r) * size;
      for (std::size_t i = 0; i < size; ++i) sum[i] -= leaving[i];
    }
  }
}

void sumInSquares(int nx, int ny, int r, std::vector<int32_t>* values,
                  std::vector<int32_t>* scratch) {
  dispatch([&]() LADAR_INLINE_LAMBDA {
    for (int y = 0; y < ny; ++y) {
      sumInWindows(values->data() + static_cast<std::size_t>(y) * nx, nx, 1, r, scratch);
    }
    sumInWindows(values->data(), ny, nx, r, scratch);
  });
}

/// Calls `visit(i, column)` for every column; i counts them by local y, then x.
template <typename Visitor>
void forEachColumn(const VoxelMap& map, Visitor&& visit) {
  std::size_t i = 0;
  for (int y = 0; y < map.shape().ny; ++y) {
    for (int x = 0; x < map.shape().nx; ++x) visit(i++, map.columnAt(x, y));
  }
}

void lowestOfColumns(const VoxelMap& map, std::vector<int32_t>* values) {
  values->assign(static_cast<std::size_t>(map.columnCount()), ColumnLayer::kNothing);
  forEachColumn(map, [&](std::size_t i, int column) {
    if (map.recordCount(column) == 0) return;
    const uint64_t* mask = map.mask(column);
    int word = 0;
    while (mask[word] == 0) ++word;
    (*values)[i] = map.minCorner().z + 64 * word + __builtin_ctzll(mask[word]);
  });
}

}  // namespace

std::size_t ColumnLayer::memoryBytes() const {
  return sizeof(int32_t) *
         (values_.capacity() + before_.capacity() + scratch_.capacity() + counts_.capacity());
}

void ColumnLayer::compute(const VoxelMap& map) {
  const int nx = map.shape().nx;
  const int ny = map.shape().ny;
  nx_ = nx;
  if (quantity_ == ColumnQuantity::kFill) {
    values_.resize(static_cast<std::size_t>(map.columnCount()));
    counts_.resize(values_.size());
    forEachColumn(map, [&](std::size_t i, int column) {
      values_[i] = map.recordCount(column);
      counts_[i] = values_[i] > 0 ? 1 : 0;
    });
    sumInSquares(nx, ny, radius_, &values_, &scratch_);
    sumInSquares(nx, ny, radius_, &counts_, &scratch_);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      // Full squares of a tall map hold more voxels than 2^31 / kFillUnit.
      const int64_t units = int64_t{kFillUnit} * values_[i];
      values_[i] = counts_[i] > 0 ? static_cast<int32_t>(units / counts_[i]) : kNothing;
    }
    return;
  }
  lowestOfColumns(map, &values_);
  chooseInSquares<Lesser>(nx, ny, radius_, &values_, &scratch_);
  if (quantity_ == ColumnQuantity::kLowest) return;
  for (int32_t& value : values_) value = value == kNothing ? INT32_MIN : value;
  chooseInSquares<Greater>(nx, ny, radius_, &values_, &scratch_);
  for (int32_t& value : values_) value = value == INT32_MIN ? kNothing : value;
}

}  // namespace ladar_perception
