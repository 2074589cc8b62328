// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "ladar_perception/saliency/box_sums.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::MapOracle;
using test::pointIn;
using test::TestRandom;
using test::VoxelRecord;

/// A map with its oracle, and how it is filled.
struct Scene {
  Scene(const MapShape& shape, const VoxelIndex& min)
      : map(shape, 1000000), oracle(shape, 1000000) {
    scrollTo(min);
  }
  void scrollTo(const VoxelIndex& min) {
    map.scrollTo(min);
    oracle.scrollTo(min);
  }
  /// A point at a random place of the voxel with these local coordinates.
  void insertLocal(int64_t x, int64_t y, int64_t z) {
    const VoxelIndex& min = map.minCorner();
    const auto place = [&] { return static_cast<int>(random.integer(0, kStepsPerVoxel - 1)); };
    const int sx = place();
    const int sy = place();
    const FixedPoint q = pointIn({static_cast<int32_t>(min.x + x), static_cast<int32_t>(min.y + y),
                                  static_cast<int32_t>(min.z + z)},
                                 sx, sy, place());
    CellId cell = 0;
    map.insert(q, &cell);
    oracle.insert(q);
  }
  void fill(const std::string& kind) {
    const MapShape& s = map.shape();
    const int64_t voxels = int64_t{s.nx} * s.ny * s.nz;
    if (kind == "random" || kind == "dense") {
      const int64_t count = kind == "dense" ? 4 * voxels : voxels / 12;
      for (int64_t i = 0; i < count; ++i) {
        const int64_t x = random.integer(0, s.nx - 1);
        const int64_t y = random.integer(0, s.ny - 1);
        insertLocal(x, y, random.integer(0, s.nz - 1));
      }
    } else if (kind == "planar") {
      for (int x = 0; x < s.nx; ++x) {
        for (int y = 0; y < s.ny; ++y) insertLocal(x, y, (x + 2 * y) % s.nz / 3);
      }
    } else if (kind == "linear") {
      for (int z = 0; z < s.nz; ++z) insertLocal(s.nx / 3, s.ny - 1, z);
      for (int x = 0; x < s.nx; ++x) insertLocal(x, x * s.ny / s.nx, s.nz - 1);
    } else if (kind == "single") {
      insertLocal(s.nx - 1, 0, s.nz / 2);
    }
  }

  TestRandom random{7};
  VoxelMap map;
  MapOracle oracle;
};

std::vector<Moments> slidingSums(const VoxelMap& map, int r, int threads) {
  VoxelOrder order;
  order.update(map);
  ThreadPool pool(threads);
  SlidingBoxSums box_sums(r);
  std::vector<Moments> sums;
  box_sums.compute(map, order, &pool, &sums);
  return sums;
}

/// Compares with look-ups of k^3 voxels around every occupied voxel, in the map's order.
void expectBruteForce(const Scene& scene, int r) {
  const std::vector<Moments> sums = slidingSums(scene.map, r, 1);
  const std::vector<VoxelRecord> records = scene.oracle.list();
  ASSERT_EQ(sums.size(), records.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    ASSERT_EQ(sums[i], scene.oracle.boxSum(records[i].voxel, r))
        << "r " << r << ", row " << i << ", " << testing::PrintToString(records[i].voxel);
  }
}

class BoxSums : public testing::TestWithParam<std::tuple<std::string, MapShape>> {};

TEST_P(BoxSums, EqualTheBruteForceForEveryK) {
  const auto& [kind, shape] = GetParam();
  Scene scene(shape, {-3, 1000000, -2});
  scene.fill(kind);
  for (int r = 0; r <= 6; ++r) ASSERT_NO_FATAL_FAILURE(expectBruteForce(scene, r));
}

TEST_P(BoxSums, EqualTheBruteForceAfterScrolls) {
  const auto& [kind, shape] = GetParam();
  Scene scene(shape, {0, 0, 0});
  const VoxelIndex stops[] = {{2, -1, 0}, {3, 1, -1}, {-1, -2, 1}};
  for (const VoxelIndex& stop : stops) {
    scene.fill(kind);
    scene.scrollTo(stop);
    for (const int r : {1, 4}) ASSERT_NO_FATAL_FAILURE(expectBruteForce(scene, r));
  }
}

TEST_P(BoxSums, AnyNumberOfThreadsGivesTheSameBits) {
  const auto& [kind, shape] = GetParam();
  Scene scene(shape, {5, -3, 0});
  scene.fill(kind);
  for (const int r : {1, 4, 6}) {
    const std::vector<Moments> one = slidingSums(scene.map, r, 1);
    for (const int threads : {2, 3, 7, 16}) {
      ASSERT_EQ(slidingSums(scene.map, r, threads) == one, true) << threads << " threads";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Maps, BoxSums,
    testing::Combine(testing::Values("random", "planar", "linear", "dense", "empty", "single"),
                     testing::Values(MapShape{12, 10, 9}, MapShape{7, 5, 3}, MapShape{6, 5, 64},
                                     MapShape{5, 4, 130}, MapShape{1, 1, 1})),
    [](const auto& maps) {
      return std::get<0>(maps.param) + "_" + test::shapeName(std::get<1>(maps.param));
    });

TEST(BoxSumsReuse, BuffersOfEarlierMapsLeaveNoTrace) {
  VoxelOrder order;
  ThreadPool pool(2);
  SlidingBoxSums box_sums(2);
  std::vector<Moments> sums;
  Scene scene({9, 9, 70}, {0, 0, 0});
  for (int step = 0; step < 12; ++step) {
    scene.fill(step % 3 == 0 ? "dense" : "random");
    scene.scrollTo({step, -2 * step, step % 2});
    order.update(scene.map);
    box_sums.compute(scene.map, order, &pool, &sums);
    ASSERT_EQ(sums == slidingSums(scene.map, 2, 1), true) << step;
    scene.scrollTo({step + 7, -2 * step, 0});
  }
  scene.scrollTo({1000, 0, 0});
  order.update(scene.map);
  box_sums.compute(scene.map, order, &pool, &sums);
  EXPECT_TRUE(sums.empty());
  EXPECT_GT(box_sums.memoryBytes(), 0U);
}

TEST(VoxelOrder, ListsVoxelsAndFindsTheirRows) {
  Scene scene({6, 5, 70}, {-4, 9, -30});
  scene.fill("random");
  scene.scrollTo({-2, 8, -29});
  VoxelOrder order;
  order.update(scene.map);
  std::vector<VoxelIndex> voxels;
  order.listVoxels(scene.map, &voxels);
  const std::vector<VoxelRecord> records = scene.oracle.list();
  ASSERT_EQ(order.rows, records.size());
  ASSERT_EQ(voxels.size(), records.size());
  for (std::size_t row = 0; row < records.size(); ++row) {
    EXPECT_EQ(voxels[row], records[row].voxel);
    const FixedPoint q = pointIn(voxels[row]);
    CellId cell = 0;
    scene.map.insert(q, &cell);
    EXPECT_EQ(order.rowOf(scene.map, cell), row);
    const int y = voxels[row].y - scene.map.minCorner().y;
    EXPECT_GE(row, order.row_begin[y]);
    EXPECT_LT(row, order.row_begin[y + 1]);
  }
}

}  // namespace
}  // namespace ladar_perception
