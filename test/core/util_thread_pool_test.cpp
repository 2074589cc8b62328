// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <thread>
#include <vector>

#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {
namespace {

class Threads : public testing::TestWithParam<int> {};

TEST_P(Threads, EveryIndexRunsOnceInEveryRound) {
  ThreadPool pool(GetParam());
  ASSERT_EQ(pool.size(), GetParam());
  std::vector<int> calls(GetParam(), 0);  // not atomic: a race is for the sanitizer to find
  for (int round = 1; round <= 2000; ++round) {
    pool.run([&](int i) { ++calls[i]; });
    ASSERT_EQ(calls, std::vector<int>(GetParam(), round));
  }
}

TEST_P(Threads, RunReturnsOnlyWhenAllHaveEnded) {
  ThreadPool pool(GetParam());
  for (int round = 0; round < 20; ++round) {
    std::vector<int> ended(GetParam(), 0);
    pool.run([&](int i) {
      if (i != 0) std::this_thread::sleep_for(std::chrono::microseconds(200 * i));
      ended[i] = 1;
    });
    ASSERT_EQ(ended, std::vector<int>(GetParam(), 1));
  }
}

TEST_P(Threads, TasksRunAtTheSameTime) {
  ThreadPool pool(GetParam());
  std::atomic<int> arrived{0};
  // Would wait for ever if one task had to end before another begins.
  pool.run([&](int) {
    ++arrived;
    while (arrived < GetParam()) std::this_thread::yield();
  });
  EXPECT_EQ(arrived, GetParam());
}

TEST_P(Threads, ResultsOfARoundAreSeenByTheNext) {
  ThreadPool pool(GetParam());
  const int n = GetParam();
  std::vector<long> values(n, 1);
  std::vector<long> sums(n, 0);
  for (int round = 0; round < 100; ++round) {
    pool.run([&](int i) { sums[i] = values[i] + values[(i + 1) % n]; });
    pool.run([&](int i) { values[i] = sums[(i + 1) % n] % 1000; });
  }
  EXPECT_EQ(std::set<long>(values.begin(), values.end()).size(), 1U);
}

TEST_P(Threads, APoolThatNeverRanGoesAwayQuietly) {
  for (int i = 0; i < 20; ++i) ThreadPool pool(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Counts, Threads, testing::Values(1, 2, 3, 8));

TEST(ThreadPool, IndexZeroIsTheCaller) {
  ThreadPool pool(3);
  std::vector<std::thread::id> ids(3);
  pool.run([&](int i) { ids[i] = std::this_thread::get_id(); });
  EXPECT_EQ(ids[0], std::this_thread::get_id());
  EXPECT_EQ(std::set<std::thread::id>(ids.begin(), ids.end()).size(), 3U);
}

}  // namespace
}  // namespace ladar_perception
