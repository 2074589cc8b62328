// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "ladar_perception/map/moments.h"
#include "ladar_perception/map/record_arena.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::TestRandom;

/// A record that can be told from every other.
Moments mark(int64_t number) {
  Moments moments;
  moments.add({number, 3 * number, -number});
  return moments;
}

void expectRun(const RecordArena<Moments>& arena, const RecordRun& run,
               const std::vector<int64_t>& expected) {
  ASSERT_EQ(run.count, expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(arena.records(run)[i], mark(expected[i])) << i;
  }
}

TEST(RecordArena, ANewRecordIsEmptyAndMovesLaterOnesUp) {
  RecordArena<Moments> arena;
  RecordRun run;
  arena.insert(&run, 0) = mark(10);
  arena.insert(&run, 1) = mark(30);
  EXPECT_EQ(arena.insert(&run, 1), Moments());
  arena.records(run)[1] = mark(20);
  arena.insert(&run, 0) = mark(5);
  expectRun(arena, run, {5, 10, 20, 30});
}

TEST(RecordArena, ReusedRoomStartsEmpty) {
  RecordArena<Moments> arena;
  RecordRun run;
  for (int i = 0; i < 8; ++i) arena.insert(&run, i) = mark(i);
  arena.keep(&run, 0, 0);
  RecordRun other;
  for (int i = 0; i < 8; ++i) EXPECT_EQ(arena.insert(&other, i), Moments());
}

TEST(RecordArena, KeepsTheRecordsAskedFor) {
  RecordArena<Moments> arena;
  RecordRun run;
  for (int i = 0; i < 10; ++i) arena.insert(&run, i) = mark(i);
  arena.keep(&run, 2, 6);
  expectRun(arena, run, {2, 3, 4, 5, 6, 7});
  arena.keep(&run, 0, 3);
  expectRun(arena, run, {2, 3, 4});
  arena.keep(&run, 0, 0);
  EXPECT_EQ(run.count, 0);
  EXPECT_EQ(run.room_class, -1);
}

/// A thousand runs changed at random, beside vectors that are changed the same way.
class ManyRuns {
 public:
  explicit ManyRuns(uint64_t seed) : random_(seed), runs_(1000), expected_(1000) {}

  void step() {
    const auto i = static_cast<std::size_t>(random_.integer(0, 999));
    std::vector<int64_t>& marks = expected_[i];
    const int64_t size = static_cast<int64_t>(marks.size());
    if (random_.integer(0, 9) > 0 && size < 60) {
      const int64_t rank = random_.integer(0, size);
      arena_.insert(&runs_[i], static_cast<uint32_t>(rank)) = mark(++next_);
      marks.insert(marks.begin() + rank, next_);
    } else {
      const int64_t first = random_.integer(0, size);
      const int64_t count = random_.integer(0, size - first);
      arena_.keep(&runs_[i], static_cast<uint32_t>(first), static_cast<uint32_t>(count));
      marks = {marks.begin() + first, marks.begin() + first + count};
    }
  }
  void expectAll() const {
    for (std::size_t i = 0; i < runs_.size(); ++i) expectRun(arena_, runs_[i], expected_[i]);
  }
  std::size_t bytes() const { return arena_.bytes(); }

 private:
  TestRandom random_;
  RecordArena<Moments> arena_;
  std::vector<RecordRun> runs_;
  std::vector<std::vector<int64_t>> expected_;
  int64_t next_ = 0;
};

TEST(RecordArena, RunsNeverDisturbEachOther) {
  ManyRuns runs(1);
  for (int round = 0; round < 20; ++round) {
    for (int i = 0; i < 5000; ++i) runs.step();
    runs.expectAll();
  }
}

TEST(RecordArena, MemoryStaysBoundedUnderUse) {
  ManyRuns runs(2);
  for (int i = 0; i < 200000; ++i) runs.step();
  const std::size_t settled = runs.bytes();
  for (int i = 0; i < 800000; ++i) runs.step();
  EXPECT_LE(runs.bytes(), settled * 3 / 2);
}

TEST(RecordArena, ClearForgetsButKeepsTheMemory) {
  RecordArena<Moments> arena;
  const auto fill = [&] {
    std::vector<RecordRun> runs(100);
    for (auto& run : runs) {
      for (int i = 0; i < 20; ++i) arena.insert(&run, i) = mark(i);
    }
    for (const auto& run : runs)
      expectRun(arena, run, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19});
  };
  fill();
  const std::size_t bytes = arena.bytes();
  for (int i = 0; i < 10; ++i) {
    arena.clear();
    fill();
  }
  EXPECT_EQ(arena.bytes(), bytes);
}

}  // namespace
}  // namespace ladar_perception
