// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "ladar_perception/resample/parallel.h"

namespace ladar_perception {
namespace {

TEST(ResampleParallel, EveryEntryOnce) {
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    for (const std::size_t size : {0, 1, 9, 10, 11, 1000, 1003}) {
      std::vector<int> times(size, 0);
      parallelFor(&pool, size, 10, [&](std::size_t begin, std::size_t end) {
        ASSERT_LT(begin, end);
        ASSERT_LE(end, size);
        for (std::size_t i = begin; i < end; ++i) ++times[i];
      });
      EXPECT_EQ(times, std::vector<int>(size, 1)) << threads << " threads";
    }
  }
}

TEST(ResampleParallel, PiecesAreOfTheSizeAskedFor) {
  ThreadPool pool(2);
  parallelFor(&pool, 95, 10, [](std::size_t begin, std::size_t end) {
    EXPECT_EQ(begin % 10, 0u);
    EXPECT_EQ(end - begin, begin == 90 ? 5u : 10u);
  });
}

}  // namespace
}  // namespace ladar_perception
