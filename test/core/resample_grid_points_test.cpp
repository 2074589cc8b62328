// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "crust_clouds.h"
#include "ladar_perception/resample/grid_points.h"
#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::TestRandom;

Cloud randomCloud(std::size_t count, double extent, uint64_t seed) {
  TestRandom random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.real(-extent, extent);
    const double y = random.real(-extent, extent);
    cloud.emplace_back(x, y, random.real(-extent, extent));
  }
  return cloud;
}

uint64_t keyByFloor(const Vector3f& p) {
  const auto cell = [](float value) {
    return static_cast<uint32_t>(int64_t{GridFrame::kOriginCell} +
                                 static_cast<int64_t>(std::floor(double{value})));
  };
  return morton::encode(cell(p.x()), cell(p.y()), cell(p.z()));
}

TEST(GridPoints, FloorOfNegativeAndWholeNumbers) {
  const float values[] = {-2.0F, -1.5F, -1.0F, -1e-20F, -0.0F,     0.0F,
                          0.5F,  1.0F,  1.5F,  -7e4F,   -70000.5F, 524223.97F};
  for (const float value : values) {
    EXPECT_EQ(floorToInt(value), static_cast<int>(std::floor(double{value}))) << value;
  }
  EXPECT_EQ(floorToInt(std::nextafter(-3.0F, -4.0F)), -4);
  EXPECT_EQ(floorToInt(std::nextafter(-3.0F, 0.0F)), -3);
}

TEST(GridPoints, KeysOfPlaces) {
  TestRandom random(1);
  for (int i = 0; i < 100000; ++i) {
    const double reach = std::exp2(random.real(0.0, 18.9));
    const float x = static_cast<float>(random.real(-reach, reach));
    const float y = static_cast<float>(random.integer(-5, 5));
    const float z = -0.5F * static_cast<float>(random.integer(-5, 5));
    ASSERT_EQ(cellKey({x, y, z}), keyByFloor({x, y, z}));
  }
}

TEST(GridPoints, CentersOfCubes) {
  TestRandom random(2);
  for (int level = 0; level <= 8; ++level) {
    const auto edge = static_cast<float>(1 << level);
    for (int i = 0; i < 1000; ++i) {
      const Vector3f p(static_cast<float>(random.real(-1e5, 1e5)),
                       static_cast<float>(random.real(-1e5, 1e5)),
                       static_cast<float>(random.real(-1e5, 1e5)));
      const uint64_t key = cellKey(p) >> 3 * level;
      const Vector3f center = cubeCenter(key, level);
      ASSERT_LE((center - p).cwiseAbs().maxCoeff(), 0.5F * edge);
      ASSERT_EQ(cellKey(center) >> 3 * level, key);
    }
  }
  EXPECT_EQ(cubeCenter(cellKey({0.2F, -0.2F, 3.9F}), 0), Vector3f(0.5F, -0.5F, 3.5F));
  EXPECT_EQ(cubeCenter(cellKey({0.2F, -0.2F, 3.9F}) >> 6, 2), Vector3f(2.0F, -2.0F, 2.0F));
}

TEST(GridPoints, InTheOrderOfCellsAndThenOfSources) {
  TestRandom random(3);
  Cloud cloud;
  for (int i = 0; i < 5000; ++i) {
    // Few cells, so that many points share one.
    const double x = random.real(-4.0, 4.0);
    const double y = random.real(-4.0, 4.0);
    cloud.emplace_back(x, y, random.real(-1.0, 1.0));
  }
  const GridFrame frame = test::gridFrame(0.5, {0.1, -0.2, 0.3});
  for (const std::size_t stride : {1u, 3u, 4999u, 7000u}) {
    const GridPoints points = sortIntoGrid(cloud, frame, stride);
    ASSERT_EQ(points.size(), (cloud.size() + stride - 1) / stride);
    ASSERT_EQ(points.sources.size(), points.size());
    ASSERT_EQ(points.positions.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(points.sources[i] % stride, 0u);
      ASSERT_EQ(points.keys[i], keyByFloor(points.positions[i]));
      ASSERT_LT((frame.toMetres(points.positions[i]) - cloud[points.sources[i]]).norm(), 1e-6);
      if (i == 0) continue;
      ASSERT_LE(points.keys[i - 1], points.keys[i]);
      if (points.keys[i - 1] == points.keys[i]) {
        ASSERT_LT(points.sources[i - 1], points.sources[i]);
      }
    }
    const std::set<uint32_t> sources(points.sources.begin(), points.sources.end());
    ASSERT_EQ(sources.size(), points.size());
  }
}

TEST(GridPoints, NoneAndOnePoint) {
  EXPECT_EQ(sortIntoGrid({}, test::gridFrame(0.1)).size(), 0u);
  EXPECT_EQ(sortIntoGrid({}, test::gridFrame(0.1), 7).size(), 0u);
  const GridPoints one = sortIntoGrid({{0.25, -0.25, 0.0}}, test::gridFrame(0.1));
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one.sources[0], 0u);
  EXPECT_NEAR(one.positions[0].x(), 2.5F, 1e-6F);
}

TEST(GridPoints, PointsOutOfReachAreLeftOut) {
  const double infinity = std::numeric_limits<double>::infinity();
  const GridFrame frame = test::gridFrame(0.5);
  const double reach_m = 0.5 * GridFrame::kReachCells;
  const Cloud cloud = {{0, 0, 0},          {reach_m, 0, 0},   {-reach_m - 1.0, 0, 0},
                       {0, infinity, 0},   {0, 0, -infinity}, {0, -reach_m + 1.0, 0},
                       {1e300, 0, -1e300}, {0, 0, 1.0}};
  const GridPoints points = sortIntoGrid(cloud, frame);
  std::vector<uint32_t> sources = points.sources;
  std::sort(sources.begin(), sources.end());
  EXPECT_EQ(sources, (std::vector<uint32_t>{0, 5, 7}));
}

TEST(GridPoints, PlacesAreExactToAThousandthOfACell) {
  // As far as the doubles that are given are: near the origin of the grid, wherever that lies.
  for (const Vector3d& origin : {Vector3d(0, 0, 0), Vector3d(1e6, -1e6, 1e4)}) {
    const GridFrame frame = test::gridFrame(0.05, origin);
    Cloud cloud = randomCloud(2000, 800.0, 4);  // up to 16,000 cells away
    for (Vector3d& p : cloud) p += origin;
    const GridPoints points = sortIntoGrid(cloud, frame);
    ASSERT_EQ(points.size(), cloud.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d error = frame.toMetres(points.positions[i]) - cloud[points.sources[i]];
      ASSERT_LT(error.cwiseAbs().maxCoeff(), 1e-3 * frame.cell_m);
    }
  }
}

TEST(GridPoints, ACloudMovedByWholeMetresGivesTheSameBits) {
  Cloud cloud = randomCloud(3000, 30.0, 5);
  for (Vector3d& p : cloud) p = (p * 1024.0).array().round() / 1024.0;
  const Vector3d offset(1048576.0, -2097152.0, 65536.0);
  Cloud far = cloud;
  for (Vector3d& p : far) p += offset;
  const GridPoints near_points = sortIntoGrid(cloud, test::gridFrame(0.1, {1, 2, 3}));
  const GridPoints far_points = sortIntoGrid(far, test::gridFrame(0.1, Vector3d(1, 2, 3) + offset));
  EXPECT_EQ(near_points.keys, far_points.keys);
  EXPECT_EQ(near_points.sources, far_points.sources);
  EXPECT_TRUE(near_points.positions == far_points.positions);
}

TEST(GridOrigin, IsTheLeastCorner) {
  EXPECT_EQ(gridOrigin({}, 0.1), Vector3d(0, 0, 0));
  EXPECT_EQ(gridOrigin({{3, -4, 5}}, 0.1), Vector3d(3, -4, 5));
  EXPECT_EQ(gridOrigin({{3, -4, 5}, {1, 2, 6}, {2, -5, 7}}, 0.1), Vector3d(1, -5, 5));
}

TEST(GridOrigin, EveryPointIsInReachOfItIfTheExtentAllows) {
  const double cell_m = 0.01;
  const double extent_m = 0.999 * GridFrame::kReachCells * cell_m;
  const Cloud cloud = {{1e6, 0, 0}, {1e6 + extent_m, 0, 0}, {1e6, extent_m, -extent_m}};
  const GridFrame frame = test::gridFrame(cell_m, gridOrigin(cloud, cell_m));
  EXPECT_EQ(sortIntoGrid(cloud, frame).size(), cloud.size());
}

TEST(GridOrigin, FarOutliersDoNotTakeTheCloudOutOfReach) {
  Cloud cloud = randomCloud(101, 10.0, 6);
  for (Vector3d& p : cloud) p += Vector3d(500, 600, 700);
  cloud.emplace_back(-1e9, 0, 0);
  cloud.emplace_back(0, 1e9, 0);
  cloud.emplace_back(0, 0, -1e9);
  const GridFrame frame = test::gridFrame(0.001, gridOrigin(cloud, 0.001));
  EXPECT_LT((frame.origin_m - Vector3d(500, 600, 700)).cwiseAbs().maxCoeff(), 10.0);
  EXPECT_EQ(sortIntoGrid(cloud, frame).size(), 101u);
}

}  // namespace
}  // namespace ladar_perception
