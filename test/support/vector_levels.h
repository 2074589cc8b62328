// SPDX-License-Identifier: BSD-3-Clause
// Tests that run on every vector level this CPU has.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "vector_level_limit.h"

namespace ladar_perception::test {

class VectorLevels : public testing::TestWithParam<VectorLevel> {
 protected:
  void SetUp() override {
    if (GetParam() > bestVectorLevel()) {
      GTEST_SKIP() << "this CPU has no " << vectorLevelName(GetParam());
    }
  }
  /// What `compute` gives at the baseline, and at the level of the test.
  template <typename Compute>
  auto atBaseline(const Compute& compute) const {
    const VectorLevelLimit limit(VectorLevel::kBaseline);
    return compute();
  }
  template <typename Compute>
  auto atLevel(const Compute& compute) const {
    const VectorLevelLimit limit(GetParam());
    EXPECT_EQ(vectorLevel(), GetParam());
    return compute();
  }
};

/// Bits, so that a NaN is itself and -0 is not 0.
template <typename T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

inline bool areFinite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](float value) { return std::isfinite(value); });
}

}  // namespace ladar_perception::test
