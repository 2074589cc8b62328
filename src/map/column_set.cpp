// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/map/column_set.h"

#include <algorithm>
#include <cassert>

namespace ladar_perception {

void ColumnSet::resize(int nx, int ny) {
  nx_ = nx;
  ny_ = ny;
  words_ = (nx + 63) / 64;
  bits_.assign(static_cast<std::size_t>(words_) * ny, 0);
}

std::size_t ColumnSet::size() const {
  std::size_t size = 0;
  for (const uint64_t word : bits_) size += static_cast<std::size_t>(__builtin_popcountll(word));
  return size;
}

void ColumnSet::assignAll(int nx, int ny) {
  resize(nx, ny);
  for (int y = 0; y < ny; ++y) {
    for (int x = 0; x < nx; x += 64) {
      rowOf(y)[x / 64] = nx - x >= 64 ? ~uint64_t{0} : (uint64_t{1} << (nx - x)) - 1;
    }
  }
}

void ColumnSet::assignAffected(const std::vector<ColumnIndex>& changed, const VoxelIndex& min,
                               const MapShape& shape, int radius) {
  resize(shape.nx, shape.ny);
  // Along x while marking (a run of bits per column), along y by or-ing rows; rows have a margin,
  // for columns outside the window have neighbours inside.
  std::vector<uint64_t> along_x(static_cast<std::size_t>(words_) * (shape.ny + 2 * radius), 0);
  for (const ColumnIndex& column : changed) {
    const int64_t y = int64_t{column.y} - min.y + radius;
    const int64_t x = int64_t{column.x} - min.x;
    if (y < 0 || y >= shape.ny + 2 * radius) continue;
    uint64_t* row = along_x.data() + y * words_;
    const int64_t last = std::min<int64_t>(x + radius, shape.nx - 1);
    for (int64_t i = std::max<int64_t>(x - radius, 0); i <= last; ++i) {
      row[i / 64] |= uint64_t{1} << (i % 64);
    }
  }
  for (int y = 0; y < shape.ny; ++y) {
    for (int dy = 0; dy <= 2 * radius; ++dy) {
      const uint64_t* row = along_x.data() + static_cast<std::size_t>(y + dy) * words_;
      for (int word = 0; word < words_; ++word) rowOf(y)[word] |= row[word];
    }
  }
}

void ColumnSet::assignDilated(const ColumnSet& other, int radius) {
  resize(other.nx_, other.ny_);
  std::vector<uint64_t> row(words_);
  for (int y = 0; y < ny_; ++y) {
    dilateBits(other.row(y), words_, radius, row.data());
    // A row has bits for whole words; there are no columns beyond nx.
    if (nx_ % 64 != 0) row[words_ - 1] &= (uint64_t{1} << (nx_ % 64)) - 1;
    const int last = std::min(y + radius, ny_ - 1);
    for (int near = std::max(y - radius, 0); near <= last; ++near) {
      for (int word = 0; word < words_; ++word) rowOf(near)[word] |= row[word];
    }
  }
}

void ColumnSet::add(const ColumnSet& other) {
  assert(nx_ == other.nx_ && ny_ == other.ny_);
  for (std::size_t word = 0; word < bits_.size(); ++word) bits_[word] |= other.bits_[word];
}

void dilateBits(const uint64_t* in, int words, int radius, uint64_t* out) {
  std::copy(in, in + words, out);
  for (int distance = 1; distance <= radius; ++distance) {
    const int whole = distance / 64;
    const int bits = distance % 64;
    const auto at = [&](int word) { return word >= 0 && word < words ? in[word] : uint64_t{0}; };
    for (int word = 0; word < words; ++word) {
      const uint64_t up = bits == 0
                              ? at(word - whole)
                              : at(word - whole) << bits | at(word - whole - 1) >> (64 - bits);
      const uint64_t down = bits == 0
                                ? at(word + whole)
                                : at(word + whole) >> bits | at(word + whole + 1) << (64 - bits);
      out[word] |= up | down;
    }
  }
}

}  // namespace ladar_perception
