// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "ladar_perception/resample/farthest_points.h"
#include "test_crusts.h"
#include "test_random.h"

namespace ladar_perception::test {
namespace {

FarthestPointsGoal goalOf(const Crust& crust, std::size_t count, float radius = 0.0F) {
  FarthestPointsGoal goal;
  goal.count = count;
  goal.radius = radius;
  const double spacing =
      count > 0 ? std::sqrt(static_cast<double>(crust.size()) / (0.8 * count)) : radius / 0.85;
  goal.first_radius = static_cast<float>(std::max(2.4 * spacing, 1.0));
  return goal;
}

template <typename Metric>
class ResampleFarthestPoints : public testing::Test {
 protected:
  static SampleSet choose(const Crust& crust, const FarthestPointsGoal& goal, int threads = 1) {
    FrontField field(crust);
    ThreadPool pool(threads);
    return chooseFarthestPoints<Metric>(&field, goal, &pool);
  }

  /// Greatest straight distance of a cell of a plane to the first `count` samples.
  static float coveringOf(const Crust& crust, const SampleSet& set, std::size_t count) {
    float farthest = 0.0F;
    for (const Eigen::Vector3f& p : crust.positions) {
      float nearest = 1e9F;
      for (std::size_t i = 0; i < count; ++i) {
        nearest = std::min(nearest, (set.positions[i] - p).norm());
      }
      farthest = std::max(farthest, nearest);
    }
    return farthest;
  }
};
using Metrics = testing::Types<FastMarching, Flood>;
TYPED_TEST_SUITE(ResampleFarthestPoints, Metrics);

TYPED_TEST(ResampleFarthestPoints, CountsAreExact) {
  const Crust crust = gridCrust(60, 50);
  for (const std::size_t count : {1, 2, 3, 5, 17, 100, 700}) {
    const SampleSet set = this->choose(crust, goalOf(crust, count));
    EXPECT_EQ(set.size(), count);
    EXPECT_EQ(set.positions.size(), count);
    EXPECT_EQ(set.covering.size(), count);
    EXPECT_EQ(std::set<uint32_t>(set.cells.begin(), set.cells.end()).size(), count);
  }
}

TYPED_TEST(ResampleFarthestPoints, NoMoreThanThereAreCells) {
  const Crust crust = gridCrust(4, 3);
  const SampleSet set = this->choose(crust, goalOf(crust, 100));
  EXPECT_GE(set.size(), 6u);
  EXPECT_LE(set.size(), 12u);
}

TYPED_TEST(ResampleFarthestPoints, OfNoCellsAreNone) {
  FarthestPointsGoal goal;
  goal.count = 5;
  goal.first_radius = 3.0F;
  EXPECT_EQ(this->choose(Crust(), goal).size(), 0u);
}

TYPED_TEST(ResampleFarthestPoints, StopAtARadius) {
  const Crust crust = gridCrust(80, 60);
  for (const float radius : {2.0F, 3.5F, 6.0F}) {
    const SampleSet set = this->choose(crust, goalOf(crust, 0, radius));
    EXPECT_LE(set.radius_reached, radius);
    EXPECT_LE(this->coveringOf(crust, set, set.size()), radius * 1.01F);
    for (std::size_t i = 0; i < set.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        EXPECT_GE((set.positions[i] - set.positions[k]).norm(), 0.85F * radius);
      }
    }
  }
}

TYPED_TEST(ResampleFarthestPoints, RadiiAreTrueAndDoNotGrow) {
  const Crust crust = gridCrust(80, 60);
  const SampleSet set = this->choose(crust, goalOf(crust, 500));
  for (std::size_t i = 1; i < set.size(); ++i) EXPECT_LE(set.covering[i], set.covering[i - 1]);
  for (const std::size_t count : {1, 2, 5, 20, 100, 250, 499, 500}) {
    const float farthest = this->coveringOf(crust, set, count);
    EXPECT_LE(farthest, 1.1F * set.covering[count - 1] + 0.5F) << count;
    EXPECT_LE(set.covering[count - 1], 1.5F * farthest) << count;
  }
}

TYPED_TEST(ResampleFarthestPoints, PrefixesAreGoodSamplings) {
  const Crust crust = gridCrust(100, 80);
  const SampleSet set = this->choose(crust, goalOf(crust, 1600));
  ASSERT_EQ(set.size(), 1600u);
  for (const std::size_t count : {200, 400, 800}) {
    const SampleSet alone = this->choose(crust, goalOf(crust, count));
    EXPECT_LE(this->coveringOf(crust, set, count), 1.3F * this->coveringOf(crust, alone, count))
        << count;
  }
}

TYPED_TEST(ResampleFarthestPoints, EveryIslandHasOne) {
  // 25 islands of 3 by 3 cells.
  const Crust crust = gridCrust(20, 20, [](int x, int y) { return x % 4 < 3 && y % 4 < 3; });
  const SampleSet set = this->choose(crust, goalOf(crust, 25));
  std::set<std::pair<int, int>> islands;
  for (const Eigen::Vector3f& p : set.positions) {
    islands.insert({static_cast<int>(p.x() + 0.5F) / 4, static_cast<int>(p.y() + 0.5F) / 4});
  }
  EXPECT_EQ(set.size(), 25u);
  EXPECT_GE(islands.size(), 20u);
}

TYPED_TEST(ResampleFarthestPoints, SlowGroundIsDense) {
  Crust crust = gridCrust(120, 60);
  // Twice as slow: four times as dense.
  for (std::size_t i = 0; i < crust.size(); ++i) {
    crust.slowness[i] = crust.positions[i].x() < 60.0F ? 1.0F : 2.0F;
  }
  const SampleSet set = this->choose(crust, goalOf(crust, 0, 8.0F));
  double fast = 0;
  double slow = 0;
  for (const Eigen::Vector3f& p : set.positions) {
    if (p.x() < 50.0F) ++fast;
    if (p.x() >= 70.0F) ++slow;
  }
  EXPECT_GT(slow / fast, 2.9);  // the rim counts less where samples are dense
  EXPECT_LT(slow / fast, 4.4);
}

TYPED_TEST(ResampleFarthestPoints, ThreadsGiveTheSameBytes) {
  const Crust crust = gridCrust(150, 140);
  const SampleSet one = this->choose(crust, goalOf(crust, 3000));
  for (const int threads : {2, 4}) {
    const SampleSet many = this->choose(crust, goalOf(crust, 3000), threads);
    EXPECT_TRUE(many.cells == one.cells);
    EXPECT_TRUE(many.positions == one.positions);
    EXPECT_TRUE(many.covering == one.covering);
  }
}

TYPED_TEST(ResampleFarthestPoints, ADeadlineStops) {
  const Crust crust = gridCrust(150, 140);
  FarthestPointsGoal goal = goalOf(crust, 5000);
  goal.deadline = std::chrono::steady_clock::now();
  const SampleSet set = this->choose(crust, goal);
  EXPECT_GT(set.size(), 50u);  // the start
  EXPECT_LT(set.size(), 5000u);
  EXPECT_LE(this->coveringOf(crust, set, set.size()), set.radius_reached + 1.0F);
}

TYPED_TEST(ResampleFarthestPoints, EarlierSamplesStayFirst) {
  const Crust crust = gridCrust(80, 60);
  FrontField field(crust);
  ThreadPool pool(1);
  const SampleSet before = chooseFarthestPoints<TypeParam>(&field, goalOf(crust, 100), &pool);
  const SampleSet set =
      chooseFarthestPoints<TypeParam>(&field, goalOf(crust, 300), &pool, {before, {}});
  ASSERT_EQ(set.size(), 300u);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(set.cells[i], before.cells[i]);
    EXPECT_EQ(set.positions[i], before.positions[i]);
  }
  EXPECT_EQ(std::set<uint32_t>(set.cells.begin(), set.cells.end()).size(), 300u);
  for (std::size_t i = 1; i < set.size(); ++i) EXPECT_LE(set.covering[i], set.covering[i - 1]);
}

}  // namespace
}  // namespace ladar_perception::test
