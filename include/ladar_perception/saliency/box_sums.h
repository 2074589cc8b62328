// SPDX-License-Identifier: BSD-3-Clause
// Sums of what voxels hold over the support volume of every occupied voxel.
#pragma once

#include <algorithm>
#include <climits>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "ladar_perception/map/column_set.h"
#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// A support volume: the voxels up to `radius_xy` from a voxel along x and y and `radius_z` along
/// z.
struct SupportBox {
  int radius_xy = 4;
  int radius_z = 4;

  bool operator==(const SupportBox& other) const {
    return radius_xy == other.radius_xy && radius_z == other.radius_z;
  }
};

/// The cube of k = 2 r + 1 voxels a side.
constexpr SupportBox cube(int r) { return {r, r}; }

/// A sum that is added to many times, where vectors are kBytes wide.
template <typename Sum, int kBytes>
struct SumInRegisters : Sum {
  LADAR_INLINE void addTo(const Sum& other, Sum* result) const {
    Sum sum = other;
    sum += *this;
    *result = sum;
  }
};
template <int kBytes>
struct SumInRegisters<Moments, kBytes> : MomentsInRegisters<kBytes> {};

/// Sparse sliding sums: along y a plane of per-(x, z) sums gains one row of the map and loses one,
/// along x a line of per-z sums gains and loses one column of that plane, along z a sum is the
/// difference of two of that line's running sums. Empty voxels cost nothing, and the work per voxel
/// hardly grows with the support volume.
///
/// Branches that a CPU cannot foresee cost more than sums here: so rows are flat lists of records,
/// worked on from end to end.
///
/// Sums are exact, so they equal the sum over the box's voxels bit by bit. `Sum` is any quantity
/// with += and -= of itself and of the map's records, `count()` (0 only when nothing is in it), and
/// 0 as its default: the moments themselves, or whatever else is additive.
template <typename Sum>
class SlidingBoxSums {
 public:
  /// Keeps buffers between calls.
  explicit SlidingBoxSums(const SupportBox& box) : box_(box) {}

  const SupportBox& box() const { return box_; }
  std::size_t memoryBytes() const {
    std::size_t bytes = (plane_.capacity() + line_.capacity()) * sizeof(Sum) +
                        plane_masks_.capacity() * sizeof(uint64_t);
    for (const Row& row : rows_) bytes += row.entries.capacity() * sizeof(Entry);
    return bytes;
  }

  /// Sums for the occupied voxels of `columns` with y_begin <= local y < y_end, row by row, along x
  /// and by ascending z. `output.place(slot, x, y, z)` returns a reference to where the sum of the
  /// voxel goes; it is there when `place` is called next, or this returns. Work follows the columns
  /// asked for and their surroundings.
  template <typename Map, typename Output>
  void compute(const Map& map, const ColumnSet& columns, int y_begin, int y_end, Output&& output) {
    dispatchWide([&](auto width) LADAR_INLINE_LAMBDA {
      begin(map, columns, y_begin);
      for (int y = y_begin; y < y_end; ++y) computeRow(map, columns, y, width, output);
      end(map, y_end);
    });
  }

  // The same in steps, for several supports at once, within `dispatchWide`: begin, every row from
  // y_begin to y_end - 1, end.
  template <typename Map>
  LADAR_INLINE void begin(const Map& map, const ColumnSet& columns, int y_begin) {
    prepare(map.shape(), map.maskWords());
    for (int y = y_begin - box_.radius_xy; y < y_begin + box_.radius_xy; ++y) {
      withWords([&](auto words) LADAR_INLINE_LAMBDA { addRow<words()>(map, columns, y); });
    }
  }
  template <typename Map, typename Width, typename Output>
  LADAR_INLINE void computeRow(const Map& map, const ColumnSet& columns, int y, Width /*width*/,
                               Output& output) {
    withWords([&](auto words) LADAR_INLINE_LAMBDA {
      addRow<words()>(map, columns, y + box_.radius_xy);
      sumRow<words(), Width::value>(columns, y, output);
      subtractRow<words()>(map, y - box_.radius_xy);
    });
  }
  /// Leaves the plane as it was found.
  template <typename Map>
  LADAR_INLINE void end(const Map& map, int y_end) {
    for (int y = y_end - box_.radius_xy; y < y_end + box_.radius_xy; ++y) {
      withWords([&](auto words) LADAR_INLINE_LAMBDA { subtractRow<words()>(map, y); });
    }
  }

 private:
  /// A voxel of a row: its record and its entry of the plane.
  struct Entry {
    uint32_t slot;
    uint32_t plane;  // index into plane_
    uint32_t x;
    uint32_t z;
  };
  struct Row {
    std::vector<Entry> entries;  // `size` of them are used
    std::size_t size = 0;
  };

  static constexpr int kNowhere = INT_MIN / 4;  // far below, and its double is still an int
  static constexpr int kBlockColumns = 16;
  static constexpr int kEntriesAhead = 2;

  /// Empty columns at either end of the plane, so that the line needs no test at the map's ends.
  int border() const { return box_.radius_xy + 1; }

  void prepare(const MapShape& shape, int words) {
    if (shape.nx == shape_.nx && shape.nz == shape_.nz) {
      shape_ = shape;
      return;
    }
    shape_ = shape;
    words_ = words;
    row_words_ = (shape.nx + 63) / 64;
    // An odd number of cache lines between columns of the plane spreads them over all cache sets;
    // with a power of two the same heights of neighbouring columns evict each other.
    stride_ = shape.nz | 1;
    const std::size_t columns = static_cast<std::size_t>(shape.nx) + 2 * border();
    plane_.assign(columns * stride_, Sum());
    plane_masks_.assign(columns * words, 0);
    line_.assign(shape.nz, Sum());
    profiles_.resize(static_cast<std::size_t>(shape.nz + 1) * (kBlockColumns + 1));
    heights_.resize(shape.nz);
    block_mask_.resize(words);
    needed_.resize(row_words_);
    dilated_.resize(row_words_);
    rows_.resize(2 * box_.radius_xy + 1);
  }

  /// Calls `body` with the number of words of a column's mask as a constant, 0 for any.
  template <typename Body>
  LADAR_INLINE void withWords(const Body& body) {
    if (words_ == 1) {
      body(std::integral_constant<int, 1>());
    } else {
      body(std::integral_constant<int, 0>());
    }
  }

  template <int kWords>
  LADAR_INLINE int words() const {
    return kWords > 0 ? kWords : words_;
  }

  Row& rowAt(int y) {
    // Rows before the first are met, too.
    const auto size = static_cast<int>(rows_.size());
    return rows_[(y + size) % size];
  }

  /// Adds to the plane the records of row y in the columns that a box around one of `columns`
  /// reaches.
  template <int kWords, typename Map>
  LADAR_INLINE void addRow(const Map& map, const ColumnSet& columns, int y) {
    Row& row = rowAt(y);
    row.size = 0;
    if (y < 0 || y >= shape_.ny) return;
    listRow<kWords>(map, columns, y, &row);
    Sum* plane = plane_.data();
    uint64_t* masks = plane_masks_.data();
    const Entry* end = row.entries.data() + row.size;
    for (const Entry* entry = row.entries.data(); entry != end; ++entry) {
      plane[entry->plane] += map.record(entry->slot);
      masks[planeWord<kWords>(*entry)] |= uint64_t{1} << (entry->z % 64);
    }
  }

  template <int kWords, typename Map>
  LADAR_INLINE void subtractRow(const Map& map, int y) {
    const Row& row = rowAt(y);
    if (y < 0 || y >= shape_.ny) return;
    Sum* plane = plane_.data();
    uint64_t* masks = plane_masks_.data();
    const Entry* end = row.entries.data() + row.size;
    for (const Entry* entry = row.entries.data(); entry != end; ++entry) {
      Sum sum = plane[entry->plane];
      sum -= map.record(entry->slot);
      plane[entry->plane] = sum;
      // An emptied entry is exactly 0 again, so its bit can go.
      masks[planeWord<kWords>(*entry)] &= ~(uint64_t{sum.count() == 0} << (entry->z % 64));
    }
  }

  template <int kWords, typename Map>
  LADAR_INLINE void listRow(const Map& map, const ColumnSet& columns, int y, Row* row) {
    const int r = box_.radius_xy;
    std::fill(needed_.begin(), needed_.end(), 0);
    const int last = std::min(y + r, shape_.ny - 1);
    for (int i = std::max(y - r, 0); i <= last; ++i) {
      for (int word = 0; word < row_words_; ++word) needed_[word] |= columns.row(i)[word];
    }
    dilateBits(needed_.data(), row_words_, r, dilated_.data());
    std::size_t most = kEntriesAhead;
    for (int x = 0; x < shape_.nx; ++x) most += map.recordCount(map.columnAt(x, y));
    if (row->entries.size() < most) row->entries.resize(most);
    Entry* out = row->entries.data();
    bit_mask::forEachSet(dilated_.data(), row_words_, [&](int x) LADAR_INLINE_LAMBDA {
      if (x >= shape_.nx) return;
      const int column = map.columnAt(x, y);
      const auto* records = map.records(column);
      const auto slot = static_cast<uint32_t>(map.firstSlot(column));
      const auto plane = static_cast<uint32_t>((x + border()) * stride_);
      const auto list = [&](int rank, int z) LADAR_INLINE_LAMBDA {
        __builtin_prefetch(records + rank);
        const auto height = static_cast<uint32_t>(z);
        out[rank] = {slot + static_cast<uint32_t>(rank), plane + height, static_cast<uint32_t>(x),
                     height};
      };
      int rank = 0;
      if (kWords == 1) {
        // Most columns have up to two records; they are written whether they exist or not.
        constexpr uint64_t kSome = uint64_t{1} << 63;
        uint64_t bits = map.mask(column)[0];
        for (; rank < kEntriesAhead; ++rank, bits &= bits - 1) {
          list(rank, __builtin_ctzll(bits | kSome));
        }
        for (; bits != 0; ++rank, bits &= bits - 1) list(rank, __builtin_ctzll(bits));
      } else {
        bit_mask::forEachSet(map.mask(column), words<kWords>(),
                             [&](int z) LADAR_INLINE_LAMBDA { list(rank++, z); });
      }
      out += map.recordCount(column);
    });
    row->size = static_cast<std::size_t>(out - row->entries.data());
  }

  /// Sums around every voxel of `columns` in row y, a few columns of the map at a time.
  template <int kWords, int kBytes, typename Output>
  LADAR_INLINE void sumRow(const ColumnSet& columns, int y, Output& output) {
    const Row& row = rowAt(y);
    const uint64_t* active = columns.row(y);
    const Entry* entry = row.entries.data();
    const Entry* end = entry + row.size;
    int line_x = kNowhere;  // column of the map the line stands at
    while (entry != end) {
      const auto x = static_cast<int>(entry->x);
      if (!bit_mask::test(active, x)) {
        ++entry;
        continue;
      }
      if (x - line_x > std::min(box_.radius_xy, kBlockColumns)) {
        placeLine<kWords>(x - 1);
        line_x = x - 1;
      }
      const int begin_x = line_x + 1;
      const Entry* block_end = entry;
      while (block_end != end && static_cast<int>(block_end->x) < begin_x + kBlockColumns) {
        ++block_end;
      }
      line_x = static_cast<int>(block_end[-1].x);
      slideLine<kWords, kBytes>(begin_x, line_x + 1);
      for (; entry != block_end; ++entry) {
        if (!bit_mask::test(active, static_cast<int>(entry->x))) continue;
        output.place(entry->slot, static_cast<int>(entry->x), y, static_cast<int>(entry->z)) =
            sumAlongZ<kWords>(static_cast<int>(entry->x) - begin_x, static_cast<int>(entry->z));
      }
    }
  }

  /// Sums the line anew for column x.
  template <int kWords>
  LADAR_INLINE void placeLine(int x) {
    std::fill(line_.begin(), line_.end(), Sum());
    for (int i = x - box_.radius_xy; i <= x + box_.radius_xy; ++i) {
      const Sum* plane = planeColumn(i);
      bit_mask::forEachSet(planeMask<kWords>(i), words<kWords>(),
                           [&](int z) LADAR_INLINE_LAMBDA { line_[z] += plane[z]; });
    }
  }

  /// Slides the line from column begin_x - 1 to end_x - 1. On the way `profiles_` gets, for each of
  /// the columns, the line's sums from below up to every height that any of them has (which are
  /// listed in `heights_`): then a sum along z is a difference.
  template <int kWords, int kBytes>
  LADAR_INLINE void slideLine(int begin_x, int end_x) {
    const int r = box_.radius_xy;
    for (int word = 0; word < words<kWords>(); ++word) {
      uint64_t bits = 0;
      for (int i = begin_x - r - 1; i < end_x + r; ++i) bits |= planeMask<kWords>(i)[word];
      block_mask_[word] = bits;
    }
    int* height = heights_.data();
    bit_mask::forEachSet(block_mask_.data(), words<kWords>(),
                         [&](int z) LADAR_INLINE_LAMBDA { *height++ = z; });
    const int* heights = heights_.data();
    const int count = static_cast<int>(height - heights);
    profile_size_ = count + 1;
    Sum* profile = profiles_.data();
    Sum sum;
    profile[0] = sum;
    for (int i = 0; i < count; ++i) {
      sum += line_[heights[i]];
      profile[i + 1] = sum;
    }
    for (int x = begin_x; x < end_x; ++x) {
      const Sum* entering = planeColumn(x + r);
      const Sum* leaving = planeColumn(x - r - 1);
      Sum* next = profile + profile_size_;
      next[0] = Sum();
      SumInRegisters<Sum, kBytes> change;
      for (int i = 0; i < count; ++i) {
        change += entering[heights[i]];
        change -= leaving[heights[i]];
        change.addTo(profile[i + 1], &next[i + 1]);
      }
      profile = next;
    }
    for (int i = 0; i < count; ++i) {
      sum = profile[i + 1];
      sum -= profile[i];
      line_[heights[i]] = sum;
    }
  }

  /// Sum over heights z - radius_z .. z + radius_z at a column of the block.
  template <int kWords>
  LADAR_INLINE Sum sumAlongZ(int column, int z) const {
    const Sum* profile = profiles_.data() + static_cast<std::size_t>(column + 1) * profile_size_;
    const int top = std::min(z + box_.radius_z + 1, shape_.nz);
    const int bottom = std::max(z - box_.radius_z, 0);
    Sum sum = profile[rank<kWords>(top)];
    sum -= profile[rank<kWords>(bottom)];
    return sum;
  }

  /// Heights of the block below z.
  template <int kWords>
  LADAR_INLINE int rank(int z) const {
    if (kWords != 1) return bit_mask::countBelow(block_mask_.data(), z);
    const uint64_t below = z < 64 ? (uint64_t{1} << z) - 1 : ~uint64_t{0};
    return __builtin_popcountll(block_mask_[0] & below);
  }

  LADAR_INLINE Sum* planeColumn(int x) {
    return plane_.data() + static_cast<std::size_t>(x + border()) * stride_;
  }
  template <int kWords>
  LADAR_INLINE uint64_t* planeMask(int x) {
    return plane_masks_.data() + static_cast<std::size_t>(x + border()) * words<kWords>();
  }
  template <int kWords>
  LADAR_INLINE std::size_t planeWord(const Entry& entry) const {
    return static_cast<std::size_t>(entry.x + border()) * words<kWords>() +
           (kWords == 1 ? 0 : entry.z / 64);
  }

  SupportBox box_;
  MapShape shape_;
  int words_ = 0;      // 64-bit words of a column's mask
  int row_words_ = 0;  // 64-bit words of a row of columns
  int stride_ = 0;     // entries between columns of the plane
  // Sums over rows y - radius_xy .. y + radius_xy, by x + border() and z. Entries outside their
  // mask are 0.
  std::vector<Sum> plane_;
  std::vector<uint64_t> plane_masks_;
  std::vector<Sum> line_;  // sums over the plane's columns around one column, by z
  std::vector<Sum> profiles_;
  int profile_size_ = 0;
  std::vector<int> heights_;
  std::vector<uint64_t> block_mask_;
  std::vector<Row> rows_;  // the rows that are in the plane, by y modulo their number
  std::vector<uint64_t> needed_;
  std::vector<uint64_t> dilated_;
};

/// Splits rows [0, ny) into `shares`, balanced by the occupied voxels of `columns`: share i has
/// rows [result[i], result[i + 1]).
template <typename Map>
std::vector<int> shareRows(const Map& map, const ColumnSet& columns, int shares) {
  const MapShape& shape = map.shape();
  if (shares == 1) return {0, shape.ny};
  std::vector<std::size_t> voxels_before(shape.ny + 1, 0);
  for (int y = 0; y < shape.ny; ++y) {
    std::size_t voxels = 0;
    bit_mask::forEachSet(columns.row(y), columns.words(),
                         [&](int x) { voxels += map.recordCount(map.columnAt(x, y)); });
    voxels_before[y + 1] = voxels_before[y] + voxels;
  }
  std::vector<int> rows = {0};
  for (int share = 1; share < shares; ++share) {
    const std::size_t target = voxels_before.back() * share / shares;
    const auto it = std::lower_bound(voxels_before.begin(), voxels_before.end(), target);
    rows.push_back(std::min(static_cast<int>(it - voxels_before.begin()), shape.ny));
  }
  rows.push_back(shape.ny);
  return rows;
}

}  // namespace ladar_perception
