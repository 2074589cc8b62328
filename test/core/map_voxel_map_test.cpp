// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "ladar_perception/map/voxel_map.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::drawLayer;
using test::listRecords;
using test::MapOracle;
using test::pointIn;
using test::TestRandom;
using test::VoxelRecord;
using InsertResult = VoxelMap::InsertResult;

constexpr uint32_t kManyPoints = 1000;

/// A map and the oracle, driven by the same steps.
class Drive {
 public:
  Drive(const MapShape& shape, uint32_t max_points, uint64_t seed, const VoxelIndex& start)
      : random_(seed), map_(shape, max_points), oracle_(shape, max_points), min_(start) {
    moveTo(start);
  }

  const VoxelMap& map() const { return map_; }
  const VoxelIndex& min() const { return min_; }
  TestRandom& random() { return random_; }

  void moveTo(const VoxelIndex& min_corner) {
    min_ = min_corner;
    map_.scrollTo(min_);
    oracle_.scrollTo(min_);
  }
  void moveBy(int64_t dx, int64_t dy, int64_t dz) {
    moveTo({static_cast<int32_t>(min_.x + dx), static_cast<int32_t>(min_.y + dy),
            static_cast<int32_t>(min_.z + dz)});
  }
  /// Points all over the window and one voxel beyond it.
  void insertAround(int count) {
    const MapShape& shape = map_.shape();
    for (int i = 0; i < count; ++i) {
      const auto coordinate = [&](int32_t min, int n) {
        return random_.integer((min - int64_t{1}) * kStepsPerVoxel,
                               (min + int64_t{n} + 1) * kStepsPerVoxel - 1);
      };
      const int64_t x = coordinate(min_.x, shape.nx);
      const int64_t y = coordinate(min_.y, shape.ny);
      insert({x, y, coordinate(min_.z, shape.nz)});
    }
  }
  void insert(const FixedPoint& q) {
    CellId cell = 12345;
    const InsertResult result = map_.insert(q, &cell);
    ASSERT_EQ(result, oracle_.insert(q));
    if (result == InsertResult::kOutside) {
      ASSERT_EQ(cell, kNoCell);
    } else {
      const Moments* record = map_.records(map_.columnOf(cell)) + map_.rankOf(cell);
      ASSERT_EQ(record, map_.find(voxelOf(q)));
    }
  }
  void clear() {
    map_.clear();
    oracle_.clear();
  }
  /// Every record bit by bit, in order; the counts; and no record anywhere else.
  void expectSame() const {
    ASSERT_EQ(map_.minCorner(), min_);
    const std::vector<VoxelRecord> records = listRecords(map_);
    ASSERT_EQ(records, oracle_.list());
    ASSERT_EQ(map_.occupied(), records.size());
    std::size_t in_columns = 0;
    for (int column = 0; column < map_.columnCount(); ++column) {
      in_columns += map_.recordCount(column);
      // No bits beyond the window's top, in words a pass may read whole.
      ASSERT_EQ(bit_mask::countBelow(map_.mask(column), 64 * map_.maskWords()),
                map_.recordCount(column));
    }
    ASSERT_EQ(in_columns, records.size());
  }
  void expectSameLookUps() {
    const MapShape& shape = map_.shape();
    for (int i = 0; i < 200; ++i) {
      const VoxelIndex voxel = {
          static_cast<int32_t>(random_.integer(min_.x - 2, min_.x + int64_t{shape.nx} + 2)),
          static_cast<int32_t>(random_.integer(min_.y - 2, min_.y + int64_t{shape.ny} + 2)),
          static_cast<int32_t>(random_.integer(min_.z - 2, min_.z + int64_t{shape.nz} + 2))};
      const Moments* found = map_.find(voxel);
      const Moments* expected = oracle_.find(voxel);
      ASSERT_EQ(found == nullptr, expected == nullptr);
      if (found != nullptr) {
        ASSERT_EQ(*found, *expected);
      }
    }
  }

 private:
  TestRandom random_;
  VoxelMap map_;
  MapOracle oracle_;
  VoxelIndex min_;
};

class VoxelMapDrive : public testing::TestWithParam<MapShape> {
 protected:
  static int64_t stepUpTo(TestRandom* random, int n) { return random->integer(-n, n); }

  /// Steps of a voxel or two, now and then half a map, a whole one, or far away.
  static void scrollSomewhere(Drive* drive) {
    const MapShape& shape = drive->map().shape();
    TestRandom& random = drive->random();
    const int64_t kind = random.integer(0, 19);
    if (kind < 14) {
      const int64_t dx = stepUpTo(&random, 2);
      const int64_t dy = stepUpTo(&random, 2);
      drive->moveBy(dx, dy, stepUpTo(&random, 1));
    } else if (kind < 18) {
      const int64_t dx = stepUpTo(&random, shape.nx);
      const int64_t dy = stepUpTo(&random, shape.ny);
      drive->moveBy(dx, dy, stepUpTo(&random, shape.nz));
    } else if (kind == 18) {
      const int axis = static_cast<int>(random.integer(0, 2));
      const int64_t n = axis == 0 ? shape.nx : axis == 1 ? shape.ny : shape.nz;
      const int64_t jump = random.integer(0, 1) == 0 ? n : -n - 1;
      drive->moveBy(axis == 0 ? jump : 0, axis == 1 ? jump : 0, axis == 2 ? jump : 0);
    } else {
      const int64_t dx = stepUpTo(&random, 1000000);
      const int64_t dy = stepUpTo(&random, 1000000);
      drive->moveBy(dx, dy, stepUpTo(&random, 1000));
    }
  }
};

TEST_P(VoxelMapDrive, EqualsADictionaryThroughAnySequence) {
  for (const VoxelIndex& start :
       {VoxelIndex{0, 0, 0}, VoxelIndex{-3, -3, -1}, VoxelIndex{10000000, -10000000, -40}}) {
    Drive drive(GetParam(), kManyPoints, 1, start);
    for (int step = 0; step < 150; ++step) {
      drive.insertAround(static_cast<int>(drive.random().integer(0, 400)));
      if (HasFatalFailure()) return;
      ASSERT_NO_FATAL_FAILURE(drive.expectSame()) << "after inserting, step " << step;
      scrollSomewhere(&drive);
      if (step % 50 == 49) drive.clear();
      ASSERT_NO_FATAL_FAILURE(drive.expectSame()) << "after scrolling, step " << step;
      ASSERT_NO_FATAL_FAILURE(drive.expectSameLookUps()) << "step " << step;
    }
  }
}

TEST_P(VoxelMapDrive, ScrollingThereAndBackKeepsTheOverlapBitByBit) {
  const MapShape shape = GetParam();
  for (int axis = 0; axis < 3; ++axis) {
    const int n = axis == 0 ? shape.nx : axis == 1 ? shape.ny : shape.nz;
    for (int step = -n; step <= n; step += std::max(1, n / 7)) {
      Drive drive(shape, kManyPoints, 2, {-2, 5, -1});
      drive.insertAround(1000);
      std::vector<VoxelRecord> expected = listRecords(drive.map());
      expected.erase(std::remove_if(expected.begin(), expected.end(),
                                    [&](const VoxelRecord& record) {
                                      const VoxelIndex& v = record.voxel;
                                      const VoxelIndex& min = drive.min();
                                      const int local = axis == 0   ? v.x - min.x
                                                        : axis == 1 ? v.y - min.y
                                                                    : v.z - min.z;
                                      return local < step || local >= n + step;
                                    }),
                     expected.end());
      const auto move = [&](int d) {
        drive.moveBy(axis == 0 ? d : 0, axis == 1 ? d : 0, axis == 2 ? d : 0);
      };
      move(step);
      move(-step);
      ASSERT_EQ(listRecords(drive.map()), expected) << "axis " << axis << " step " << step;
    }
  }
}

TEST_P(VoxelMapDrive, AnyOrderOfInsertionGivesTheSameBits) {
  TestRandom random(3);
  const MapShape shape = GetParam();
  std::vector<FixedPoint> points;
  for (int i = 0; i < 3000; ++i) {
    const int64_t x = random.integer(0, shape.nx * kStepsPerVoxel - 1);
    const int64_t y = random.integer(0, shape.ny * kStepsPerVoxel - 1);
    points.push_back({x, y, random.integer(0, shape.nz * kStepsPerVoxel - 1)});
  }
  const auto recordsOf = [&] {
    VoxelMap map(shape, 1000000);
    CellId cell = 0;
    for (const FixedPoint& q : points) map.insert(q, &cell);
    return listRecords(map);
  };
  const auto forward = recordsOf();
  std::reverse(points.begin(), points.end());
  EXPECT_EQ(recordsOf(), forward);
  std::shuffle(points.begin(), points.end(), random.engine());
  EXPECT_EQ(recordsOf(), forward);
}

INSTANTIATE_TEST_SUITE_P(Shapes, VoxelMapDrive,
                         testing::Values(MapShape{7, 5, 3}, MapShape{20, 20, 64},
                                         MapShape{8, 8, 65}, MapShape{8, 8, 130}, MapShape{1, 1, 1},
                                         MapShape{1, 9, 63}, MapShape{13, 2, 128}),
                         [](const auto& shape) { return test::shapeName(shape.param); });

TEST(VoxelMap, DrawnPicturesBeforeAndAfterAScroll) {
  VoxelMap map({6, 4, 3}, kManyPoints);
  map.scrollTo({-2, -1, 0});
  CellId cell = 0;
  for (const VoxelIndex& v : {VoxelIndex{-2, -1, 1}, VoxelIndex{-1, 0, 1}, VoxelIndex{0, 1, 1},
                              VoxelIndex{1, 2, 1}, VoxelIndex{3, 2, 1}, VoxelIndex{3, -1, 1}}) {
    ASSERT_EQ(map.insert(pointIn(v), &cell), InsertResult::kInserted);
  }
  EXPECT_EQ(drawLayer(map, 1),
            "...#.#\n"
            "..#...\n"
            ".#....\n"
            "#....#\n");
  map.scrollTo({0, 0, 0});  // two right, one up
  EXPECT_EQ(drawLayer(map, 1),
            "......\n"
            ".#.#..\n"
            "#.....\n"
            "......\n");
  EXPECT_EQ(map.occupied(), 3U);
  map.scrollTo({-1, 1, 1});  // one left, one up, one higher
  EXPECT_EQ(drawLayer(map, 1),
            "......\n"
            "......\n"
            "..#.#.\n"
            ".#....\n");
  map.scrollTo({-1, 1, 2});  // the layer leaves through the floor
  EXPECT_EQ(map.occupied(), 0U);
}

TEST(VoxelMap, TakesNoMorePointsThanItsCap) {
  VoxelMap map({2, 2, 2}, 3);
  CellId cell = kNoCell;
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(map.insert(pointIn({1, 0, 1}, i), &cell), InsertResult::kInserted);
  }
  const Moments full = *map.find({1, 0, 1});
  const CellId full_cell = cell;
  cell = kNoCell;
  EXPECT_EQ(map.insert(pointIn({1, 0, 1}, 77), &cell), InsertResult::kSaturated);
  EXPECT_EQ(cell, full_cell);
  EXPECT_EQ(*map.find({1, 0, 1}), full);
  EXPECT_EQ(map.insert(pointIn({1, 1, 1}), &cell), InsertResult::kInserted);
  EXPECT_NE(cell, full_cell);
}

TEST(VoxelMap, PositionsFarOutsideDoNotWrapIntoTheWindow) {
  VoxelMap map({8, 8, 8}, kManyPoints);
  CellId cell = 0;
  const int64_t round = (int64_t{1} << 32) * kStepsPerVoxel;  // voxel index 0 modulo 2^32
  for (const FixedPoint& q :
       {FixedPoint{round, 0, 0}, FixedPoint{0, -round, 0}, FixedPoint{0, 0, round + 256},
        FixedPoint{-1, 0, 0}, FixedPoint{0, 8 * kStepsPerVoxel, 0}}) {
    EXPECT_EQ(map.insert(q, &cell), InsertResult::kOutside);
    EXPECT_EQ(cell, kNoCell);
  }
  EXPECT_EQ(map.occupied(), 0U);
  EXPECT_EQ(map.find({8, 0, 0}), nullptr);
  EXPECT_EQ(map.find({INT32_MIN, INT32_MAX, 0}), nullptr);
}

TEST(VoxelMap, JumpsAcrossTheWholeRangeOfIndices) {
  VoxelMap map({8, 8, 8}, kManyPoints);
  CellId cell = 0;
  for (const VoxelIndex& min : {VoxelIndex{1000000000, -1000000000, 1000000000},
                                VoxelIndex{-1000000000, 1000000000, -1000000000}}) {
    map.scrollTo(min);
    EXPECT_EQ(map.occupied(), 0U);
    EXPECT_EQ(map.insert(pointIn(min), &cell), InsertResult::kInserted);
    EXPECT_NE(map.find(min), nullptr);
  }
}

TEST(VoxelMap, ClearForgetsThePointsAndKeepsTheWindow) {
  VoxelMap map({4, 4, 4}, kManyPoints);
  map.scrollTo({-9, 3, 1});
  CellId cell = 0;
  map.insert(pointIn({-8, 4, 2}), &cell);
  map.clear();
  EXPECT_EQ(map.occupied(), 0U);
  EXPECT_EQ(map.minCorner(), (VoxelIndex{-9, 3, 1}));
  EXPECT_EQ(map.find({-8, 4, 2}), nullptr);
  EXPECT_TRUE(listRecords(map).empty());
}

/// Rolling ground and a few columns of leaves, the same on every lap.
void scanGround(VoxelMap* map, int x_voxel) {
  TestRandom random(static_cast<uint64_t>(x_voxel) + 99);
  CellId cell = 0;
  for (int i = 0; i < 400; ++i) {
    const auto x = static_cast<int32_t>(x_voxel + random.integer(-20, 20));
    const auto y = static_cast<int32_t>(random.integer(-20, 20));
    const int32_t ground = (x * 7 + y * 3) / 40 % 3;
    const bool leaf = (x * 31 + y * 17) % 11 == 0;
    const auto z = static_cast<int32_t>(leaf ? random.integer(0, 20) : ground);
    map->insert(pointIn({x, y, z}), &cell);
  }
}

TEST(VoxelMap, MemoryIsFlatOverALongDrive) {
  VoxelMap map({40, 40, 24}, kManyPoints);
  constexpr int kLap = 500;
  std::vector<std::size_t> bytes_after_lap;
  for (int lap = 0; lap < 40; ++lap) {
    for (int i = 0; i < kLap; ++i) {
      const int x = i < kLap / 2 ? i : kLap - i;
      map.scrollTo({x - 20, -20 + i % 3, -2 + i % 2});
      scanGround(&map, x);
    }
    bytes_after_lap.push_back(map.memoryBytes());
  }
  EXPECT_EQ(bytes_after_lap.back(), bytes_after_lap[4]);
  // Records and their spare room, not the 2.4 MB of a dense map.
  EXPECT_LT(bytes_after_lap.back(), std::size_t{1500000});
}

}  // namespace
}  // namespace ladar_perception
