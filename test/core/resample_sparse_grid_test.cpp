// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>
#include <string>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/sparse_grid.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Numbers = std::map<uint64_t, uint32_t>;

Numbers numbered(const std::set<uint64_t>& keys) {
  Numbers numbers;
  for (const uint64_t key : keys) {
    const auto number = static_cast<uint32_t>(numbers.size());
    numbers[key] = number;
  }
  return numbers;
}

uint32_t lookUp(const Numbers& numbers, uint64_t key) {
  const auto found = numbers.find(key);
  return found == numbers.end() ? kNoIndex : found->second;
}

uint64_t moved(uint64_t key, int dx, int dy, int dz) {
  return morton::encode(static_cast<uint32_t>(static_cast<int>(morton::x(key)) + dx),
                        static_cast<uint32_t>(static_cast<int>(morton::y(key)) + dy),
                        static_cast<uint32_t>(static_cast<int>(morton::z(key)) + dz));
}

SparseGrid gridOf(const std::set<uint64_t>& keys) {
  SparseGrid grid;
  grid.assign({keys.begin(), keys.end()});
  grid.linkBricks();
  return grid;
}

using Block = std::array<uint32_t, SparseGrid::kBlockCells>;

/// Numbers of the cells of a brick and around it.
Block blockOf(const SparseGrid& grid, std::size_t brick) {
  Block block;
  block.fill(kNoIndex);
  grid.visitBlock(brick, [&](uint32_t number, int place, uint32_t direction) {
    EXPECT_EQ(block.at(static_cast<std::size_t>(place)), kNoIndex);
    EXPECT_EQ(grid.keys()[number] >> 6, grid.bricks()[grid.brickAround(brick, direction)].key);
    block.at(static_cast<std::size_t>(place)) = number;
  });
  return block;
}

std::set<uint64_t> randomKeys(int64_t low, int64_t high, std::size_t count, uint64_t seed) {
  test::TestRandom random(seed);
  std::set<uint64_t> keys;
  const auto draw = [&] { return static_cast<uint32_t>(random.integer(low, high)); };
  for (std::size_t i = 0; i < count; ++i) {
    const uint32_t x = draw();
    const uint32_t y = draw();
    keys.insert(morton::encode(x, y, draw()));
  }
  return keys;
}

void expectBricks(const SparseGrid& grid) {
  uint32_t cells = 0;
  for (std::size_t brick = 0; brick < grid.bricks().size(); ++brick) {
    const SparseGrid::Brick& here = grid.bricks()[brick];
    ASSERT_EQ(here.first, cells);
    if (brick > 0) {
      ASSERT_LT(grid.bricks()[brick - 1].key, here.key);
    }
    ASSERT_EQ(grid.brickEnd(brick) - here.first,
              static_cast<uint32_t>(__builtin_popcountll(here.mask)));
    ASSERT_EQ(grid.findBrick(here.key), brick);
    for (; cells < grid.brickEnd(brick); ++cells) {
      ASSERT_EQ(grid.keys()[cells] >> 6, here.key);
      ASSERT_EQ(here.mask >> (grid.keys()[cells] & 63) & 1, 1u);
    }
  }
  ASSERT_EQ(cells, grid.size());
}

void expectFinds(const SparseGrid& grid, const Numbers& numbers, uint64_t seed) {
  for (const auto& [key, number] : numbers) {
    ASSERT_EQ(grid.find(key), number);
    for (int n = 0; n < 27; ++n) {
      const uint64_t near = moved(key, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      ASSERT_EQ(grid.find(near), lookUp(numbers, near));
    }
  }
  test::TestRandom random(seed);
  for (int i = 0; i < 5000; ++i) {
    const uint64_t key = random.engine()() >> 1;
    ASSERT_EQ(grid.find(key), lookUp(numbers, key));
  }
}

/// Every place of a block, where own cells have a neighbour; elsewhere a number, if there is one,
/// is the right one.
void expectBlocks(const SparseGrid& grid, const Numbers& numbers) {
  for (std::size_t brick = 0; brick < grid.bricks().size(); ++brick) {
    const Block block = blockOf(grid, brick);
    const uint64_t corner = grid.bricks()[brick].key << 6;
    for (int z = -1; z <= 4; ++z) {
      for (int y = -1; y <= 4; ++y) {
        for (int x = -1; x <= 4; ++x) {
          const auto place = static_cast<std::size_t>(SparseGrid::blockIndex(x, y, z));
          const uint32_t expected = lookUp(numbers, moved(corner, x, y, z));
          bool next_to_own = false;
          for (int n = 0; n < 27; ++n) {
            const uint64_t near = moved(corner, x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1);
            next_to_own = next_to_own || (near >> 6 == corner >> 6 &&
                                          (grid.bricks()[brick].mask >> (near & 63) & 1) != 0);
          }
          if (next_to_own || block[place] != kNoIndex) {
            ASSERT_EQ(block[place], expected) << brick << ": " << x << " " << y << " " << z;
          }
        }
      }
    }
  }
}

void expectBricksAround(const SparseGrid& grid) {
  for (std::size_t brick = 0; brick < grid.bricks().size(); ++brick) {
    for (uint32_t direction = 0; direction < 27; ++direction) {
      const auto d = static_cast<int>(direction);
      const uint64_t key = moved(grid.bricks()[brick].key, d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1);
      ASSERT_EQ(grid.brickAround(brick, direction), grid.findBrick(key)) << brick << " " << d;
    }
  }
}

/// The cells around every cell, each once, and the steps to them.
template <int kReach>
void expectNear(const SparseGrid& grid, const Numbers& numbers) {
  for (const auto& [key, number] : numbers) {
    std::set<uint32_t> expected;
    for (int dz = -kReach; dz <= kReach; ++dz) {
      for (int dy = -kReach; dy <= kReach; ++dy) {
        for (int dx = -kReach; dx <= kReach; ++dx) {
          const uint32_t near = lookUp(numbers, moved(key, dx, dy, dz));
          if (near != kNoIndex) expected.insert(near);
        }
      }
    }
    const auto bit = static_cast<int>(key & 63);
    std::set<uint32_t> visited;
    grid.visitNear<kReach>(
        grid.findBrick(key >> 6), bit, [&](uint32_t near, uint32_t direction, int near_bit) {
          EXPECT_TRUE(visited.insert(near).second);
          EXPECT_EQ(grid.keys()[near] & 63, static_cast<uint64_t>(near_bit));
          if (kReach > 1) return;
          const auto step = static_cast<int>(stepBetween(bit, direction, near_bit));
          EXPECT_EQ(moved(key, step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1), grid.keys()[near]);
        });
    ASSERT_EQ(visited, expected) << number;
  }
}

TEST(SparseGrid, PlacesInABlockAreDistinctAndInside) {
  std::set<int> places;
  for (int z = -1; z <= 4; ++z) {
    for (int y = -1; y <= 4; ++y) {
      for (int x = -1; x <= 4; ++x) places.insert(SparseGrid::blockIndex(x, y, z));
    }
  }
  EXPECT_EQ(places.size(), static_cast<std::size_t>(SparseGrid::kBlockCells));
  EXPECT_EQ(*places.begin(), 0);
  EXPECT_EQ(*places.rbegin(), SparseGrid::kBlockCells - 1);
}

TEST(SparseGrid, WithoutCells) {
  SparseGrid grid;
  EXPECT_EQ(grid.size(), 0u);
  EXPECT_EQ(grid.find(0), kNoIndex);
  EXPECT_EQ(grid.find(~uint64_t{0} >> 1), kNoIndex);
  grid.assign({});
  EXPECT_EQ(grid.size(), 0u);
  EXPECT_TRUE(grid.bricks().empty());
  EXPECT_EQ(grid.find(0), kNoIndex);
  EXPECT_EQ(grid.findBrick(77), kNoIndex);
}

TEST(SparseGrid, OneCellInEachCornerOfABrick) {
  for (uint32_t bit = 0; bit < 8; ++bit) {
    const std::set<uint64_t> keys = {
        morton::encode(4 + 3 * (bit & 1), 8 + 3 * (bit >> 1 & 1), 12 + 3 * (bit >> 2))};
    const SparseGrid grid = gridOf(keys);
    expectBricks(grid);
    expectFinds(grid, numbered(keys), bit);
    expectBlocks(grid, numbered(keys));
    expectNear<1>(grid, numbered(keys));
  }
}

TEST(SparseGrid, AgreesWithAMap) {
  // From full bricks to single cells.
  const std::size_t counts[] = {2, 20, 200, 5000};
  for (const std::size_t count : counts) {
    for (const int64_t extent : {7, 24, 90}) {
      const auto keys =
          randomKeys((1 << 19) - extent, (1 << 19) + extent, count, count + std::size_t(extent));
      const SparseGrid grid = gridOf(keys);
      const Numbers numbers = numbered(keys);
      ASSERT_EQ(grid.size(), keys.size());
      expectBricks(grid);
      expectFinds(grid, numbers, count);
      expectBlocks(grid, numbers);
      expectBricksAround(grid);
      expectNear<1>(grid, numbers);
      expectNear<2>(grid, numbers);
    }
  }
}

TEST(SparseGrid, NewCellsReplaceOldOnes) {
  const auto many = randomKeys(100, 160, 5000, 5);
  const auto few = randomKeys(130, 200, 30, 6);
  SparseGrid grid = gridOf(many);
  grid.assign({few.begin(), few.end()});
  expectBricks(grid);
  expectFinds(grid, numbered(few), 7);
  for (const uint64_t key : many) ASSERT_EQ(grid.find(key), lookUp(numbered(few), key));
}

TEST(SparseGrid, DrawnPlane) {
  // One layer z = 4 of a picture over two bricks; '#' are cells.
  const char* rows[] = {"..#..#..", ".##..##.", "........", "########"};
  std::set<uint64_t> keys;
  for (uint32_t y = 0; y < 4; ++y) {
    for (uint32_t x = 0; x < 8; ++x) {
      if (rows[y][x] == '#') keys.insert(morton::encode(x, y, 4));
    }
  }
  const SparseGrid grid = gridOf(keys);
  ASSERT_EQ(grid.bricks().size(), 2u);
  const Block block = blockOf(grid, 0);
  for (int y = 0; y < 4; ++y) {
    std::string row;
    // The fifth column is the other brick's first.
    for (int x = 0; x < 5; ++x) {
      const auto place = static_cast<std::size_t>(SparseGrid::blockIndex(x, y, 0));
      row += block[place] == kNoIndex ? '.' : '#';
    }
    EXPECT_EQ(row, std::string(rows[y]).substr(0, 5)) << y;
  }
}

}  // namespace
}  // namespace ladar_perception
