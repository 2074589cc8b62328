// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ladar_perception/map/evidence_slices.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::listRecords;
using test::pointIn;
using test::TestRandom;

constexpr uint32_t kManyPoints = 1000000;
constexpr int kSlices = EvidenceSlices::kSlices;

/// A map that forgets, next to a list of all its points with the slices they came in.
class ForgetfulDrive {
 public:
  ForgetfulDrive(const MapShape& shape, uint64_t seed)
      : random_(seed), shape_(shape), map_(shape, kManyPoints), slices_(shape, kManyPoints) {
    scrollTo({-4, 1000000, -2});
  }

  TestRandom& random() { return random_; }
  const VoxelMap& map() const { return map_; }
  const EvidenceSlices& slices() const { return slices_; }
  std::size_t points() const { return points_.size(); }

  void insertAround(int64_t count) {
    for (int64_t i = 0; i < count; ++i) {
      const auto coordinate = [&](int32_t from, int n) {
        return random_.integer((from - int64_t{1}) * kStepsPerVoxel,
                               (from + int64_t{n} + 1) * kStepsPerVoxel - 1);
      };
      const int64_t x = coordinate(min_.x, shape_.nx);
      const int64_t y = coordinate(min_.y, shape_.ny);
      insert({x, y, coordinate(min_.z, shape_.nz)});
    }
  }
  void insert(const FixedPoint& q) {
    CellId cell = 0;
    if (map_.insert(q, &cell) != InsertResult::kInserted) return;
    slices_.current().insert(q, &cell);
    points_.push_back({q, slice_});
  }
  void scrollTo(const VoxelIndex& min) {
    min_ = min;
    map_.scrollTo(min);
    slices_.scrollTo(min);
    const auto left = [&](const Point& point) {
      const VoxelIndex v = voxelOf(point.q);
      return v.x < min.x || v.x >= min.x + shape_.nx || v.y < min.y || v.y >= min.y + shape_.ny ||
             v.z < min.z || v.z >= min.z + shape_.nz;
    };
    points_.erase(std::remove_if(points_.begin(), points_.end(), left), points_.end());
  }
  void scrollBy(int64_t dx, int64_t dy, int64_t dz) {
    scrollTo({static_cast<int32_t>(min_.x + dx), static_cast<int32_t>(min_.y + dy),
              static_cast<int32_t>(min_.z + dz)});
  }
  void advance(double lifetimes) {
    slices_.advance(lifetimes, &map_);
    const auto slice = static_cast<int64_t>(std::floor(lifetimes * kSlices));
    slice_ = started_ ? std::max(slice_, slice) : slice;
    started_ = true;
    const auto old = [&](const Point& point) { return point.slice + kSlices <= slice_; };
    points_.erase(std::remove_if(points_.begin(), points_.end(), old), points_.end());
  }
  void clear() {
    map_.clear();
    slices_.clear();
    points_.clear();
    started_ = false;
  }
  /// A map that never saw any point but the young ones.
  void expectFresh() const {
    VoxelMap fresh(shape_, kManyPoints);
    fresh.scrollTo(min_);
    CellId cell = 0;
    for (const Point& point : points_) fresh.insert(point.q, &cell);
    ASSERT_EQ(listRecords(map_), listRecords(fresh));
    ASSERT_EQ(map_.occupied(), fresh.occupied());
  }

 private:
  struct Point {
    FixedPoint q;
    int64_t slice;
  };

  TestRandom random_;
  MapShape shape_;
  VoxelMap map_;
  EvidenceSlices slices_;
  VoxelIndex min_;
  std::vector<Point> points_;
  int64_t slice_ = 0;
  bool started_ = false;
};

class EvidenceSlicesDrive : public testing::TestWithParam<MapShape> {};

TEST_P(EvidenceSlicesDrive, TheMapIsAFreshOneOfTheYoungPoints) {
  ForgetfulDrive drive(GetParam(), 3);
  TestRandom& random = drive.random();
  const MapShape& shape = GetParam();
  double lifetimes = 17.3;
  for (int step = 0; step < 400; ++step) {
    const int64_t kind = random.integer(0, 99);
    if (kind < 55) {
      lifetimes += random.real(0.0, 0.2);
    } else if (kind < 60) {
      lifetimes += random.real(0.5, 3.0);
    } else if (kind < 62) {
      lifetimes += 1e6;
    }
    drive.advance(lifetimes);
    ASSERT_NO_FATAL_FAILURE(drive.expectFresh()) << "after advancing, step " << step;
    drive.insertAround(random.integer(0, 60));
    if (kind >= 90) drive.scrollBy(shape.nx * (kind % 3 - 1), shape.ny * (kind % 2), 0);
    if (kind == 80) drive.clear();
    const int64_t dx = random.integer(-2, 2);
    const int64_t dy = random.integer(-1, 1);
    drive.scrollBy(dx, dy, random.integer(0, 9) == 0 ? 1 : 0);
    ASSERT_NO_FATAL_FAILURE(drive.expectFresh()) << "after scrolling, step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, EvidenceSlicesDrive,
                         testing::Values(MapShape{7, 5, 3}, MapShape{12, 9, 70}, MapShape{1, 1, 1}),
                         [](const auto& shape) { return test::shapeName(shape.param); });

TEST(EvidenceSlices, PointsLiveForSevenEighthsToOneLifetime) {
  for (const double offset : {0.0, 0.01, 0.0625, 0.124}) {
    VoxelMap map({2, 2, 2}, kManyPoints);
    EvidenceSlices slices({2, 2, 2}, kManyPoints);
    slices.advance(5.0 + offset, &map);
    CellId cell = 0;
    map.insert(pointIn({1, 1, 1}), &cell);
    slices.current().insert(pointIn({1, 1, 1}), &cell);
    slices.advance(5.0 + offset + 0.875, &map);
    EXPECT_EQ(map.occupied(), 1U) << offset;
    slices.advance(5.999, &map);
    EXPECT_EQ(map.occupied(), 1U) << offset;
    slices.advance(6.0, &map);
    EXPECT_EQ(map.occupied(), 0U) << offset;
  }
}

TEST(EvidenceSlices, AFractionOfAVoxelsPointsIsForgottenSliceBySlice) {
  VoxelMap map({1, 1, 1}, kManyPoints);
  EvidenceSlices slices({1, 1, 1}, kManyPoints);
  CellId cell = 0;
  for (int i = 0; i < kSlices; ++i) {
    slices.advance(i / 8.0, &map);
    for (int j = 0; j <= i; ++j) {
      map.insert(pointIn({0, 0, 0}, i, j, 0), &cell);
      slices.current().insert(pointIn({0, 0, 0}, i, j, 0), &cell);
    }
  }
  Moments left = *map.find({0, 0, 0});
  for (int i = 0; i < kSlices - 1; ++i) {
    slices.advance(1.0 + i / 8.0, &map);
    for (int j = 0; j <= i; ++j) {
      Moments point;
      point.add(pointIn({0, 0, 0}, i, j, 0));
      left -= point;
    }
    ASSERT_NE(map.find({0, 0, 0}), nullptr);
    EXPECT_EQ(*map.find({0, 0, 0}), left) << i;
  }
  slices.advance(1.875, &map);
  EXPECT_EQ(map.occupied(), 0U);
}

TEST(EvidenceSlices, ALongPauseForgetsEverything) {
  for (const double pause : {1.0, 1.5, 2.0, 7.3, 1e9}) {
    ForgetfulDrive drive({5, 5, 5}, 9);
    for (int i = 0; i < 12; ++i) {
      drive.advance(3.0 + i / 8.0);
      drive.insertAround(30);
    }
    drive.advance(3.0 + 11 / 8.0 + pause);
    EXPECT_EQ(drive.points(), 0U);
    EXPECT_EQ(drive.map().occupied(), 0U);
    drive.insertAround(30);
    ASSERT_NO_FATAL_FAILURE(drive.expectFresh());
    drive.advance(3.0 + 11 / 8.0 + pause + 0.875);
    EXPECT_GT(drive.map().occupied(), 0U);
    ASSERT_NO_FATAL_FAILURE(drive.expectFresh());
  }
}

TEST(EvidenceSlices, TimeDoesNotRunBackwards) {
  ForgetfulDrive drive({5, 5, 5}, 10);
  drive.advance(4.0);
  drive.insertAround(50);
  const std::size_t points = drive.points();
  drive.advance(1.0);  // a clock that was set back
  drive.insertAround(50);
  EXPECT_GT(drive.points(), points);
  ASSERT_NO_FATAL_FAILURE(drive.expectFresh());
  drive.advance(4.9);
  ASSERT_NO_FATAL_FAILURE(drive.expectFresh());
  drive.advance(5.0);
  EXPECT_EQ(drive.map().occupied(), 0U);
}

TEST(EvidenceSlices, ClearForgetsTheTimeToo) {
  ForgetfulDrive drive({5, 5, 5}, 11);
  drive.advance(100.0);
  drive.insertAround(50);
  drive.clear();
  drive.advance(2.0);
  drive.insertAround(50);
  drive.advance(2.5);
  ASSERT_NO_FATAL_FAILURE(drive.expectFresh());
  EXPECT_GT(drive.map().occupied(), 0U);
  drive.advance(3.0);
  EXPECT_EQ(drive.map().occupied(), 0U);
}

TEST(EvidenceSlices, ForgettingIsAChangeOfTheMap) {
  VoxelMap map({4, 4, 4}, kManyPoints);
  EvidenceSlices slices({4, 4, 4}, kManyPoints);
  slices.advance(0.0, &map);
  CellId cell = 0;
  map.insert(pointIn({3, 1, 2}), &cell);
  slices.current().insert(pointIn({3, 1, 2}), &cell);
  map.forgetChanges();
  slices.advance(0.9, &map);
  EXPECT_TRUE(map.changedColumns().empty());
  slices.advance(1.0, &map);
  ASSERT_EQ(map.changedColumns().size(), 1U);
  EXPECT_EQ(map.changedColumns()[0].x, 3);
  EXPECT_EQ(map.changedColumns()[0].y, 1);
}

TEST(EvidenceSlices, MemoryIsFlatOverALongDrive) {
  ForgetfulDrive drive({30, 30, 10}, 12);
  std::size_t bytes = 0;
  for (int step = 0; step < 4000; ++step) {
    drive.advance(step / 40.0);
    drive.insertAround(40);
    drive.scrollBy(step % 200 < 100 ? 1 : -1, 0, 0);
    if (step == 2000) bytes = drive.slices().memoryBytes();
  }
  EXPECT_GT(bytes, 0U);
  EXPECT_LE(drive.slices().memoryBytes(), bytes * 11 / 10);
}

TEST(EvidenceSlices, DisabledOnesKeepNothing) {
  EvidenceSlices disabled;
  EXPECT_FALSE(disabled.enabled());
  disabled.scrollTo({1, 2, 3});
  disabled.clear();
  EXPECT_EQ(disabled.memoryBytes(), 0U);
  EXPECT_TRUE(EvidenceSlices({2, 2, 2}, 10).enabled());
}

}  // namespace
}  // namespace ladar_perception
