// SPDX-License-Identifier: BSD-3-Clause
// Masks of a column's occupied voxels: bit z of an array of 64-bit words.
#pragma once

#include <cstdint>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception::bit_mask {

LADAR_INLINE bool test(const uint64_t* mask, int z) { return (mask[z / 64] >> (z % 64) & 1) != 0; }

/// Set bits at positions below `z`; z may be the number of bits.
LADAR_INLINE int countBelow(const uint64_t* mask, int z) {
  int count = 0;
  for (int word = 0; word < z / 64; ++word) count += __builtin_popcountll(mask[word]);
  if (z % 64 != 0) {
    count += __builtin_popcountll(mask[z / 64] & ((uint64_t{1} << (z % 64)) - 1));
  }
  return count;
}

/// Moves every bit up by `distance` (down when negative); bits moved out are lost.
inline void shift(uint64_t* mask, int words, int distance) {
  const int whole = distance / 64;
  const int bits = distance % 64;
  const auto at = [&](int word) { return word >= 0 && word < words ? mask[word] : uint64_t{0}; };
  if (distance > 0) {
    for (int word = words - 1; word >= 0; --word) {
      mask[word] = bits == 0 ? at(word - whole)
                             : at(word - whole) << bits | at(word - whole - 1) >> (64 - bits);
    }
  } else if (distance < 0) {
    for (int word = 0; word < words; ++word) {
      mask[word] = bits == 0 ? at(word - whole)
                             : at(word - whole) >> -bits | at(word - whole + 1) << (64 + bits);
    }
  }
}

/// Clears the bits at positions `z` and above.
inline void clearFrom(uint64_t* mask, int words, int z) {
  if (z / 64 >= words) return;
  mask[z / 64] &= (uint64_t{1} << (z % 64)) - 1;
  for (int word = z / 64 + 1; word < words; ++word) mask[word] = 0;
}

/// Calls `visit(z)` for every set bit, in ascending order.
template <typename Visitor>
LADAR_INLINE void forEachSet(const uint64_t* mask, int words, Visitor&& visit) {
  for (int word = 0; word < words; ++word) {
    for (uint64_t bits = mask[word]; bits != 0; bits &= bits - 1) {
      visit(word * 64 + __builtin_ctzll(bits));
    }
  }
}

}  // namespace ladar_perception::bit_mask
