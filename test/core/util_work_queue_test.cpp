// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "ladar_perception/util/work_queue.h"

namespace ladar_perception {
namespace {

using std::chrono::milliseconds;

TEST(WorkQueue, TheOldestLeavesWhenItIsFull) {
  WorkQueue<int> queue(2);
  EXPECT_EQ(queue.pushOverOldest(1), std::nullopt);
  EXPECT_EQ(queue.pushOverOldest(2), std::nullopt);
  EXPECT_EQ(queue.pushOverOldest(3), 1);
  EXPECT_EQ(queue.size(), 2U);
  EXPECT_EQ(queue.pop(), 2);
  EXPECT_EQ(queue.pop(), 3);
  EXPECT_EQ(queue.pop(milliseconds(1)), std::nullopt);
}

TEST(WorkQueue, HoldsWhatCannotBeCopied) {
  WorkQueue<std::unique_ptr<int>> queue(1);
  EXPECT_TRUE(queue.pushWhenRoom(std::make_unique<int>(5)));
  const auto displaced = queue.pushOverOldest(std::make_unique<int>(6));
  ASSERT_TRUE(displaced);
  EXPECT_EQ(**displaced, 5);
  EXPECT_EQ(**queue.pop(), 6);
}

TEST(WorkQueue, WhoeverNeedsRoomWaitsForIt) {
  // Faster on one side, then on the other: everything comes, in order.
  for (const bool slow_reader : {true, false}) {
    constexpr int kItems = 200;
    WorkQueue<int> queue(3);
    std::atomic<std::size_t> most{0};
    std::thread writer([&] {
      for (int i = 0; i < kItems; ++i) {
        if (!slow_reader && i % 50 == 0) std::this_thread::sleep_for(milliseconds(5));
        EXPECT_TRUE(queue.pushWhenRoom(i));
        most = std::max(most.load(), queue.size());
      }
    });
    for (int i = 0; i < kItems; ++i) {
      if (slow_reader && i % 50 == 0) std::this_thread::sleep_for(milliseconds(5));
      ASSERT_EQ(queue.pop(), i);
    }
    writer.join();
    EXPECT_LE(most.load(), 3U);
  }
}

TEST(WorkQueue, StoppingEndsEveryWait) {
  WorkQueue<int> empty(1);
  WorkQueue<int> full(1);
  ASSERT_TRUE(full.pushWhenRoom(1));
  std::atomic<int> ended{0};
  std::vector<std::thread> waiting;
  waiting.emplace_back([&] { ended += empty.pop() ? 100 : 1; });
  waiting.emplace_back([&] { ended += empty.pop(std::chrono::hours(1)) ? 100 : 1; });
  waiting.emplace_back([&] { ended += full.pushWhenRoom(2) ? 100 : 1; });
  waiting.emplace_back(
      [&] { ended += empty.pollUntil([] { return false; }, std::chrono::hours(1)) ? 100 : 1; });
  std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(ended.load(), 0);
  EXPECT_FALSE(empty.stopped());
  empty.stop();
  full.stop();
  for (std::thread& thread : waiting) thread.join();
  EXPECT_EQ(ended.load(), 4);
  EXPECT_TRUE(empty.stopped());
  EXPECT_EQ(full.pop(), std::nullopt) << "what is left is left";
}

TEST(WorkQueue, AsksUntilItIsSoOrTimeIsUp) {
  WorkQueue<int> queue(1);
  int asked = 0;
  EXPECT_TRUE(queue.pollUntil([&] { return ++asked == 3; }, std::chrono::hours(1)));
  EXPECT_EQ(asked, 3);
  EXPECT_FALSE(queue.pollUntil([] { return false; }, milliseconds(10)));
  asked = 0;
  EXPECT_TRUE(queue.pollUntil([&] { return ++asked == 1; }, milliseconds(0)))
      << "asked once, however little time there is";
}

}  // namespace
}  // namespace ladar_perception
