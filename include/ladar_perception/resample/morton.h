// SPDX-License-Identifier: BSD-3-Clause
// Morton (Z-order) keys: cells that are close in space are close in a sorted array, and the cells
// of a cube of 2^k cells are a run of it.
#pragma once

#include <cstdint>

namespace ladar_perception::morton {

constexpr int kBitsPerAxis = 21;
constexpr uint64_t kAxisX = 0x1249249249249249ULL;
constexpr uint64_t kAxisY = kAxisX << 1;
constexpr uint64_t kAxisZ = kAxisX << 2;

/// Every third bit from the lowest 21 bits of `value`.
constexpr uint64_t spread(uint64_t value) {
  value &= 0x1fffffULL;
  value = (value | value << 32) & 0x001f00000000ffffULL;
  value = (value | value << 16) & 0x001f0000ff0000ffULL;
  value = (value | value << 8) & 0x100f00f00f00f00fULL;
  value = (value | value << 4) & 0x10c30c30c30c30c3ULL;
  return (value | value << 2) & kAxisX;
}

constexpr uint32_t compact(uint64_t value) {
  value &= kAxisX;
  value = (value | value >> 2) & 0x10c30c30c30c30c3ULL;
  value = (value | value >> 4) & 0x100f00f00f00f00fULL;
  value = (value | value >> 8) & 0x001f0000ff0000ffULL;
  value = (value | value >> 16) & 0x001f00000000ffffULL;
  return static_cast<uint32_t>((value | value >> 32) & 0x1fffffULL);
}

/// Coordinates in [0, 2^21).
constexpr uint64_t encode(uint32_t x, uint32_t y, uint32_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}
constexpr uint32_t x(uint64_t key) { return compact(key); }
constexpr uint32_t y(uint64_t key) { return compact(key >> 1); }
constexpr uint32_t z(uint64_t key) { return compact(key >> 2); }

/// The key one step on along the axis of `mask`, wrapping at the ends.
constexpr uint64_t next(uint64_t key, uint64_t mask) {
  return (((key | ~mask) + 1) & mask) | (key & ~mask);
}
constexpr uint64_t previous(uint64_t key, uint64_t mask) {
  return (((key & mask) - 1) & mask) | (key & ~mask);
}
/// Steps of -1, 0 or 1.
constexpr uint64_t step(uint64_t key, uint64_t mask, int by) {
  return by > 0 ? next(key, mask) : by < 0 ? previous(key, mask) : key;
}
/// The key of one of the 27 cells around (x fastest, 13 is the cell itself).
constexpr uint64_t around(uint64_t key, int place) {
  key = step(key, kAxisX, place % 3 - 1);
  key = step(key, kAxisY, place / 3 % 3 - 1);
  return step(key, kAxisZ, place / 9 - 1);
}
/// Any number of steps on or back.
constexpr uint64_t jump(uint64_t key, uint64_t mask, int by) {
  const uint64_t lowest = mask & (~mask + 1);
  const uint64_t offset = spread(static_cast<uint32_t>(by < 0 ? -by : by)) * lowest;
  const uint64_t moved = by < 0 ? (key & mask) - offset : (key | ~mask) + offset;
  return (moved & mask) | (key & ~mask);
}

}  // namespace ladar_perception::morton
