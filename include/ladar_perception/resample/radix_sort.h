// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace ladar_perception {

struct KeyedIndex {
  uint64_t key;
  uint32_t index;
};

/// Sorts by key; entries of one key keep their order. Time grows with the bits in which keys
/// differ.
void radixSort(std::vector<KeyedIndex>* entries);

}  // namespace ladar_perception
