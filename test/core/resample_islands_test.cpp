// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>

#include "crust_clouds.h"
#include "ladar_perception/resample/islands.h"
#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

using test::Cloud;
using test::TestRandom;

/// Points in the middles of the cells of a picture; a digit stands for as many points.
Cloud drawn(const std::vector<std::string>& rows, double z = 0.5) {
  Cloud cloud;
  for (std::size_t y = 0; y < rows.size(); ++y) {
    for (std::size_t x = 0; x < rows[y].size(); ++x) {
      for (char n = '0'; n < rows[y][x]; ++n) {
        cloud.emplace_back(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, z);
      }
    }
  }
  return cloud;
}

using Cube = std::array<int, 3>;

/// Islands by flooding a map of cubes, each the places of its points.
std::vector<std::vector<std::size_t>> islandsOf(const GridPoints& points, int level) {
  std::map<Cube, std::vector<std::size_t>> cubes;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const uint64_t key = points.keys[i] >> 3 * level;
    cubes[{static_cast<int>(morton::x(key)), static_cast<int>(morton::y(key)),
           static_cast<int>(morton::z(key))}]
        .push_back(i);
  }
  std::vector<std::vector<std::size_t>> islands;
  while (!cubes.empty()) {
    islands.emplace_back();
    std::vector<Cube> open = {cubes.begin()->first};
    while (!open.empty()) {
      const Cube at = open.back();
      open.pop_back();
      const auto found = cubes.find(at);
      if (found == cubes.end()) continue;
      islands.back().insert(islands.back().end(), found->second.begin(), found->second.end());
      cubes.erase(found);
      for (int n = 0; n < 27; ++n) {
        open.push_back({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
      }
    }
  }
  return islands;
}

/// Checks counts and points against the oracle; `most` islands of the same size may be any.
void expectDrops(const Cloud& cloud, int level, std::size_t least, std::size_t most) {
  const GridPoints before = sortIntoGrid(cloud, test::gridFrame(1.0));
  auto islands = islandsOf(before, level);
  std::sort(islands.begin(), islands.end(),
            [](const auto& a, const auto& b) { return a.size() > b.size(); });
  const bool any_large = !islands.empty() && islands[0].size() >= least;
  std::vector<std::size_t> kept_sizes;
  for (const auto& island : islands) {
    if (any_large && island.size() < least) continue;
    if (most == 0 || kept_sizes.size() < most) kept_sizes.push_back(island.size());
  }
  GridPoints after = before;
  const Islands result = dropSmallIslands(level, least, most, &after);
  ASSERT_EQ(result.kept, kept_sizes.size());
  ASSERT_EQ(result.dropped, islands.size() - kept_sizes.size());
  // What is left are whole islands of those sizes, in the order they had.
  ASSERT_EQ(after.sources.size(), after.size());
  ASSERT_EQ(after.positions.size(), after.size());
  const std::set<uint32_t> left(after.sources.begin(), after.sources.end());
  std::vector<std::size_t> left_sizes;
  for (const auto& island : islands) {
    std::size_t count = 0;
    for (const std::size_t i : island) count += left.count(before.sources[i]);
    ASSERT_TRUE(count == 0 || count == island.size());
    if (count > 0) left_sizes.push_back(count);
  }
  ASSERT_EQ(left_sizes, kept_sizes);
  std::size_t at = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (left.count(before.sources[i]) == 0) continue;
    ASSERT_EQ(after.sources[at], before.sources[i]);
    ASSERT_EQ(after.keys[at], before.keys[i]);
    ASSERT_EQ(after.positions[at], before.positions[i]);
    ++at;
  }
  ASSERT_EQ(at, after.size());
}

GridPoints remaining(const Cloud& cloud, int level, std::size_t least, std::size_t most,
                     Islands* islands) {
  GridPoints points = sortIntoGrid(cloud, test::gridFrame(1.0));
  *islands = dropSmallIslands(level, least, most, &points);
  return points;
}

const std::vector<std::string> kPicture = {
    "11..2....",  //
    "..1......",  // touches at a corner
    ".........",  //
    "1...5....",  //
    "1.......1",
};

TEST(Islands, DrawnPicture) {
  const Cloud cloud = drawn(kPicture);
  Islands islands;
  EXPECT_EQ(remaining(cloud, 0, 0, 0, &islands).size(), 13u);
  EXPECT_EQ(islands.kept, 5u);
  EXPECT_EQ(islands.dropped, 0u);
  EXPECT_EQ(remaining(cloud, 0, 3, 0, &islands).size(), 8u);  // the chain of 3 and the 5
  EXPECT_EQ(islands.kept, 2u);
  EXPECT_EQ(islands.dropped, 3u);
  EXPECT_EQ(remaining(cloud, 0, 2, 3, &islands).size(), 10u);
  EXPECT_EQ(islands.kept, 3u);
  const GridPoints largest = remaining(cloud, 0, 0, 1, &islands);
  ASSERT_EQ(largest.size(), 5u);
  EXPECT_EQ(largest.positions[0], Eigen::Vector3f(4.5F, 3.5F, 0.5F));
}

TEST(Islands, LargerCubesTouchOverWiderGaps) {
  const Cloud cloud = drawn({"1..1.........1"});
  Islands islands;
  remaining(cloud, 0, 0, 0, &islands);
  EXPECT_EQ(islands.kept, 3u);
  remaining(cloud, 1, 0, 0, &islands);  // cubes 0, 1 and 6
  EXPECT_EQ(islands.kept, 2u);
  remaining(cloud, 3, 0, 0, &islands);  // cubes 0 and 1
  EXPECT_EQ(islands.kept, 1u);
}

TEST(Islands, AllAreKeptWhereAllAreSmall) {
  const Cloud cloud = drawn(kPicture);
  Islands islands;
  EXPECT_EQ(remaining(cloud, 0, 6, 0, &islands).size(), cloud.size());
  EXPECT_EQ(islands.kept, 5u);
  EXPECT_EQ(islands.dropped, 0u);
  // The limit on their number stays.
  EXPECT_EQ(remaining(cloud, 0, 6, 2, &islands).size(), 8u);
  EXPECT_EQ(islands.kept, 2u);
  EXPECT_EQ(islands.dropped, 3u);
}

TEST(Islands, NoPointsAndOne) {
  Islands islands;
  EXPECT_EQ(remaining({}, 2, 5, 0, &islands).size(), 0u);
  EXPECT_EQ(islands.kept, 0u);
  EXPECT_EQ(islands.dropped, 0u);
  EXPECT_EQ(remaining({}, 0, 5, 3, &islands).size(), 0u);
  EXPECT_EQ(remaining({{0, 0, 0}}, 2, 5, 0, &islands).size(), 1u);
  EXPECT_EQ(islands.kept, 1u);
  EXPECT_EQ(islands.dropped, 0u);
}

TEST(Islands, DuplicatesAreOneIsland) {
  Islands islands;
  const Cloud cloud =
      test::joined(Cloud(100, Eigen::Vector3d(1, 1, 1)), Cloud(4, Eigen::Vector3d(90, 1, 1)));
  EXPECT_EQ(remaining(cloud, 1, 5, 0, &islands).size(), 100u);
  EXPECT_EQ(islands.kept, 1u);
  EXPECT_EQ(islands.dropped, 1u);
}

TEST(Islands, AgreeWithFloodingAMap) {
  TestRandom random(1);
  for (int round = 0; round < 60; ++round) {
    Cloud cloud;
    const int64_t clumps = random.integer(1, 25);
    for (int64_t clump = 0; clump < clumps; ++clump) {
      // Across the origin, where the highest bits of keys change.
      const Eigen::Vector3d at = 12.0 * random.normal3();
      const int64_t count = random.integer(1, 12);
      for (int64_t i = 0; i < count; ++i) cloud.push_back(at + 1.5 * random.normal3());
    }
    for (int level = 0; level < 4; ++level) {
      expectDrops(cloud, level, static_cast<std::size_t>(random.integer(0, 10)),
                  static_cast<std::size_t>(random.integer(0, 6)));
    }
  }
}

/// By all pairs.
std::vector<uint32_t> lonePointsOf(const GridPoints& points, float radius) {
  std::vector<uint32_t> lone;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool near = false;
    for (std::size_t k = 0; k < points.size() && !near; ++k) {
      const float distance = (points.positions[i] - points.positions[k]).norm();
      near = k != i && distance <= radius;
    }
    if (!near) lone.push_back(points.sources[i]);
  }
  return lone;
}

TEST(LonePoints, AreThoseOfAllPairs) {
  TestRandom random(5);
  for (const std::size_t count : {0u, 1u, 2u, 300u, 3000u}) {
    for (const auto& [level, radius] : {std::pair(1, 1.9F), {2, 3.6F}, {2, 4.0F}, {3, 7.5F}}) {
      const GridPoints before =
          sortIntoGrid(test::ball({3.3, 4.4, 5.5}, 30.0, count, &random), test::gridFrame(1.0));
      const std::vector<uint32_t> lone = lonePointsOf(before, radius);
      GridPoints after = before;
      ASSERT_EQ(dropLonePoints(level, radius, before.size(), &after), lone.size());
      std::vector<uint32_t> dropped;
      for (std::size_t i = 0, at = 0; i < before.size(); ++i) {
        if (at < after.size() && after.sources[at] == before.sources[i]) {
          ASSERT_EQ(after.keys[at], before.keys[i]);
          ASSERT_EQ(after.positions[at], before.positions[i]);
          ++at;
        } else {
          dropped.push_back(before.sources[i]);
        }
      }
      ASSERT_EQ(dropped, lone) << count << " " << level << " " << radius;
      // One more than are allowed: all stay.
      if (lone.empty()) continue;
      GridPoints all = before;
      EXPECT_EQ(dropLonePoints(level, radius, lone.size() - 1, &all), 0u);
      EXPECT_EQ(all.sources, before.sources);
    }
  }
}

TEST(LonePoints, DuplicatesAreNotAlone) {
  GridPoints points =
      sortIntoGrid({{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {40.5, 0.5, 0.5}}, test::gridFrame(1.0));
  EXPECT_EQ(dropLonePoints(2, 3.8F, 3, &points), 1u);
  EXPECT_EQ(points.sources, (std::vector<uint32_t>{0, 1}));
}

}  // namespace
}  // namespace ladar_perception
