// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>

#include "crust_clouds.h"
#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/voxel_pyramid.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::TestRandom;

using Sums = std::array<double, 11>;

/// In doubles, about `center`.
Sums directSums(const GridPoints& points, const std::vector<float>& weights, uint32_t first,
                uint32_t end, const Vector3d& center) {
  Sums sums{};
  for (uint32_t i = first; i < end; ++i) {
    const Vector3d p = points.positions[i].cast<double>() - center;
    const double weight = weights.empty() ? 1.0 : double{weights[points.sources[i]]};
    const Sums of_point = {1.0,           p.x(),         p.y(),         p.z(),
                           p.x() * p.x(), p.x() * p.y(), p.x() * p.z(), p.y() * p.y(),
                           p.y() * p.z(), p.z() * p.z(), weight};
    for (std::size_t n = 0; n < sums.size(); ++n) sums[n] += of_point[n];
  }
  return sums;
}

/// `edge` is that of the voxel: sums of lengths are compared in its units.
void expectSums(const PointSums& sums, const Sums& direct, double edge) {
  const Sums floats = {sums.count, sums.x,  sums.y,  sums.z,  sums.xx,    sums.xy,
                       sums.xz,    sums.yy, sums.yz, sums.zz, sums.weight};
  ASSERT_EQ(floats[0], direct[0]);
  for (std::size_t n = 1; n < floats.size(); ++n) {
    const double unit = n < 4 ? edge : n < 10 ? edge * edge : 1.0;
    const double size = direct[0] + std::abs(direct[n] / unit);
    ASSERT_NEAR(floats[n] / unit, direct[n] / unit, 2e-5 * size) << n;
  }
}

void expectPyramid(const GridPoints& points, const std::vector<float>& weights, int levels) {
  const VoxelPyramid pyramid(points, weights, levels);
  ASSERT_EQ(pyramid.levels(), levels);
  for (int number = 0; number < levels; ++number) {
    const VoxelLevel& level = pyramid.level(number);
    const std::size_t voxels = level.grid.size();
    ASSERT_EQ(level.sums.size(), voxels);
    ASSERT_EQ(level.first_child.size(), voxels);
    ASSERT_EQ(level.first_point.size(), voxels + 1);
    ASSERT_EQ(level.first_point.front(), 0u);
    ASSERT_EQ(level.first_point.back(), points.size());
    for (std::size_t i = 0; i < voxels; ++i) {
      const uint64_t key = level.grid.keys()[i];
      if (i > 0) {
        ASSERT_LT(level.grid.keys()[i - 1], key);
      }
      ASSERT_LT(level.first_point[i], level.first_point[i + 1]);
      for (uint32_t p = level.first_point[i]; p < level.first_point[i + 1]; ++p) {
        ASSERT_EQ(points.keys[p] >> 3 * number, key);
      }
      if (number == 0) {
        ASSERT_EQ(level.first_child[i], level.first_point[i]);
      } else {
        const VoxelLevel& below = pyramid.level(number - 1);
        const std::size_t child = level.first_child[i];
        ASSERT_EQ(below.grid.keys()[child] >> 3, key);
        ASSERT_EQ(below.first_point[child], level.first_point[i]);
      }
      const Vector3d center = brickCenter(key >> 6, number).cast<double>();
      expectSums(
          level.sums[i],
          directSums(points, weights, level.first_point[i], level.first_point[i + 1], center),
          std::exp2(number));
    }
  }
}

std::vector<float> randomWeights(std::size_t count, TestRandom* random) {
  std::vector<float> weights(count);
  for (float& weight : weights) weight = static_cast<float>(random->real(0.01, 1.0));
  return weights;
}

TEST(VoxelPyramid, SumsOfRandomPoints) {
  TestRandom random(1);
  for (const double spread : {1.0, 10.0, 300.0}) {
    Cloud cloud;
    for (int i = 0; i < 3000; ++i) cloud.push_back(spread * random.normal3());
    const GridPoints points = sortIntoGrid(cloud, test::gridFrame(0.7));
    for (const int levels : {1, 2, 4, 8}) expectPyramid(points, {}, levels);
    expectPyramid(points, randomWeights(cloud.size(), &random), 6);
  }
}

TEST(VoxelPyramid, SumsFarFromTheGridsOrigin) {
  // Their differences, not the places themselves, are summed.
  TestRandom random(2);
  Cloud cloud;
  for (int i = 0; i < 1000; ++i) cloud.push_back(Vector3d(2e5, -2e5, 1e5) + 4.0 * random.normal3());
  const GridPoints points = sortIntoGrid(cloud, test::gridFrame(1.0));
  ASSERT_EQ(points.size(), cloud.size());
  expectPyramid(points, {}, 5);
}

TEST(VoxelPyramid, WeightsAreFoundBySource) {
  // Sources 1 and 3 are in the first cell of the order, 0 and 2 in the second.
  const Cloud cloud = {{5.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {5.5, 0.6, 0.5}, {0.6, 0.5, 0.5}};
  const VoxelPyramid pyramid(sortIntoGrid(cloud, test::gridFrame(1.0)), {1, 2, 4, 8}, 4);
  ASSERT_EQ(pyramid.level(0).sums.size(), 2u);
  EXPECT_EQ(pyramid.level(0).sums[0].weight, 10.0F);
  EXPECT_EQ(pyramid.level(0).sums[1].weight, 5.0F);
  ASSERT_EQ(pyramid.level(3).sums.size(), 1u);
  EXPECT_EQ(pyramid.level(3).sums[0].weight, 15.0F);
}

TEST(VoxelPyramid, FewAndEqualPoints) {
  expectPyramid(sortIntoGrid({}, test::gridFrame(1.0)), {}, 4);
  expectPyramid(sortIntoGrid({{-0.1, 0, 0}}, test::gridFrame(1.0)), {}, 4);
  expectPyramid(sortIntoGrid({{-0.1, 0, 0}, {0, 0, 0}}, test::gridFrame(1.0)), {}, 4);
  expectPyramid(sortIntoGrid(Cloud(1000, Vector3d(7.3, -2.2, 9.9)), test::gridFrame(1.0)), {}, 4);
}

TEST(VoxelPyramid, LevelsHalveTheNumberOfCellsAlongAPlane) {
  Cloud cloud;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) cloud.emplace_back(x + 0.5, y + 0.5, 0.5);
  }
  const VoxelPyramid pyramid(sortIntoGrid(cloud, test::gridFrame(1.0)), {}, 6);
  for (int level = 0; level < 6; ++level) {
    EXPECT_EQ(pyramid.level(level).grid.size(), std::size_t{1024} >> 2 * level);
  }
}

TEST(PointSums, MovedSumsAreThoseAboutTheOtherCenter) {
  TestRandom random(3);
  for (int round = 0; round < 200; ++round) {
    const Vector3d offset = (8.0 * random.normal3()).array().round();
    PointSums sums;
    PointSums expected;
    for (int i = 0; i < 20; ++i) {
      const Vector3d p = 2.0 * random.normal3();
      const auto weight = static_cast<float>(random.real(0.1, 1.0));
      sums.add(p.cast<float>(), weight);
      expected.add((p + offset).cast<float>(), weight);
    }
    const PointSums moved = sums.movedBy(offset.cast<float>());
    EXPECT_EQ(moved.count, expected.count);
    EXPECT_EQ(moved.weight, expected.weight);
    EXPECT_NEAR(moved.x, expected.x, 1e-3);
    EXPECT_NEAR(moved.z, expected.z, 1e-3);
    EXPECT_NEAR(moved.xx, expected.xx, 2e-2);
    EXPECT_NEAR(moved.xy, expected.xy, 2e-2);
    EXPECT_NEAR(moved.xz, expected.xz, 2e-2);
    EXPECT_NEAR(moved.yy, expected.yy, 2e-2);
    EXPECT_NEAR(moved.yz, expected.yz, 2e-2);
    EXPECT_NEAR(moved.zz, expected.zz, 2e-2);
  }
}

TEST(PointSums, AddUp) {
  PointSums a;
  PointSums b;
  a.add({1, 2, 3}, 0.5F);
  b.add({4, 5, 6}, 0.25F);
  b.add({-1, 0, 2}, 1.0F);
  a.add(b);
  EXPECT_EQ(a.count, 3.0F);
  EXPECT_EQ(a.weight, 1.75F);
  EXPECT_EQ(a.x, 4.0F);
  EXPECT_EQ(a.y, 7.0F);
  EXPECT_EQ(a.z, 11.0F);
  EXPECT_EQ(a.xx, 18.0F);
  EXPECT_EQ(a.xy, 22.0F);
  EXPECT_EQ(a.xz, 25.0F);
  EXPECT_EQ(a.yy, 29.0F);
  EXPECT_EQ(a.yz, 36.0F);
  EXPECT_EQ(a.zz, 49.0F);
}

TEST(UnchangedBricks, AreThoseWithTheSamePoints) {
  TestRandom random(11);
  const Cloud cloud = test::patch({}, 40, 40, 3000, 0.2, &random);
  const test::GriddedCloud before(cloud);
  const test::GriddedCloud more(test::joined(cloud, {{8.5, 8.5, 0.1}, {-100, 3, 3}}));
  for (int number = 0; number <= kBridgeLevels; ++number) {
    const VoxelLevel& old = before.pyramid.level(number);
    const VoxelLevel& now = more.pyramid.level(number);
    const std::vector<uint32_t> same = unchangedBricks(now, old);
    ASSERT_EQ(same.size(), now.grid.bricks().size());
    std::size_t changed = 0;
    for (std::size_t brick = 0; brick < same.size(); ++brick) {
      if (same[brick] == kNoIndex) {
        ++changed;
        continue;
      }
      const uint32_t first = now.grid.bricks()[brick].first;
      for (uint32_t i = first; i < now.grid.brickEnd(brick); ++i) {
        ASSERT_EQ(now.grid.keys()[i], old.grid.keys()[same[brick] + i - first]);
        ASSERT_TRUE(now.sums[i] == old.sums[same[brick] + i - first]);
      }
    }
    EXPECT_EQ(changed, 2u);
  }
}

TEST(UnchangedBricks, NoneNextToOneThatIsGone) {
  const test::GriddedCloud before(Cloud{{1, 1, 1}, {5, 1, 1}, {9, 1, 1}, {13, 1, 1}});
  const test::GriddedCloud less(Cloud{{1, 1, 1}, {9, 1, 1}, {13, 1, 1}});
  EXPECT_EQ(unchangedBricks(less.pyramid.level(0), before.pyramid.level(0)),
            (std::vector<uint32_t>{kNoIndex, kNoIndex, 3}));
  EXPECT_EQ(unchangedBricks(before.pyramid.level(0), less.pyramid.level(0)),
            (std::vector<uint32_t>{0, kNoIndex, 1, 2}));
}

}  // namespace
}  // namespace ladar_perception
