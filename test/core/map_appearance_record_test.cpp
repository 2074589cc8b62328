// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "ladar_perception/map/appearance_record.h"
#include "ladar_perception/map/column_set.h"
#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/saliency/box_stack.h"
#include "ladar_perception/saliency/box_sums.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::pointIn;
using test::TestRandom;
using AppearanceMap = BasicVoxelMap<AppearanceRecord>;

constexpr uint32_t kManyPoints = 100000;

struct SeenPoint {
  FixedPoint q;
  Appearance appearance;
};

/// Sums over points by hand: of the moments, about `center`, and of the appearance.
struct ExpectedSums {
  void add(const SeenPoint& point, const FixedPoint& center) {
    const int64_t x = point.q.x - center.x;
    const int64_t y = point.q.y - center.y;
    const int64_t z = point.q.z - center.z;
    const int64_t more[10] = {1, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z};
    for (int i = 0; i < 10; ++i) moments[i] += more[i];
    const Appearance& a = point.appearance;
    const uint64_t seen[6] = {
        a.intensity, uint64_t{a.intensity} * a.intensity, a.red, a.green, a.blue, a.returns};
    for (int i = 0; i < 6; ++i) appearance[i] += seen[i];
  }
  std::array<int64_t, 10> moments{};
  std::array<uint64_t, 6> appearance{};
};

void expectSums(const AppearanceRecord& found, const ExpectedSums& expected,
                const FixedPoint& center) {
  const CenteredMoments m = found.moments().about(center);
  const std::array<int64_t, 10> moments = {m.n, m.x, m.y, m.z, m.xx, m.xy, m.xz, m.yy, m.yz, m.zz};
  ASSERT_EQ(moments, expected.moments);
  const AppearanceSums& s = found.sums();
  const std::array<uint64_t, 6> appearance = {
      s.intensity, s.intensity_squared, s.red, s.green, s.blue, s.returns};
  ASSERT_EQ(appearance, expected.appearance);
  ASSERT_EQ(found.count(), expected.moments[0]);
}

/// A map of appearances and the list of the points that are in it.
class Drive {
 public:
  explicit Drive(const MapShape& shape) : map_(shape, kManyPoints), part_(shape, kManyPoints) {
    scrollTo({-5, 1000000, -3});
  }

  TestRandom& random() { return random_; }
  const AppearanceMap& map() const { return map_; }

  void scrollTo(const VoxelIndex& min) {
    map_.scrollTo(min);
    part_.scrollTo(min);
    const auto outside = [&](const auto& point) { return !isInside(voxelOf(point.first.q)); };
    points_.erase(std::remove_if(points_.begin(), points_.end(), outside), points_.end());
  }
  void scrollBy(int64_t dx, int64_t dy, int64_t dz) {
    const VoxelIndex& min = map_.minCorner();
    scrollTo({static_cast<int32_t>(min.x + dx), static_cast<int32_t>(min.y + dy),
              static_cast<int32_t>(min.z + dz)});
  }
  /// Some of the points go into the part that can be taken out again.
  void insertAround(int count) {
    for (int i = 0; i < count; ++i) {
      const SeenPoint point = somePoint();
      CellId cell = 0;
      const InsertResult result = map_.insert(point.q, &cell, point.appearance);
      ASSERT_EQ(result == InsertResult::kInserted, isInside(voxelOf(point.q)));
      if (result != InsertResult::kInserted) continue;
      const bool in_part = random_.integer(0, 2) == 0;
      if (in_part) part_.insert(point.q, &cell, point.appearance);
      points_.push_back({point, in_part});
    }
  }
  void subtractPart() {
    map_.subtract(part_);
    part_.clear();
    const auto in_part = [](const auto& point) { return point.second; };
    points_.erase(std::remove_if(points_.begin(), points_.end(), in_part), points_.end());
  }
  /// Every record is the sum of its points, and there are no others.
  void expectRecords() const {
    std::map<std::tuple<int, int, int>, ExpectedSums> expected;
    for (const auto& [point, in_part] : points_) {
      const VoxelIndex voxel = voxelOf(point.q);
      expected[{voxel.x, voxel.y, voxel.z}].add(point, centerOf(voxel));
    }
    ASSERT_EQ(map_.occupied(), expected.size());
    std::size_t visited = 0;
    map_.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
      ++visited;
      const auto it = expected.find({voxel.x, voxel.y, voxel.z});
      ASSERT_NE(it, expected.end()) << testing::PrintToString(voxel);
      ASSERT_EQ(map_.find(voxel), &map_.record(slot));
      expectSums(map_.record(slot), it->second, centerOf(voxel));
    });
    ASSERT_EQ(visited, expected.size());
  }
  ExpectedSums sumAround(const VoxelIndex& center, const SupportBox& box) const {
    ExpectedSums sums;
    for (const auto& [point, in_part] : points_) {
      const VoxelIndex voxel = voxelOf(point.q);
      const bool inside = std::abs(voxel.x - center.x) <= box.radius_xy &&
                          std::abs(voxel.y - center.y) <= box.radius_xy &&
                          std::abs(voxel.z - center.z) <= box.radius_z;
      if (inside) sums.add(point, centerOf(center));
    }
    return sums;
  }

 private:
  SeenPoint somePoint() {
    const auto coordinate = [&](int32_t from, int n) {
      return random_.integer((from - int64_t{1}) * kStepsPerVoxel,
                             (from + int64_t{n} + 1) * kStepsPerVoxel - 1);
    };
    const auto byte = [&] { return static_cast<uint8_t>(random_.integer(0, 255)); };
    SeenPoint point;
    point.q.x = coordinate(map_.minCorner().x, map_.shape().nx);
    point.q.y = coordinate(map_.minCorner().y, map_.shape().ny);
    point.q.z = coordinate(map_.minCorner().z, map_.shape().nz);
    point.appearance.intensity = static_cast<uint16_t>(random_.integer(0, 65535));
    point.appearance.red = byte();
    point.appearance.green = byte();
    point.appearance.blue = byte();
    point.appearance.returns = static_cast<uint8_t>(random_.integer(1, 5));
    return point;
  }
  bool isInside(const VoxelIndex& v) const {
    const VoxelIndex& min = map_.minCorner();
    const MapShape& shape = map_.shape();
    return v.x >= min.x && v.x < min.x + shape.nx && v.y >= min.y && v.y < min.y + shape.ny &&
           v.z >= min.z && v.z < min.z + shape.nz;
  }

  TestRandom random_{51};
  AppearanceMap map_;
  AppearanceMap part_;
  std::vector<std::pair<SeenPoint, bool>> points_;  // with whether it is in the part
};

class AppearanceMaps : public testing::TestWithParam<MapShape> {};

TEST_P(AppearanceMaps, HoldTheSumsOfTheirPointsWhateverHappens) {
  Drive drive(GetParam());
  for (int step = 0; step < 150; ++step) {
    drive.insertAround(60);
    ASSERT_NO_FATAL_FAILURE(drive.expectRecords()) << "inserted, step " << step;
    if (step % 7 == 6) drive.subtractPart();
    ASSERT_NO_FATAL_FAILURE(drive.expectRecords()) << "subtracted, step " << step;
    const int64_t dx = drive.random().integer(-2, 2);
    const int64_t dy = drive.random().integer(-1, 1);
    drive.scrollBy(dx, dy, drive.random().integer(0, 5) == 0 ? 1 : 0);
    if (step == 100) drive.scrollBy(1000, 0, 0);
    ASSERT_NO_FATAL_FAILURE(drive.expectRecords()) << "scrolled, step " << step;
  }
}

template <typename Sum>
struct SumTable {
  std::vector<Sum> sums;
  Sum& place(std::size_t slot, int /*x*/, int /*y*/, int /*z*/) { return sums[slot]; }
};

ColumnSet allColumns(const AppearanceMap& map) {
  ColumnSet columns;
  columns.assignAll(map.shape().nx, map.shape().ny);
  return columns;
}

/// A sum that takes of the records what it needs, and is a quarter of their size.
struct IntensitySum {
  IntensitySum& operator+=(const AppearanceRecord& record) {
    return points += record.count(), intensity += record.sums().intensity, *this;
  }
  IntensitySum& operator-=(const AppearanceRecord& record) {
    return points -= record.count(), intensity -= record.sums().intensity, *this;
  }
  IntensitySum& operator+=(const IntensitySum& other) {
    return points += other.points, intensity += other.intensity, *this;
  }
  IntensitySum& operator-=(const IntensitySum& other) {
    return points -= other.points, intensity -= other.intensity, *this;
  }
  uint32_t count() const { return points; }

  uint32_t points = 0;
  uint64_t intensity = 0;
};

TEST_P(AppearanceMaps, HaveBoxSumsThatAreThoseOfThePoints) {
  Drive drive(GetParam());
  const VoxelIndex moves[] = {{0, 0, 0}, {2, -1, 1}, {-1, 1, -2}};
  for (const SupportBox& box : {cube(1), cube(3), SupportBox{2, 5}}) {
    SlidingBoxSums<AppearanceRecord> box_sums(box);
    SlidingBoxSums<IntensitySum> intensity_sums(box);
    for (const VoxelIndex& move : moves) {
      drive.insertAround(150);
      drive.scrollBy(move.x, move.y, move.z);
      drive.insertAround(150);
      const AppearanceMap& map = drive.map();
      ASSERT_GT(map.occupied(), 0U);
      const ColumnSet columns = allColumns(map);
      SumTable<AppearanceRecord> table{std::vector<AppearanceRecord>(map.slotBound())};
      SumTable<IntensitySum> intensities{std::vector<IntensitySum>(map.slotBound())};
      box_sums.compute(map, columns, 0, map.shape().ny, table);
      intensity_sums.compute(map, columns, 0, map.shape().ny, intensities);
      map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
        const ExpectedSums expected = drive.sumAround(voxel, box);
        const AppearanceRecord& sum = table.sums[slot];
        ASSERT_NO_FATAL_FAILURE(expectSums(sum, expected, centerOf(voxel)));
        const double mean =
            static_cast<double>(expected.appearance[0]) / static_cast<double>(expected.moments[0]);
        ASSERT_EQ(sum.meanIntensity(), mean);
        ASSERT_EQ(intensities.sums[slot].intensity, expected.appearance[0]);
        ASSERT_EQ(intensities.sums[slot].points, expected.moments[0]);
      });
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, AppearanceMaps,
                         testing::Values(MapShape{9, 7, 6}, MapShape{5, 4, 70}, MapShape{70, 2, 2},
                                         MapShape{2, 2, 130}),
                         [](const auto& shape) { return test::shapeName(shape.param); });

/// Keeps the weighted sums, by slot.
struct WeightedTable {
  const BoxStack* stack;
  std::vector<AppearanceRecord> sums;
  void accept(std::size_t slot, int /*x*/, int /*y*/, int /*z*/, const AppearanceRecord* of_boxes) {
    sums[slot] = weightedSum(*stack, of_boxes);
  }
};

TEST(AppearanceRecord, CanBeWeightedByDistance) {
  Drive drive({9, 8, 7});
  drive.insertAround(400);
  const AppearanceMap& map = drive.map();
  const BoxStack stack = gaussianBoxStack(3);
  std::vector<SupportBox> boxes;
  for (const WeightedBox& weighted : stack) boxes.push_back(weighted.box);
  BoxStackSums<AppearanceRecord> stack_sums(boxes);
  WeightedTable table{&stack, std::vector<AppearanceRecord>(map.slotBound())};
  stack_sums.compute(map, allColumns(map), 0, map.shape().ny, table);
  map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
    uint64_t intensity = 0;
    for (const WeightedBox& weighted : stack) {
      intensity += weighted.weight * drive.sumAround(voxel, weighted.box).appearance[0];
    }
    ASSERT_EQ(table.sums[slot].sums().intensity, intensity);
  });
}

TEST(AppearanceRecord, TellsAWhiteStripeOnTheRoadFromTheRoad) {
  AppearanceMap map({20, 9, 3}, kManyPoints);
  Appearance road;
  road.intensity = 40;
  Appearance stripe;
  stripe.intensity = 240;
  CellId cell = 0;
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 9; ++y) {
      for (int i = 0; i < 3; ++i)
        map.insert(pointIn({x, y, 1}, 60 * i), &cell, y == 4 ? stripe : road);
    }
  }
  SlidingBoxSums<AppearanceRecord> box_sums(cube(1));
  SumTable<AppearanceRecord> table{std::vector<AppearanceRecord>(map.slotBound())};
  box_sums.compute(map, allColumns(map), 0, 9, table);
  map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
    const bool near_stripe = voxel.y >= 3 && voxel.y <= 5;
    EXPECT_DOUBLE_EQ(table.sums[slot].meanIntensity(), near_stripe ? (240 + 2 * 40) / 3.0 : 40.0)
        << testing::PrintToString(voxel);
  });
}

TEST(AppearanceRecord, RefusedPointsLeaveNoTrace) {
  AppearanceMap map({2, 2, 2}, 2);
  Appearance grey;
  grey.intensity = 7;
  CellId cell = 0;
  for (int i = 0; i < 2; ++i) map.insert(pointIn({1, 1, 1}), &cell, grey);
  const AppearanceRecord full = *map.find({1, 1, 1});
  EXPECT_EQ(map.insert(pointIn({1, 1, 1}), &cell, grey), InsertResult::kSaturated);
  EXPECT_EQ(map.insert(pointIn({2, 1, 1}), &cell, grey), InsertResult::kOutside);
  EXPECT_TRUE(*map.find({1, 1, 1}) == full);
  EXPECT_EQ(map.find({1, 1, 1})->meanIntensity(), 7.0);
  EXPECT_EQ(AppearanceRecord().meanIntensity(), 0.0);
}

}  // namespace
}  // namespace ladar_perception
