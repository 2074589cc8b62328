// SPDX-License-Identifier: BSD-3-Clause
// The crust of surfels with cells of several sizes.
#include <gtest/gtest.h>

#include <cmath>

#include "crust_checks.h"
#include "crust_clouds.h"
#include "ladar_perception/resample/crust.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::GriddedCloud;
using test::PlaneFrame;
using test::TestRandom;

constexpr int kCoarsest = 3;
const Vector3f kAbove(0, 0, 500);

GriddedCloud gridded(const Cloud& cloud) {
  return GriddedCloud(cloud, test::gridFrame(1.0), {}, kBridgeLevels + 1 + kCoarsest);
}

/// `wanted` gives the level for the place of a voxel's middle.
template <typename Wanted>
Crust crustOf(const GriddedCloud& cloud, const Wanted& wanted, int threads = 1,
              const Vector3f& sensor = kAbove) {
  std::vector<uint8_t> levels;
  for (const uint64_t key : cloud.pyramid.level(0).grid.keys()) {
    levels.push_back(static_cast<uint8_t>(wanted(cubeCenter(key, 0))));
  }
  ThreadPool pool(threads);
  return makeSurfelCrust(cloud.pyramid, cloud.points.frame, levels, sensor, &pool);
}

/// No cell lies inside another one.
void expectDisjoint(const Crust& crust) {
  std::set<std::pair<int, uint64_t>> cells;
  for (std::size_t i = 0; i < crust.size(); ++i) {
    cells.insert({crust.levels[i], crust.keys[i] >> 3 * crust.levels[i]});
  }
  ASSERT_EQ(cells.size(), crust.size());
  for (std::size_t i = 0; i < crust.size(); ++i) {
    for (int above = crust.levels[i] + 1; above <= kCoarsest; ++above) {
      ASSERT_EQ(cells.count({above, crust.keys[i] >> 3 * above}), 0u);
    }
  }
}

void expectSound(const Crust& crust) {
  test::expectSoundCrust(crust, kAbove);
  expectDisjoint(crust);
}

Cloud planeCloud(double tilt, double height, TestRandom* random) {
  const PlaneFrame plane({0, 0, height}, test::tilted(tilt, 15.0));
  return test::patch(plane, 90, 60, 45000, 0.05, random);
}

TEST(CrustOfLevels, AllOfLevelZeroIsTheCrustWithoutLevels) {
  TestRandom random(1);
  const GriddedCloud cloud = gridded(planeCloud(20.0, 0.3, &random));
  ThreadPool pool(1);
  const Crust plain = makeSurfelCrust(cloud.pyramid, cloud.points.frame, {}, kAbove, &pool);
  const Crust same = crustOf(cloud, [](const Vector3f&) { return 0; });
  expectSound(same);
  EXPECT_EQ(test::countParts(same), 1u);
  EXPECT_NEAR(same.area_m2(), plain.area_m2(), 0.01 * plain.area_m2());
}

TEST(CrustOfLevels, AllOfOneLevelAreCellsOfThatSize) {
  TestRandom random(2);
  for (int level = 1; level <= kCoarsest; ++level) {
    const GriddedCloud cloud = gridded(planeCloud(10.0, 0.3, &random));
    const Crust crust = crustOf(cloud, [&](const Vector3f&) { return level; });
    expectSound(crust);
    EXPECT_EQ(test::countParts(crust), 1u);
    for (const uint8_t of_cell : crust.levels) ASSERT_EQ(of_cell, level);
    const double expected = 90.0 * 60.0 * std::cos(10.0 * M_PI / 180.0) / std::exp2(2 * level);
    EXPECT_NEAR(static_cast<double>(crust.size()) / expected, 1.0, 0.05 + 0.05 * (1 << level));
  }
}

TEST(CrustOfLevels, APlaneIsConnectedAcrossTheChangeOfSize) {
  TestRandom random(3);
  for (const double tilt : {0.0, 12.0, 28.0, 45.0}) {
    for (const double height : {0.0, 0.4, 3.7}) {
      for (int level = 1; level <= kCoarsest; ++level) {
        const GriddedCloud cloud = gridded(planeCloud(tilt, height, &random));
        // A border that is none of the larger cells'.
        const Crust crust =
            crustOf(cloud, [&](const Vector3f& p) { return p.x() < 2.7F ? 0 : level; });
        expectSound(crust);
        EXPECT_EQ(test::countParts(crust), 1u) << tilt << " " << height << " " << level;
        std::array<std::size_t, kCoarsest + 1> of_level{};
        for (const uint8_t of_cell : crust.levels) ++of_level[of_cell];
        EXPECT_GT(of_level[0], 1000u);
        EXPECT_GT(of_level[static_cast<std::size_t>(level)], 1000u >> 2 * level);
        const PlaneFrame plane({0, 0, height}, test::tilted(tilt, 15.0));
        for (std::size_t i = 0; i < crust.size(); ++i) {
          const Vector3d p = crust.positions[i].cast<double>();
          ASSERT_NEAR(plane.height(p), 0.0, 0.2 + 0.05 * crust.edge(i));
        }
      }
    }
  }
}

TEST(CrustOfLevels, AreaOfAPlaneDoesNotDependOnTheSizes) {
  TestRandom random(4);
  for (const double tilt : {0.0, 12.0, 28.0, 45.0}) {
    const PlaneFrame plane({0, 0, 0.4}, test::tilted(tilt, 15.0));
    const GriddedCloud cloud = gridded(test::patch(plane, 90, 90, 60000, 0.05, &random));
    const Crust crust = crustOf(cloud, [](const Vector3f& p) {
      return p.x() < -20.0F ? 0 : p.x() < 10.0F ? 1 : 2;
    });
    expectSound(crust);
    EXPECT_NEAR(crust.area_m2() / 8100.0, 1.0, 0.05) << tilt;
  }
}

TEST(CrustOfLevels, NoHolesWhereSizesChange) {
  TestRandom random(5);
  const GriddedCloud cloud = gridded(planeCloud(0.0, 0.4, &random));
  for (const float border : {-2.0F, 0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F}) {
    const Crust crust =
        crustOf(cloud, [&](const Vector3f& p) { return p.x() < border ? 0 : kCoarsest; });
    expectSound(crust);
    std::set<std::array<int, 2>> covered;
    for (std::size_t i = 0; i < crust.size(); ++i) {
      const test::CellPlace at = test::placeOf(crust, i);
      for (int n = 0; n < 1 << 2 * crust.levels[i]; ++n) {
        covered.insert({at[0] + n % (1 << crust.levels[i]), at[1] + n / (1 << crust.levels[i])});
      }
    }
    const int origin = static_cast<int>(GridFrame::kOriginCell);
    std::size_t holes = 0;
    for (int y = -25; y < 25; ++y) {
      for (int x = -25; x < 25; ++x) holes += 1 - covered.count({origin + x, origin + y});
    }
    EXPECT_EQ(holes, 0u) << border;
  }
}

TEST(CrustOfLevels, ACornerIsConnectedWhereFloorAndWallDiffer) {
  TestRandom random(6);
  const Cloud floor = test::patch({{0, 0, 0.3}, {0, 0, 1}}, 48, 48, 15000, 0.05, &random);
  const Cloud wall = test::patch({{24.4, 0, 24}, {1, 0, 0}}, 48, 48, 15000, 0.05, &random);
  const GriddedCloud cloud = gridded(test::joined(floor, wall));
  const Vector3f sensor(-60, 0, 70);
  const Crust crust = crustOf(
      cloud, [](const Vector3f& p) { return p.z() > 1.0F ? 2 : 0; }, 1, sensor);
  test::expectSoundCrust(crust, sensor);
  expectDisjoint(crust);
  EXPECT_GT(test::largestPart(crust), 0.99);
}

TEST(CrustOfLevels, VoxelsThatMixSizesGetTheFinest) {
  TestRandom random(7);
  const GriddedCloud cloud = gridded(planeCloud(0.0, 0.4, &random));
  const Crust crust = crustOf(cloud, [&](const Vector3f& p) {
    return std::abs(p.x() - 10.5F) < 0.1F && std::abs(p.y() - 10.5F) < 0.1F ? 0 : 2;
  });
  expectSound(crust);
  EXPECT_EQ(test::countParts(crust), 1u);
  for (std::size_t i = 0; i < crust.size(); ++i) {
    // The cell of 4 around the only voxel that wants 1.
    const Vector3f p = crust.positions[i];
    const bool in_it = p.x() > 8.0F && p.x() < 12.0F && p.y() > 8.0F && p.y() < 12.0F;
    if (in_it) {
      ASSERT_LT(crust.levels[i], 2);
    }
  }
}

TEST(CrustOfLevels, RandomSizesKeepWhatHoldsForAll) {
  TestRandom random(8);
  const Cloud cloud = test::joined(test::patch({{0, 0, 0}, {1, 2, 5}}, 80, 80, 40000, 0.2, &random),
                                   test::ball({0, 0, 30}, 15, 2000, &random));
  const GriddedCloud in_grid = gridded(cloud);
  // Patches of 7 cells want what they want.
  const auto wanted = [](const Vector3f& p) {
    const auto patch = [](float value) { return floorToInt(value / 7.0F); };
    return static_cast<int>(
        static_cast<uint32_t>(patch(p.x()) * 7 + patch(p.y()) * 13 + patch(p.z()) * 29) % 4U);
  };
  const Crust crust = crustOf(in_grid, wanted);
  test::expectSoundLinks(crust);
  expectDisjoint(crust);
  test::expectSameCrust(crust, crustOf(in_grid, wanted, 3));
}

TEST(CrustOfLevels, OfFewPoints) {
  for (std::size_t count = 1; count <= 3; ++count) {
    Cloud few;
    for (std::size_t i = 0; i < count; ++i) few.emplace_back(100.0 * double(i) + 0.5, 0.5, 0.5);
    const Crust crust = crustOf(gridded(few), [](const Vector3f&) { return kCoarsest; });
    expectSound(crust);
    ASSERT_GE(crust.size(), count);
    EXPECT_EQ(test::countParts(crust), count);
  }
}

}  // namespace
}  // namespace ladar_perception
