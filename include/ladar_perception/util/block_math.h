// SPDX-License-Identifier: BSD-3-Clause
// Elementary functions written so that compilers vectorise loops over them: the library's own are
// calls that stop that, and their last bits differ between versions of libm.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception::block_math {

LADAR_INLINE float fromBits(int32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

LADAR_INLINE int32_t toBits(float value) {
  int32_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

/// e^x for x <= 0, relative error below 2e-7; e^-87 = 1.6e-38 below -87 (a choice of 0 would be a
/// branch to some compilers, and the loop would not be vectorised).
LADAR_INLINE float expNegative(float x) {
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
  return p * power;
}

/// log(1 + e) for e in [0, 1], absolute error below 2e-7, by log(1 + e) = 2 atanh(e / (2 + e)).
LADAR_INLINE float log1pUnit(float e) {
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

/// log(x) for normal x > 0, absolute error below 2e-7 near 1 and relative elsewhere: x = 2^n m with
/// m in [1 / sqrt(2), sqrt(2)], log(m) = 2 atanh((m - 1) / (m + 1)).
LADAR_INLINE float logPositive(float x) {
  const int32_t n = (toBits(x) - 0x3f3504f3) >> 23;  // 0x3f3504f3: 1 / sqrt(2)
  const float m = fromBits(toBits(x) - static_cast<int32_t>(static_cast<uint32_t>(n) << 23));
  const float s = (m - 1.0F) / (m + 1.0F);
  const float s2 = s * s;
  float p = 1.0F / 9.0F;
  p = p * s2 + 1.0F / 7.0F;
  p = p * s2 + 1.0F / 5.0F;
  p = p * s2 + 1.0F / 3.0F;
  p = p * s2 + 1.0F;
  return static_cast<float>(n) * 0.693147181F + 2.0F * s * p;
}

/// Cube root of x >= 0, relative error below 3e-7: a guess from the bits, then Halley twice.
LADAR_INLINE float cubeRoot(float x) {
  float y = fromBits(toBits(x) / 3 + 0x2a514067);
  for (int i = 0; i < 2; ++i) {
    const float y3 = y * y * y;
    y *= (y3 + 2.0F * x) / (2.0F * y3 + x);
  }
  return x > 1e-30F ? y : 0.0F;
}

/// Angle in [0, pi/2] of a direction to the vertical from its horizontal length and its height (of
/// either sign), absolute error below 3e-7: arc tangent of the lesser over the greater, by the
/// polynomial of Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.49.
LADAR_INLINE float angleToVertical(float horizontal, float height) {
  const float vertical = std::abs(height);
  const float greater = std::max(horizontal, vertical);
  const float t = std::min(horizontal, vertical) / std::max(greater, 1e-30F);
  const float t2 = t * t;
  float p = 0.0028662257F;
  p = p * t2 - 0.0161657367F;
  p = p * t2 + 0.0429096138F;
  p = p * t2 - 0.0752896400F;
  p = p * t2 + 0.1065626393F;
  p = p * t2 - 0.1420889944F;
  p = p * t2 + 0.1999355085F;
  p = p * t2 - 0.3333314528F;
  p = p * t2 + 1.0F;
  const float angle = p * t;
  return horizontal > vertical ? 1.57079637F - angle : angle;
}

/// sum[i] = log(e^a[i] + e^sum[i])
template <int kSize>
LADAR_INLINE void logAddExp(const float* __restrict__ a, float* __restrict__ sum) {
  for (int i = 0; i < kSize; ++i) {
    const float greater = std::max(a[i], sum[i]);
    const float lesser = std::min(a[i], sum[i]);
    sum[i] = greater + log1pUnit(expNegative(lesser - greater));
  }
}

}  // namespace ladar_perception::block_math
