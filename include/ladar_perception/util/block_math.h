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

/// Cube root of x >= 0, relative error below 3e-7: a guess from the bits, then Halley twice.
LADAR_INLINE float cubeRoot(float x) {
  float y = fromBits(toBits(x) / 3 + 0x2a514067);
  for (int i = 0; i < 2; ++i) {
    const float y3 = y * y * y;
    y *= (y3 + 2.0F * x) / (2.0F * y3 + x);
  }
  return x > 1e-30F ? y : 0.0F;
}

/// Angle in [0, pi/2] whose cosine is |c|, absolute error below 3e-7 (Abramowitz and Stegun,
/// Handbook of Mathematical Functions, 4.4.46). |c| may exceed 1 by rounding.
LADAR_INLINE float acosAbsolute(double c) {
  const double x = std::min(std::abs(c), 1.0);
  double p = -0.0012624911;
  p = p * x + 0.0066700901;
  p = p * x - 0.0170881256;
  p = p * x + 0.0308918810;
  p = p * x - 0.0501743046;
  p = p * x + 0.0889789874;
  p = p * x - 0.2145988016;
  p = p * x + 1.5707963050;
  return static_cast<float>(std::sqrt(1.0 - x) * p);
}

/// sum[i] = log(e^a[i] + e^sum[i])
template <int kSize>
LADAR_INLINE void logAddExp(const float* a, float* sum) {
  for (int i = 0; i < kSize; ++i) {
    const float greater = std::max(a[i], sum[i]);
    const float lesser = std::min(a[i], sum[i]);
    sum[i] = greater + log1pUnit(expNegative(lesser - greater));
  }
}

}  // namespace ladar_perception::block_math
