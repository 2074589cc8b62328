// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/radix_sort.h"

#include <array>

namespace ladar_perception {

void radixSort(std::vector<KeyedIndex>* entries) {
  constexpr int kDigitBits = 11;
  constexpr uint64_t kDigits = uint64_t{1} << kDigitBits;
  if (entries->empty()) return;
  uint64_t differing = 0;
  for (const KeyedIndex& entry : *entries) differing |= entry.key ^ entries->front().key;
  std::vector<KeyedIndex> other(entries->size());
  // Least significant digit first.
  for (int shift = 0; shift < 64 && differing >> shift != 0; shift += kDigitBits) {
    if ((differing >> shift & (kDigits - 1)) == 0) continue;
    std::array<uint32_t, kDigits> place{};
    for (const KeyedIndex& entry : *entries) ++place[entry.key >> shift & (kDigits - 1)];
    uint32_t sum = 0;
    for (uint32_t& first : place) {
      const uint32_t count = first;
      first = sum;
      sum += count;
    }
    for (const KeyedIndex& entry : *entries) {
      other[place[entry.key >> shift & (kDigits - 1)]++] = entry;
    }
    entries->swap(other);
  }
}

}  // namespace ladar_perception
