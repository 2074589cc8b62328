// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "box_sum_scene.h"
#include "ladar_perception/saliency/box_sum_strategy.h"
#include "map_oracle.h"

namespace ladar_perception {
namespace {

using test::BoxSumScene;
using test::ExpectedSum;
using test::expectedSums;
using test::pointIn;

class StrategyTest : public testing::TestWithParam<std::tuple<std::string, MapShape>> {
 protected:
  StrategyTest() {
    for (const std::string& name : boxSumStrategyNames()) {
      strategies_[name] = makeBoxSumStrategy(name);
    }
  }

  /// Every strategy against as many look-ups, voxel by voxel. The strategies are used again, so
  /// that what is left of earlier maps and radii has to be without effect.
  void expectLookUps(const BoxSumScene& scene, int r) {
    const std::vector<ExpectedSum> expected = expectedSums(scene, cube(r));
    ASSERT_EQ(expected.size(), scene.oracle.occupied());
    for (const auto& [name, strategy] : strategies_) {
      strategy->load(scene.map);
      const std::vector<int> threads = name == "sliding" ? kThreads : std::vector<int>{1};
      for (const int count : threads) {
        ThreadPool pool(count);
        strategy->compute(r, &pool, &sums_);
        ASSERT_EQ(sums_.size(), scene.map.slotBound());
        for (const ExpectedSum& e : expected) {
          ASSERT_EQ(sums_[e.slot] == e.sum, true)
              << name << ", r " << r << ", " << count << " threads, "
              << testing::PrintToString(e.voxel);
        }
      }
    }
  }

  const std::vector<int> kThreads = {1, 2, 3, 7};
  std::map<std::string, std::unique_ptr<BoxSumStrategy>> strategies_;
  std::vector<Moments> sums_;
};

TEST_P(StrategyTest, AllEqualTheLookUpsForEveryK) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {-3, 999999000, -2});
  scene.fill(kind);
  for (int r = 1; r <= 6; ++r) ASSERT_NO_FATAL_FAILURE(expectLookUps(scene, r));
}

TEST_P(StrategyTest, AllEqualTheLookUpsAfterScrolls) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {-999999000, 0, 0});
  const VoxelIndex stops[] = {{-999998998, -1, 0}, {-999998997, 1, -1}, {-999999001, -2, 1}};
  for (const VoxelIndex& stop : stops) {
    scene.fill(kind);
    scene.scrollTo(stop);
    for (const int r : {1, 4}) ASSERT_NO_FATAL_FAILURE(expectLookUps(scene, r));
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, StrategyTest,
                         testing::Combine(testing::ValuesIn(test::boxSumSceneKinds()),
                                          testing::ValuesIn(test::boxSumSceneShapes())),
                         [](const auto& maps) {
                           return std::get<0>(maps.param) + "_" +
                                  test::shapeName(std::get<1>(maps.param));
                         });

TEST(BoxSumStrategy, EveryVectorLevelGivesTheSameBits) {
  BoxSumScene scene({20, 18, 12}, {-7, 3, -5});
  scene.fill("random");
  const std::vector<ExpectedSum> expected = expectedSums(scene, cube(3));
  ThreadPool pool(1);
  std::vector<Moments> sums;
  for (const auto level : {VectorLevel::kBaseline, VectorLevel::kAvx2, VectorLevel::kAvx512}) {
    limitVectorLevel(level);
    for (const std::string& name : boxSumStrategyNames()) {
      const auto strategy = makeBoxSumStrategy(name);
      strategy->load(scene.map);
      strategy->compute(3, &pool, &sums);
      const bool same = std::all_of(expected.begin(), expected.end(),
                                    [&](const ExpectedSum& e) { return sums[e.slot] == e.sum; });
      EXPECT_TRUE(same) << name << " at " << vectorLevelName(level);
    }
  }
  limitVectorLevel(bestVectorLevel());
}

TEST(BoxSumStrategy, HasANameForEach) {
  const std::vector<std::string> names = {"hash_brute",    "dense_brute",   "naive_scan",
                                          "paper_reuse",   "paper_reuse_x", "paper_reuse_y",
                                          "paper_reuse_z", "sliding"};
  EXPECT_EQ(boxSumStrategyNames(), names);
  for (const std::string& name : names) EXPECT_NE(makeBoxSumStrategy(name), nullptr) << name;
  EXPECT_EQ(makeBoxSumStrategy("paper"), nullptr);
  EXPECT_EQ(makeBoxSumStrategy(""), nullptr);
}

TEST(BoxSumStrategy, CountsTheBytesOfItsLayout) {
  BoxSumScene scene({40, 30, 10}, {0, 0, 0});
  scene.fill("planar");
  const auto bytesOf = [&](const std::string& name) {
    const auto strategy = makeBoxSumStrategy(name);
    strategy->load(scene.map);
    return strategy->memoryBytes();
  };
  const std::size_t dense = 40 * 30 * 10 * sizeof(Moments);
  for (const char* name : {"dense_brute", "naive_scan", "paper_reuse"}) {
    EXPECT_GE(bytesOf(name), dense) << name;
    EXPECT_LT(bytesOf(name), dense * 3 / 2) << name;
  }
  for (const char* name : {"hash_brute", "sliding"}) {
    EXPECT_GE(bytesOf(name), scene.map.occupied() * sizeof(Moments)) << name;
    EXPECT_LT(bytesOf(name), dense) << name;
  }
}

// ReuseStatistics

VoxelMap mapOf(const MapShape& shape, const std::vector<VoxelIndex>& voxels) {
  VoxelMap map(shape, 1000);
  CellId cell = 0;
  for (const VoxelIndex& voxel : voxels) map.insert(pointIn(voxel), &cell);
  return map;
}

/// The voxels by X, of those that have one; `none` is how many have not.
void expectHistogram(const ReuseStatistics& statistics, const std::map<int, uint64_t>& by_distance,
                     uint64_t none) {
  uint64_t voxels = none;
  for (int x = 0; x < ReuseStatistics::kMaxDistance; ++x) {
    const auto it = by_distance.find(x);
    EXPECT_EQ(statistics.histogram[x], it == by_distance.end() ? 0 : it->second) << "X " << x;
    voxels += statistics.histogram[x];
  }
  EXPECT_EQ(statistics.histogram[ReuseStatistics::kMaxDistance], none);
  EXPECT_EQ(statistics.voxels, voxels);
}

TEST(ReuseStatistics, ARowIsOneApartAlongItselfAndAloneAcross) {
  const VoxelMap along_x =
      mapOf({6, 6, 6}, {{0, 2, 3}, {1, 2, 3}, {2, 2, 3}, {3, 2, 3}, {4, 2, 3}});
  const VoxelMap along_y =
      mapOf({6, 6, 6}, {{2, 0, 3}, {2, 1, 3}, {2, 2, 3}, {2, 3, 3}, {2, 4, 3}});
  const VoxelMap along_z =
      mapOf({6, 6, 6}, {{2, 3, 0}, {2, 3, 1}, {2, 3, 2}, {2, 3, 3}, {2, 3, 4}});
  const VoxelMap* maps[] = {&along_x, &along_y, &along_z};
  const ScanAxis axes[] = {ScanAxis::kX, ScanAxis::kY, ScanAxis::kZ};
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) {
      SCOPED_TRACE(testing::Message() << "row along " << row << ", axis " << axis);
      const ReuseStatistics statistics = reuseStatistics(*maps[row], axes[axis]);
      if (row == axis) {
        expectHistogram(statistics, {{1, 4}}, 1);
      } else {
        expectHistogram(statistics, {}, 5);
      }
    }
    expectHistogram(reuseStatistics(*maps[row], ScanAxis::kBest), {{1, 4}}, 1);
  }
}

TEST(ReuseStatistics, GapsAreDistancesAndFarOnesGoIntoTheLastBucket) {
  // X: none, 3, 1, 5, 31, 32 (too far to tell)
  const VoxelMap map =
      mapOf({73, 1, 1}, {{0, 0, 0}, {3, 0, 0}, {4, 0, 0}, {9, 0, 0}, {40, 0, 0}, {72, 0, 0}});
  const ReuseStatistics statistics = reuseStatistics(map, ScanAxis::kX);
  expectHistogram(statistics, {{3, 1}, {1, 1}, {5, 1}, {31, 1}}, 2);
  EXPECT_EQ(statistics.reuseShare(1), 0.0);
  EXPECT_EQ(statistics.meanDistance(1), 0.0);
  EXPECT_EQ(statistics.reuseShare(3), 1.0 / 6.0);
  EXPECT_EQ(statistics.meanDistance(3), 1.0);
  EXPECT_EQ(statistics.reuseShare(5), 1.0 / 6.0);  // X <= 2
  EXPECT_EQ(statistics.reuseShare(7), 2.0 / 6.0);  // X <= 3
  EXPECT_EQ(statistics.meanDistance(7), 2.0);
  EXPECT_EQ(statistics.reuseShare(9), 2.0 / 6.0);   // X <= 4
  EXPECT_EQ(statistics.reuseShare(11), 3.0 / 6.0);  // X <= 5
  EXPECT_EQ(statistics.meanDistance(11), 3.0);
  EXPECT_EQ(statistics.reuseShare(63), 4.0 / 6.0);  // X <= 31
  EXPECT_EQ(statistics.meanDistance(63), 10.0);
}

/// Occupied voxels of a layer z = 0 from a picture: '#' occupied, +y down, +x right.
std::vector<VoxelIndex> voxelsOf(const std::vector<std::string>& rows) {
  std::vector<VoxelIndex> voxels;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    for (std::size_t x = 0; x < rows[y].size(); ++x) {
      if (rows[y][x] == '#') voxels.push_back({static_cast<int>(x), static_cast<int>(y), 0});
    }
  }
  return voxels;
}

TEST(ReuseStatistics, TheBestOfThreeOfADrawnMap) {
  const std::vector<VoxelIndex> voxels = voxelsOf({
      "#..#",  //  x: -, 3      y: -, -      best: -, 3
      "....",  //
      "##.#",  //  x: -, 1, 2   y: 2, -, 2   best: 2, 1, 2
      ".#..",  //  x: -         y: 1         best: 1
  });
  const VoxelMap map = mapOf({4, 4, 2}, voxels);
  expectHistogram(reuseStatistics(map, ScanAxis::kX), {{1, 1}, {2, 1}, {3, 1}}, 3);
  expectHistogram(reuseStatistics(map, ScanAxis::kY), {{1, 1}, {2, 2}}, 3);
  expectHistogram(reuseStatistics(map, ScanAxis::kZ), {}, 6);
  const ReuseStatistics best = reuseStatistics(map, ScanAxis::kBest);
  expectHistogram(best, {{1, 2}, {2, 2}, {3, 1}}, 1);
  EXPECT_EQ(best.reuseShare(5), 4.0 / 6.0);
  EXPECT_EQ(best.meanDistance(5), 6.0 / 4.0);
}

/// Steps to the next occupied voxel down an axis, by look-ups.
int distanceDown(const VoxelMap& map, const VoxelIndex& voxel, int axis) {
  for (int d = 1; d < ReuseStatistics::kMaxDistance; ++d) {
    const VoxelIndex below = {voxel.x - (axis == 0 ? d : 0), voxel.y - (axis == 1 ? d : 0),
                              voxel.z - (axis == 2 ? d : 0)};
    if (map.find(below) != nullptr) return d;
  }
  return ReuseStatistics::kMaxDistance;
}

TEST(ReuseStatistics, EqualTheLookUpsOnRandomMapsWithScrolls) {
  BoxSumScene scene({40, 35, 70}, {-19, 1000, -30});
  for (int step = 0; step < 3; ++step) {
    scene.insertSomewhere(4000);
    scene.scrollTo({-19 + 7 * step, 1000 - 3 * step, -30 + step});
    ReuseStatistics expected[4];
    scene.map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t /*slot*/) {
      int best = ReuseStatistics::kMaxDistance;
      for (int axis = 0; axis < 3; ++axis) {
        const int distance = distanceDown(scene.map, voxel, axis);
        ++expected[axis].histogram[distance];
        best = std::min(best, distance);
      }
      ++expected[3].histogram[best];
    });
    const ScanAxis axes[] = {ScanAxis::kX, ScanAxis::kY, ScanAxis::kZ, ScanAxis::kBest};
    for (int i = 0; i < 4; ++i) {
      const ReuseStatistics statistics = reuseStatistics(scene.map, axes[i]);
      EXPECT_EQ(statistics.histogram, expected[i].histogram) << "axis " << i;
      EXPECT_EQ(statistics.voxels, scene.map.occupied());
    }
  }
}

TEST(ReuseStatistics, AnEmptyMapHasNothingToReuse) {
  const ReuseStatistics statistics = reuseStatistics(VoxelMap({5, 5, 5}, 10), ScanAxis::kBest);
  expectHistogram(statistics, {}, 0);
  EXPECT_EQ(statistics.reuseShare(9), 0.0);
  EXPECT_EQ(statistics.meanDistance(9), 0.0);
}

}  // namespace
}  // namespace ladar_perception
