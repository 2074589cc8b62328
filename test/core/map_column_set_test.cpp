// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "ladar_perception/map/column_set.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::pointIn;
using test::TestRandom;

TEST(ColumnSet, HoldsWhatWasAdded) {
  TestRandom random(1);
  for (const int nx : {1, 63, 64, 65, 130}) {
    constexpr int kRows = 5;
    ColumnSet set;
    set.resize(nx, kRows);
    EXPECT_EQ(set.words(), (nx + 63) / 64);
    EXPECT_EQ(set.size(), 0U);
    std::vector<bool> expected(static_cast<std::size_t>(nx) * kRows, false);
    for (int i = 0; i < nx; ++i) {
      const auto x = static_cast<int>(random.integer(0, nx - 1));
      const auto y = static_cast<int>(random.integer(0, kRows - 1));
      set.add(x, y);
      expected[y * nx + x] = true;
    }
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < nx; ++x) ASSERT_EQ(set.contains(x, y), expected[y * nx + x]);
      EXPECT_EQ(bit_mask::countBelow(set.row(y), nx),
                bit_mask::countBelow(set.row(y), 64 * set.words()))
          << "bits beyond the row";
    }
    const auto size = std::count(expected.begin(), expected.end(), true);
    EXPECT_EQ(set.size(), static_cast<std::size_t>(size));
    set.resize(nx, kRows);
    EXPECT_EQ(set.size(), 0U) << "resizing empties";
  }
}

TEST(ColumnSet, AssignsEveryColumn) {
  for (const int nx : {1, 63, 64, 65, 128, 130}) {
    ColumnSet set;
    set.assignAll(nx, 3);
    EXPECT_EQ(set.size(), 3U * nx);
    for (int x = 0; x < nx; ++x) ASSERT_TRUE(set.contains(x, 2)) << x << " of " << nx;
  }
}

/// A map that was filled, scrolled and filled again, with points beyond its window's borders too.
class ColumnSetOfMap : public testing::TestWithParam<MapShape> {
 protected:
  void insertAround(int count) {
    const VoxelIndex& min = map_.minCorner();
    const MapShape& shape = map_.shape();
    for (int i = 0; i < count; ++i) {
      const auto near = [&](int32_t from, int n) {
        return static_cast<int32_t>(random_.integer(int64_t{from} - 2, int64_t{from} + n + 1));
      };
      const int32_t x = near(min.x, shape.nx);
      const int32_t y = near(min.y, shape.ny);
      CellId cell = 0;
      map_.insert(pointIn({x, y, near(min.z, shape.nz)}), &cell);
    }
  }
  void scrollBy(int dx, int dy, int dz) {
    const VoxelIndex& min = map_.minCorner();
    map_.scrollTo({min.x + dx, min.y + dy, min.z + dz});
  }
  /// Whether a changed column is within the radius, wherever it lies.
  bool isNearChange(int x, int y, int radius) const {
    const VoxelIndex& min = map_.minCorner();
    const auto& changed = map_.changedColumns();
    return std::any_of(changed.begin(), changed.end(), [&](const ColumnIndex& column) {
      return std::abs(column.x - (min.x + x)) <= radius &&
             std::abs(column.y - (min.y + y)) <= radius;
    });
  }
  void expectAffected(int radius) const {
    ColumnSet set;
    set.assignAffected(map_, radius);
    std::size_t size = 0;
    for (int y = 0; y < map_.shape().ny; ++y) {
      for (int x = 0; x < map_.shape().nx; ++x) {
        const bool expected = isNearChange(x, y, radius);
        ASSERT_EQ(set.contains(x, y), expected) << "(" << x << ", " << y << ") r " << radius;
        size += expected ? 1 : 0;
      }
    }
    ASSERT_EQ(set.size(), size);
  }

  TestRandom random_{5};
  VoxelMap map_{GetParam(), 1000};
};

TEST_P(ColumnSetOfMap, AssignsTheNeighboursOfChangedColumns) {
  map_.scrollTo({-7, 1000000, -1});
  for (int step = 0; step < 12; ++step) {
    insertAround(map_.columnCount());
    map_.forgetChanges();
    insertAround(step % 4);
    // Columns leave on one side, so do their neighbours farther on: some lie within the radius.
    if (step % 3 > 0) scrollBy(step % 5 - 2, 2 - step % 4, step % 2);
    insertAround(step % 2);
    for (const int radius : {0, 1, 2, 5, 70}) {
      ASSERT_NO_FATAL_FAILURE(expectAffected(radius)) << "step " << step;
    }
  }
}

TEST_P(ColumnSetOfMap, NothingIsAffectedWithoutAChange) {
  insertAround(map_.columnCount());
  map_.forgetChanges();
  ColumnSet set;
  set.assignAffected(map_, 4);
  EXPECT_EQ(set.size(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Shapes, ColumnSetOfMap,
                         testing::Values(MapShape{9, 12, 4}, MapShape{64, 5, 3}, MapShape{65, 7, 2},
                                         MapShape{150, 3, 2}, MapShape{1, 1, 1}),
                         [](const auto& shape) { return test::shapeName(shape.param); });

/// Occupied columns (x, 3) from x = 0.
VoxelMap rowOfColumns(const MapShape& shape) {
  VoxelMap map(shape, 1000);
  CellId cell = 0;
  for (int x = 0; x < shape.nx; ++x) map.insert(pointIn({x, 3, 0}), &cell);
  map.forgetChanges();
  return map;
}

/// '#' columns of the set, +y up, +x right.
std::string draw(const ColumnSet& set, const MapShape& shape) {
  std::string picture;
  for (int y = shape.ny - 1; y >= 0; --y) {
    for (int x = 0; x < shape.nx; ++x) picture += set.contains(x, y) ? '#' : '.';
    picture += '\n';
  }
  return picture;
}

TEST(ColumnSet, ColumnsThatLeftAffectThoseWithinReachOfThem) {
  const MapShape shape = {6, 6, 1};
  VoxelMap map = rowOfColumns(shape);
  map.scrollTo({2, 0, 0});  // (0, 3) and (1, 3) leave
  ColumnSet set;
  set.assignAffected(map, 2);
  EXPECT_EQ(draw(set, shape),
            "##....\n"
            "##....\n"
            "##....\n"
            "##....\n"
            "##....\n"
            "......\n");
  set.assignAffected(map, 1);
  EXPECT_EQ(draw(set, shape),
            "......\n"
            "#.....\n"
            "#.....\n"
            "#.....\n"
            "......\n"
            "......\n");
  map.scrollTo({0, 0, 0});  // (6, 3) and (7, 3) were empty
  set.assignAffected(map, 0);
  EXPECT_EQ(draw(set, shape),
            "......\n"
            "......\n"
            "##....\n"
            "......\n"
            "......\n"
            "......\n");
}

ColumnSet randomSet(int nx, int ny, int columns, TestRandom* random) {
  ColumnSet set;
  set.resize(nx, ny);
  for (int i = 0; i < columns; ++i) {
    const auto x = static_cast<int>(random->integer(0, nx - 1));
    set.add(x, static_cast<int>(random->integer(0, ny - 1)));
  }
  return set;
}

bool containsNear(const ColumnSet& set, const MapShape& shape, int x, int y, int radius) {
  for (int j = std::max(y - radius, 0); j <= std::min(y + radius, shape.ny - 1); ++j) {
    for (int i = std::max(x - radius, 0); i <= std::min(x + radius, shape.nx - 1); ++i) {
      if (set.contains(i, j)) return true;
    }
  }
  return false;
}

TEST(ColumnSet, DilatesByAnyRadius) {
  TestRandom random(6);
  for (const MapShape& shape : {MapShape{1, 1, 1}, MapShape{63, 20, 1}, MapShape{64, 7, 1},
                                MapShape{65, 1, 1}, MapShape{150, 40, 1}}) {
    for (const int columns : {0, 1, 3, 50}) {
      const ColumnSet set = randomSet(shape.nx, shape.ny, columns, &random);
      for (const int radius : {0, 1, 2, 5, 8, 64, 70}) {
        ColumnSet dilated = randomSet(9, 9, 9, &random);  // what was in it is gone
        dilated.assignDilated(set, radius);
        std::size_t size = 0;
        for (int y = 0; y < shape.ny; ++y) {
          for (int x = 0; x < shape.nx; ++x) {
            const bool expected = containsNear(set, shape, x, y, radius);
            ASSERT_EQ(dilated.contains(x, y), expected) << x << ", " << y << ", r " << radius;
            size += expected ? 1 : 0;
          }
        }
        ASSERT_EQ(dilated.size(), size) << "columns beyond the row";
      }
    }
  }
}

TEST(ColumnSet, AddsAnother) {
  TestRandom random(7);
  const ColumnSet a = randomSet(70, 6, 40, &random);
  const ColumnSet b = randomSet(70, 6, 40, &random);
  ColumnSet both = a;
  both.add(b);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 70; ++x) {
      ASSERT_EQ(both.contains(x, y), a.contains(x, y) || b.contains(x, y));
    }
  }
  EXPECT_GT(both.size(), std::max(a.size(), b.size()));
}

TEST(ColumnSet, ColumnsBeyondTheMarginAffectNothing) {
  VoxelMap map = rowOfColumns({10, 10, 1});
  map.scrollTo({1, 0, 0});  // (0, 3) leaves
  ColumnSet set;
  set.assignAffected(map, 0);
  EXPECT_EQ(set.size(), 0U);
  map.scrollTo({3, 0, 0});  // (1, 3) and (2, 3), too: nearest to x = 3
  map.forgetChanges();
  map.scrollTo({3, 5, 0});  // (3, 3) .. (9, 3), now two below the window
  set.assignAffected(map, 1);
  EXPECT_EQ(set.size(), 0U);
  set.assignAffected(map, 2);
  EXPECT_EQ(set.size(), 9U);  // one row, x = 1 .. 11 within 3 .. 12
}

/// Bits within the radius of a set one, bit by bit.
std::vector<uint64_t> dilatedNaively(const std::vector<uint64_t>& in, int radius) {
  const int size = 64 * static_cast<int>(in.size());
  std::vector<uint64_t> out(in.size(), 0);
  for (int i = 0; i < size; ++i) {
    for (int j = std::max(i - radius, 0); j <= std::min(i + radius, size - 1); ++j) {
      if (bit_mask::test(in.data(), j)) out[i / 64] |= uint64_t{1} << (i % 64);
    }
  }
  return out;
}

TEST(DilateBits, EqualsTheNaiveLoopForAnyRadius) {
  TestRandom random(2);
  for (const int words : {1, 2, 3, 5}) {
    for (const int bits : {0, 1, 2, 10, 64 * words}) {
      for (int radius = 0; radius <= 70; ++radius) {
        std::vector<uint64_t> in(words, 0);
        for (int i = 0; i < bits; ++i) {
          const auto at = static_cast<int>(random.integer(0, 64 * words - 1));
          in[at / 64] |= uint64_t{1} << (at % 64);
        }
        std::vector<uint64_t> out(words, 0xabcdef);
        dilateBits(in.data(), words, radius, out.data());
        ASSERT_EQ(out, dilatedNaively(in, radius)) << words << " words, radius " << radius;
      }
    }
  }
}

TEST(DilateBits, ReachesAcrossWholeWords) {
  for (const int radius : {63, 64, 65, 127, 128, 129, 200, 1000}) {
    std::vector<uint64_t> in = {0, 0, uint64_t{1} << 5, 0, 0};
    std::vector<uint64_t> out(in.size());
    dilateBits(in.data(), 5, radius, out.data());
    ASSERT_EQ(out, dilatedNaively(in, radius)) << radius;
  }
}

}  // namespace
}  // namespace ladar_perception
