// SPDX-License-Identifier: BSD-3-Clause
// exp and log for arrays, written so that compilers vectorise them: the library's own are calls
// that stop that, and their last bits differ between versions of libm.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace ladar_perception::block_math {

inline float fromBits(int32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

inline int32_t toBits(float value) {
  int32_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

/// e^x for x <= 0, relative error below 2e-7; 0 below -87.
inline float expNegative(float x) {
  const float clamped = std::max(x, -87.0F);
  const float n = static_cast<float>(static_cast<int32_t>(clamped * 1.44269504F - 0.5F));
  // x = n ln 2 + r, |r| <= ln 2 / 2; ln 2 in two parts so that n ln 2 is exact.
  const float r = (clamped - n * 0.693359375F) + n * 2.12194440e-4F;
  float p = 1.0F / 5040.0F;
  p = p * r + 1.0F / 720.0F;
  p = p * r + 1.0F / 120.0F;
  p = p * r + 1.0F / 24.0F;
  p = p * r + 1.0F / 6.0F;
  p = p * r + 0.5F;
  p = p * r + 1.0F;
  p = p * r + 1.0F;
  const float power = fromBits((static_cast<int32_t>(n) + 127) << 23);
  return x < -87.0F ? 0.0F : p * power;
}

/// log(1 + e) for e in [0, 1], absolute error below 2e-7, by log(1 + e) = 2 atanh(e / (2 + e)).
inline float log1pUnit(float e) {
  const float s = e / (2.0F + e);  // in [0, 1/3]
  const float s2 = s * s;
  float p = 1.0F / 13.0F;
  p = p * s2 + 1.0F / 11.0F;
  p = p * s2 + 1.0F / 9.0F;
  p = p * s2 + 1.0F / 7.0F;
  p = p * s2 + 1.0F / 5.0F;
  p = p * s2 + 1.0F / 3.0F;
  p = p * s2 + 1.0F;
  return 2.0F * s * p;
}

/// sum[i] = log(e^a[i] + e^sum[i])
template <int kSize>
void logAddExp(const float* a, float* sum) {
  for (int i = 0; i < kSize; ++i) {
    const float greater = std::max(a[i], sum[i]);
    const float lesser = std::min(a[i], sum[i]);
    sum[i] = greater + log1pUnit(expNegative(lesser - greater));
  }
}

}  // namespace ladar_perception::block_math
