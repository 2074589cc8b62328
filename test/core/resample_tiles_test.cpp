// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/tiles.h"
#include "test_random.h"

namespace ladar_perception::test {
namespace {

constexpr uint32_t kMiddle = 1U << 19;

/// Keys of random cells of a cube of that edge around the middle of the grid.
std::vector<uint64_t> randomKeys(int count, int64_t edge) {
  TestRandom random(2);
  std::vector<uint64_t> keys;
  for (int i = 0; i < count; ++i) {
    const auto coordinate = [&] {
      return kMiddle - 40U + static_cast<uint32_t>(random.integer(0, edge - 1));
    };
    const uint32_t x = coordinate();
    const uint32_t y = coordinate();
    keys.push_back(morton::encode(x, y, coordinate()));
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

bool touch(uint64_t a, uint64_t b) {
  const auto near = [](uint32_t p, uint32_t q) {
    return std::abs(static_cast<int>(p) - static_cast<int>(q)) <= 1;
  };
  return near(morton::x(a), morton::x(b)) && near(morton::y(a), morton::y(b)) &&
         near(morton::z(a), morton::z(b));
}

TEST(ResampleTiles, AreRunsOfCellsOfOneCube) {
  const std::vector<uint64_t> keys = randomKeys(3000, 100);
  const Tiles tiles(keys, 4);
  uint32_t next = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    EXPECT_EQ(tiles.tile(i).first, next);
    ASSERT_GT(tiles.tile(i).end, next);
    next = tiles.tile(i).end;
    EXPECT_EQ(keys[tiles.tile(i).first] >> 12, keys[next - 1] >> 12);
    if (next == keys.size()) break;
    EXPECT_NE(keys[next] >> 12, keys[next - 1] >> 12);
  }
  EXPECT_EQ(next, keys.size());
}

/// Of two tiles that touch, the one of the lesser colour ends before the other begins; every tile
/// has its turn once.
TEST(ResampleTiles, RunOneAfterTheOtherWhereTheyTouch) {
  const std::vector<uint64_t> keys = randomKeys(4000, 90);
  const Tiles tiles(keys, 4);
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    std::mutex mutex;
    std::size_t clock = 0;
    std::vector<std::size_t> begins(tiles.size(), 0);
    std::vector<std::size_t> ends(tiles.size(), 0);
    tiles.run(&pool, [&](int thread, std::size_t tile) {
      {
        const std::lock_guard<std::mutex> lock(mutex);
        EXPECT_TRUE(thread >= 0 && thread < threads);
        EXPECT_EQ(begins[tile], 0u);
        begins[tile] = ++clock;
      }
      std::this_thread::yield();
      const std::lock_guard<std::mutex> lock(mutex);
      ends[tile] = ++clock;
    });
    EXPECT_EQ(clock, 2 * tiles.size());
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const uint64_t key = keys[tiles.tile(i).first] >> 12;
      for (std::size_t k = 0; k < tiles.size(); ++k) {
        const uint64_t other = keys[tiles.tile(k).first] >> 12;
        if (i == k || !touch(key, other)) continue;
        ASSERT_NE(key & 7, other & 7);
        if ((key & 7) > (other & 7)) continue;
        EXPECT_LT(ends[i], begins[k]);
      }
    }
  }
}

TEST(ResampleTiles, OfNoCells) {
  const Tiles tiles({}, 4);
  EXPECT_EQ(tiles.size(), 0u);
  for (const int threads : {1, 2}) {
    ThreadPool pool(threads);
    tiles.run(&pool, [](int, std::size_t) { ADD_FAILURE(); });
  }
}

}  // namespace
}  // namespace ladar_perception::test
