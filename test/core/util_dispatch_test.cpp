// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>

#include "ladar_perception/util/dispatch.h"
#include "vector_level_limit.h"

namespace ladar_perception {
namespace {

using test::kVectorLevels;
using test::VectorLevelLimit;

class VectorLevels : public testing::TestWithParam<VectorLevel> {};

TEST_P(VectorLevels, LimitsAreKeptAsFarAsTheCpuGoes) {
  const VectorLevel before = vectorLevel();
  {
    const VectorLevelLimit limit(GetParam());
    EXPECT_EQ(vectorLevel(), std::min(GetParam(), bestVectorLevel()));
    limitVectorLevel(GetParam());
    EXPECT_EQ(vectorLevel(), std::min(GetParam(), bestVectorLevel()));
  }
  EXPECT_EQ(vectorLevel(), before);
}

TEST_P(VectorLevels, DispatchRunsTheBodyOnce) {
  const VectorLevelLimit limit(GetParam());
  int runs = 0;
  dispatch([&]() LADAR_INLINE_LAMBDA { ++runs; });
  EXPECT_EQ(runs, 1);
  dispatch([&]() LADAR_INLINE_LAMBDA { dispatch([&]() LADAR_INLINE_LAMBDA { ++runs; }); });
  EXPECT_EQ(runs, 2);
}

/// A body that only reads what it captures is called just the same.
TEST_P(VectorLevels, DispatchTakesNamedBodies) {
  const VectorLevelLimit limit(GetParam());
  int result = 0;
  const int* three = nullptr;
  const int number = 3;
  three = &number;
  const auto body = [&result, three]() LADAR_INLINE_LAMBDA { result += *three; };
  dispatch(body);
  dispatch(body);
  EXPECT_EQ(result, 6);
}

TEST_P(VectorLevels, LoopsGiveTheSameBits) {
  constexpr int kCount = 1000;
  const auto loop = [](float* values) {
    dispatch([&]() LADAR_INLINE_LAMBDA {
      for (int i = 0; i < kCount; ++i) {
        const auto x = static_cast<float>(i + 1);
        // A fused multiply-add would round once where this rounds twice.
        values[i] = x * x * 0.1F + x / 3.0F - 1.0F / x;
      }
    });
  };
  float expected[kCount];
  float found[kCount];
  {
    const VectorLevelLimit baseline(VectorLevel::kBaseline);
    loop(expected);
  }
  const VectorLevelLimit limit(GetParam());
  loop(found);
  for (int i = 0; i < kCount; ++i) ASSERT_EQ(found[i], expected[i]) << i;
}

/// Starts this program anew, as the environment is looked at once.
TEST_P(VectorLevels, TheEnvironmentCanAskForLess) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const VectorLevel expected = std::min(GetParam(), bestVectorLevel());
  EXPECT_EXIT(
      {
        setenv("LADAR_VECTOR_LEVEL", vectorLevelName(GetParam()), 1);
        std::exit(vectorLevel() == expected ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

INSTANTIATE_TEST_SUITE_P(All, VectorLevels, testing::ValuesIn(kVectorLevels),
                         [](const auto& level) { return vectorLevelName(level.param); });

TEST(VectorLevel, NothingElseInTheEnvironmentCounts) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const char* text : {"", "sse2", "AVX2", "avx", "avx2 "}) {
    EXPECT_EXIT(
        {
          setenv("LADAR_VECTOR_LEVEL", text, 1);
          std::exit(vectorLevel() == bestVectorLevel() ? 0 : 1);
        },
        testing::ExitedWithCode(0), "")
        << text;
  }
}

TEST(VectorLevel, NamesAreUniqueAndKnown) {
  std::set<std::string> names;
  for (const VectorLevel level : kVectorLevels) names.insert(vectorLevelName(level));
  EXPECT_EQ(names, (std::set<std::string>{"baseline", "avx2", "avx512"}));
}

TEST(VectorLevel, EveryCpuHasTheBaseline) {
  EXPECT_GE(bestVectorLevel(), VectorLevel::kBaseline);
  EXPECT_LE(vectorLevel(), bestVectorLevel());
  const VectorLevelLimit limit(VectorLevel::kBaseline);
  EXPECT_EQ(vectorLevel(), VectorLevel::kBaseline);
}

}  // namespace
}  // namespace ladar_perception
