// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>
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
      const std::size_t slot = map_.slotOf(cell);
      ASSERT_LT(slot, map_.slotBound());
      ASSERT_EQ(&map_.record(slot), map_.find(voxelOf(q)));
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
    expectSameVisits(records);
    std::size_t in_columns = 0;
    for (int column = 0; column < map_.columnCount(); ++column) {
      in_columns += map_.recordCount(column);
      // No bits beyond the window's top, in words a pass may read whole.
      ASSERT_EQ(bit_mask::countBelow(map_.mask(column), 64 * map_.maskWords()),
                map_.recordCount(column));
    }
    ASSERT_EQ(in_columns, records.size());
  }
  /// The same voxels in the same order, and slots that hold them.
  void expectSameVisits(const std::vector<VoxelRecord>& records) const {
    std::vector<VoxelRecord> visited;
    map_.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
      visited.push_back({voxel, map_.record(slot)});
      const int column = map_.columnAt(voxel.x - min_.x, voxel.y - min_.y);
      EXPECT_GE(slot, map_.firstSlot(column));
      EXPECT_LT(slot, map_.firstSlot(column) + map_.recordCount(column));
    });
    ASSERT_EQ(visited, records);
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
      map.forgetChanges();  // the list of changes grows until someone has read it
    }
    bytes_after_lap.push_back(map.memoryBytes());
  }
  EXPECT_EQ(bytes_after_lap.back(), bytes_after_lap[4]);
  // Records and their spare room, not the 2.4 MB of a dense map.
  EXPECT_LT(bytes_after_lap.back(), std::size_t{1500000});
}

/// What a column held: its voxels' heights, records and slots.
struct HeldVoxel {
  VoxelRecord record;
  std::size_t slot;
};
using Column = std::pair<int32_t, int32_t>;  // world x, y
using HeldColumns = std::map<Column, std::vector<HeldVoxel>>;

HeldColumns holdColumns(const VoxelMap& map) {
  HeldColumns columns;
  map.forEachVoxel([&](const VoxelIndex& v, std::size_t slot) {
    columns[{v.x, v.y}].push_back({{v, map.record(slot)}, slot});
  });
  return columns;
}

bool sameRecords(const std::vector<HeldVoxel>& a, const std::vector<HeldVoxel>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const HeldVoxel& l, const HeldVoxel& r) { return l.record == r.record; });
}

bool sameSlots(const std::vector<HeldVoxel>& a, const std::vector<HeldVoxel>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const HeldVoxel& l, const HeldVoxel& r) { return l.slot == r.slot; });
}

/// Columns that differ, and of the others those of which a slot does.
struct Differences {
  std::set<Column> columns;
  std::set<Column> moved;
};

Differences compare(HeldColumns before, HeldColumns after) {
  std::set<Column> all;
  for (const auto& [column, voxels] : before) all.insert(column);
  for (const auto& [column, voxels] : after) all.insert(column);
  Differences differences;
  for (const Column& column : all) {
    if (!sameRecords(before[column], after[column])) {
      differences.columns.insert(column);
    } else if (!sameSlots(before[column], after[column])) {
      differences.moved.insert(column);
    }
  }
  return differences;
}

/// Steps of a map, with the columns its points went into.
class ChangeDrive {
 public:
  explicit ChangeDrive(const MapShape& shape) : map_(shape, 3), part_(shape, 3) {
    scrollBy(-2, 7, -1);
  }

  TestRandom& random() { return random_; }
  const VoxelMap& map() const { return map_; }

  /// Few voxels, so that some of them saturate; half of the points go into the part, too.
  void insert(int64_t count) {
    const VoxelIndex& min = map_.minCorner();
    for (int64_t i = 0; i < count; ++i) {
      const auto x = static_cast<int32_t>(min.x + random_.integer(-1, map_.shape().nx));
      const auto y = static_cast<int32_t>(min.y + random_.integer(-1, map_.shape().ny));
      const auto z = static_cast<int32_t>(min.z + random_.integer(0, map_.shape().nz - 1));
      CellId cell = 0;
      if (map_.insert(pointIn({x, y, z}), &cell) != InsertResult::kInserted) continue;
      touched_.insert({x, y});
      if (random_.integer(0, 1) == 0) part_.insert(pointIn({x, y, z}), &cell);
    }
  }
  void subtractPart() {
    map_.subtract(part_);
    part_.clear();
  }
  void scrollBy(int64_t dx, int64_t dy, int64_t dz) {
    const VoxelIndex& min = map_.minCorner();
    const VoxelIndex to = {static_cast<int32_t>(min.x + dx), static_cast<int32_t>(min.y + dy),
                           static_cast<int32_t>(min.z + dz)};
    map_.scrollTo(to);
    part_.scrollTo(to);
  }
  void forgetChanges() {
    map_.forgetChanges();
    touched_.clear();
    before_ = holdColumns(map_);
  }
  /// Every column that differs is listed; others are not, but those with points that came and went.
  void expectChangesListed() const {
    std::set<Column> listed;
    for (const ColumnIndex& column : map_.changedColumns()) listed.insert({column.x, column.y});
    const Differences differences = compare(before_, holdColumns(map_));
    for (const Column& column : differences.columns) {
      ASSERT_EQ(listed.count(column), 1U) << "not listed: " << testing::PrintToString(column);
    }
    for (const Column& column : differences.moved) {
      ASSERT_EQ(listed.count(column), 1U) << "moved: " << testing::PrintToString(column);
    }
    for (const Column& column : listed) {
      ASSERT_EQ(differences.columns.count(column) + touched_.count(column) > 0, true)
          << "listed for nothing: " << testing::PrintToString(column);
    }
  }

 private:
  TestRandom random_{17};
  VoxelMap map_;
  VoxelMap part_;
  std::set<Column> touched_;
  HeldColumns before_;
};

TEST(VoxelMapChanges, ListTheColumnsThatDiffer) {
  for (const MapShape& shape : {MapShape{9, 7, 5}, MapShape{5, 6, 70}, MapShape{1, 1, 2}}) {
    ChangeDrive drive(shape);
    TestRandom& random = drive.random();
    for (int round = 0; round < 200; ++round) {
      drive.insert(random.integer(0, 60));
      drive.forgetChanges();
      ASSERT_TRUE(drive.map().changedColumns().empty());
      for (int64_t step = random.integer(0, 4); step > 0; --step) {
        const int64_t kind = random.integer(0, 3);
        if (kind == 0) drive.insert(random.integer(0, 10));
        if (kind == 1) drive.subtractPart();
        // Less than the window's size: a jump forgets the changes with the rest.
        if (kind >= 2) {
          const int64_t dx = random.integer(-1, 1) * (shape.nx > 2 ? 1 : 0);
          const int64_t dy = random.integer(-2, 2) * (shape.ny > 2 ? 1 : 0);
          drive.scrollBy(dx, dy, random.integer(-1, 1));
        }
        ASSERT_NO_FATAL_FAILURE(drive.expectChangesListed()) << "round " << round;
      }
    }
  }
}

TEST(VoxelMapChanges, OfAJumpAreThoseSinceIt) {
  VoxelMap map({4, 4, 4}, kManyPoints);
  CellId cell = 0;
  map.insert(pointIn({1, 1, 1}), &cell);
  map.scrollTo({100, 0, 0});
  EXPECT_TRUE(map.changedColumns().empty());
  map.insert(pointIn({101, 1, 1}), &cell);
  ASSERT_EQ(map.changedColumns().size(), 1U);
  EXPECT_EQ(map.changedColumns()[0].x, 101);
  map.clear();
  EXPECT_TRUE(map.changedColumns().empty());
}

TEST(VoxelMapChanges, RefusedPointsAreNone) {
  VoxelMap map({4, 4, 4}, 1);
  CellId cell = 0;
  map.insert(pointIn({1, 1, 1}), &cell);
  map.forgetChanges();
  EXPECT_EQ(map.insert(pointIn({1, 1, 1}), &cell), InsertResult::kSaturated);
  EXPECT_EQ(map.insert(pointIn({4, 1, 1}), &cell), InsertResult::kOutside);
  EXPECT_TRUE(map.changedColumns().empty());
}

class VoxelMapSubtract : public testing::TestWithParam<MapShape> {
 protected:
  FixedPoint randomPoint(const VoxelIndex& min) {
    const auto coordinate = [&](int32_t from, int n) {
      return random_.integer(int64_t{from} * kStepsPerVoxel,
                             (int64_t{from} + n) * kStepsPerVoxel - 1);
    };
    const int64_t x = coordinate(min.x, GetParam().nx);
    const int64_t y = coordinate(min.y, GetParam().ny);
    return {x, y, coordinate(min.z, GetParam().nz)};
  }

  TestRandom random_{21};
};

TEST_P(VoxelMapSubtract, LeavesAMapThatNeverSawThePoints) {
  const VoxelIndex min = {-3, 1000000, -5};
  for (const int count : {0, 1, 30, 2000}) {
    VoxelMap map(GetParam(), kManyPoints * 100);
    VoxelMap part = map;
    VoxelMap rest = map;
    for (VoxelMap* each : {&map, &part, &rest}) each->scrollTo(min);
    CellId cell = 0;
    for (int i = 0; i < count; ++i) {
      const FixedPoint q = randomPoint(min);
      map.insert(q, &cell);
      (random_.integer(0, 2) == 0 ? rest : part).insert(q, &cell);
    }
    map.subtract(part);
    ASSERT_EQ(listRecords(map), listRecords(rest)) << count;
    ASSERT_EQ(map.occupied(), rest.occupied());
    map.subtract(rest);
    ASSERT_EQ(map.occupied(), 0U);
    ASSERT_TRUE(listRecords(map).empty());
  }
}

TEST_P(VoxelMapSubtract, WorksAfterScrollsAndBeforeNewPoints) {
  VoxelMap map(GetParam(), kManyPoints * 100);
  VoxelMap part = map;
  VoxelMap rest = map;
  CellId cell = 0;
  VoxelIndex min = {0, 0, 0};
  for (int step = 0; step < 30; ++step) {
    for (int i = 0; i < 50; ++i) {
      const FixedPoint q = randomPoint(min);
      map.insert(q, &cell);
      (random_.integer(0, 1) == 0 ? rest : part).insert(q, &cell);
    }
    min = {min.x + step % 3 - 1, min.y + 1, min.z + (step % 5 == 0 ? 1 : 0)};
    for (VoxelMap* each : {&map, &part, &rest}) each->scrollTo(min);
    if (step % 4 < 3) continue;
    map.subtract(part);
    part.clear();
    ASSERT_EQ(listRecords(map), listRecords(rest)) << step;
    ASSERT_EQ(map.occupied(), rest.occupied()) << step;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, VoxelMapSubtract,
                         testing::Values(MapShape{7, 5, 3}, MapShape{4, 3, 64}, MapShape{4, 3, 65},
                                         MapShape{2, 2, 130}, MapShape{1, 1, 1}),
                         [](const auto& shape) { return test::shapeName(shape.param); });

TEST(VoxelMap, DrawnPicturesBeforeAndAfterASubtraction) {
  VoxelMap map({5, 3, 2}, kManyPoints);
  VoxelMap part = map;
  CellId cell = 0;
  for (const VoxelIndex& v : {VoxelIndex{0, 0, 1}, VoxelIndex{1, 1, 1}, VoxelIndex{2, 1, 1},
                              VoxelIndex{2, 1, 1}, VoxelIndex{4, 2, 1}}) {
    map.insert(pointIn(v), &cell);
  }
  EXPECT_EQ(drawLayer(map, 1),
            "....#\n"
            ".##..\n"
            "#....\n");
  for (const VoxelIndex& v : {VoxelIndex{1, 1, 1}, VoxelIndex{2, 1, 1}, VoxelIndex{4, 2, 1}}) {
    part.insert(pointIn(v), &cell);
  }
  map.subtract(part);
  EXPECT_EQ(drawLayer(map, 1),
            ".....\n"
            "..#..\n"  // one of its two points is left
            "#....\n");
  EXPECT_EQ(map.find({2, 1, 1})->count(), 1U);
}

}  // namespace
}  // namespace ladar_perception
