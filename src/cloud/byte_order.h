// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace ladar_perception {

constexpr bool kHostIsBigEndian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

/// Loads a scalar from unaligned bytes, reversing them when `swap`.
template <typename T>
T loadScalar(const uint8_t* bytes, bool swap) {
  uint8_t buffer[sizeof(T)];
  std::memcpy(buffer, bytes, sizeof(T));
  if (swap) std::reverse(buffer, buffer + sizeof(T));
  T value;
  std::memcpy(&value, buffer, sizeof(T));
  return value;
}

template <typename T>
void storeScalar(T value, bool swap, uint8_t* bytes) {
  std::memcpy(bytes, &value, sizeof(T));
  if (swap) std::reverse(bytes, bytes + sizeof(T));
}

}  // namespace ladar_perception
