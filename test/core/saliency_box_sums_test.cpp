// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "box_sum_scene.h"
#include "ladar_perception/saliency/box_sums.h"
#include "ladar_perception/util/thread_pool.h"
#include "map_oracle.h"

namespace ladar_perception {
namespace {

using test::boxSumByLookUp;
using test::BoxSumScene;

/// A sum that is no Moments: how many voxels are occupied.
struct OccupiedCount {
  OccupiedCount& operator+=(const Moments& /*record*/) { return ++voxels, *this; }
  OccupiedCount& operator-=(const Moments& /*record*/) { return --voxels, *this; }
  OccupiedCount& operator+=(const OccupiedCount& other) { return voxels += other.voxels, *this; }
  OccupiedCount& operator-=(const OccupiedCount& other) { return voxels -= other.voxels, *this; }
  bool operator==(const OccupiedCount& other) const { return voxels == other.voxels; }
  uint32_t count() const { return voxels; }

  uint32_t voxels = 0;
};

/// Keeps the sums by voxel. All of them are written to the same place: each has to be there by the
/// next call.
template <typename Sum>
class Collector {
 public:
  using Place = std::array<int, 3>;  // local y, x, z
  using Sums = std::map<Place, Sum>;

  explicit Collector(const VoxelMap& map) : map_(map) {}

  Sum& place(std::size_t slot, int x, int y, int z) {
    keepLast();
    const VoxelIndex& min = map_.minCorner();
    const VoxelIndex voxel = {min.x + x, min.y + y, min.z + z};
    EXPECT_EQ(&map_.record(slot), map_.find(voxel)) << testing::PrintToString(voxel);
    const Place at = {y, x, z};
    EXPECT_LT(at_, at) << "row by row, along x and by ascending z";
    at_ = at;
    return sum_;
  }
  Sums take() {
    keepLast();
    at_ = kNone;
    return std::move(sums_);
  }

 private:
  static constexpr Place kNone = {-1, -1, -1};

  void keepLast() {
    if (at_ != kNone) sums_[at_] = sum_;
  }

  const VoxelMap& map_;
  Place at_ = kNone;
  Sum sum_;
  Sums sums_;
};

template <typename Sum>
typename Collector<Sum>::Sums expectedIn(const BoxSumScene& scene, const ColumnSet& columns,
                                         const SupportBox& box) {
  typename Collector<Sum>::Sums expected;
  const VoxelIndex& min = scene.map.minCorner();
  scene.map.forEachVoxel([&](const VoxelIndex& v, std::size_t /*slot*/) {
    if (!columns.contains(v.x - min.x, v.y - min.y)) return;
    expected[{v.y - min.y, v.x - min.x, v.z - min.z}] = boxSumByLookUp<Sum>(scene.oracle, v, box);
  });
  return expected;
}

ColumnSet allColumns(const VoxelMap& map) {
  ColumnSet columns;
  columns.assignAll(map.shape().nx, map.shape().ny);
  return columns;
}

/// Some columns, occupied or not: one in `one_in`.
ColumnSet someColumns(BoxSumScene* scene, int one_in) {
  const MapShape& shape = scene->map.shape();
  ColumnSet some;
  some.resize(shape.nx, shape.ny);
  for (int y = 0; y < shape.ny; ++y) {
    for (int x = 0; x < shape.nx; ++x) {
      if (scene->random.integer(1, one_in) == 1) some.add(x, y);
    }
  }
  return some;
}

template <typename Sum>
void expectIn(const BoxSumScene& scene, const ColumnSet& columns, SlidingBoxSums<Sum>* box_sums) {
  Collector<Sum> collector(scene.map);
  box_sums->compute(scene.map, columns, 0, scene.map.shape().ny, collector);
  ASSERT_EQ(collector.take() == expectedIn<Sum>(scene, columns, box_sums->box()), true)
      << "box " << box_sums->box().radius_xy << " " << box_sums->box().radius_z << ", "
      << columns.size() << " columns";
}

class BoxSums : public testing::TestWithParam<std::tuple<std::string, MapShape>> {};

TEST_P(BoxSums, EqualTheLookUpsForEveryK) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {-3, 1000000, -2});
  scene.fill(kind);
  for (int r = 0; r <= 6; ++r) {
    SlidingBoxSums<Moments> box_sums(cube(r));
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, allColumns(scene.map), &box_sums));
  }
}

TEST_P(BoxSums, EqualTheLookUpsAfterScrolls) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {0, 0, 0});
  SlidingBoxSums<Moments> near(cube(1));
  SlidingBoxSums<Moments> far(cube(4));
  const VoxelIndex stops[] = {{2, -1, 0}, {3, 1, -1}, {-1, -2, 1}};
  for (const VoxelIndex& stop : stops) {
    scene.fill(kind);
    scene.scrollTo(stop);
    const ColumnSet columns = allColumns(scene.map);
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, columns, &near));
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, columns, &far));
  }
}

TEST_P(BoxSums, OfPartOfTheColumnsEqualTheLookUpsThere) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {11, -5, -20});
  scene.fill(kind);
  for (const int r : {0, 1, 3}) {
    SlidingBoxSums<Moments> box_sums(cube(r));
    for (const int one_in : {2, 8, 40}) {
      const ColumnSet some = someColumns(&scene, one_in);
      ASSERT_NO_FATAL_FAILURE(expectIn(scene, some, &box_sums));
    }
  }
}

TEST_P(BoxSums, BoxesNeedNotBeCubes) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {-40, 8, 3});
  scene.fill(kind);
  for (const SupportBox& box : {SupportBox{1, 3}, {3, 0}, {0, 2}, {2, 20}, {5, 1}, {2, 200}}) {
    SlidingBoxSums<Moments> box_sums(box);
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, allColumns(scene.map), &box_sums));
    const ColumnSet some = someColumns(&scene, 3);
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, some, &box_sums));
  }
}

TEST_P(BoxSums, AnythingAdditiveCanBeSummed) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {1, 2, 3});
  scene.fill(kind);
  for (const SupportBox& box : {cube(1), cube(4), SupportBox{2, 5}}) {
    SlidingBoxSums<OccupiedCount> box_sums(box);
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, allColumns(scene.map), &box_sums));
    const ColumnSet some = someColumns(&scene, 3);
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, some, &box_sums));
  }
}

TEST_P(BoxSums, RowsCanBeSharedInAnyWay) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {5, -3, 0});
  scene.fill(kind);
  const ColumnSet columns = allColumns(scene.map);
  const auto expected = expectedIn<Moments>(scene, columns, cube(2));
  for (const int shares : {1, 2, 3, 7, 16}) {
    const std::vector<int> rows = shareRows(scene.map, columns, shares);
    ASSERT_EQ(rows.size(), shares + std::size_t{1});
    ThreadPool pool(shares);
    std::vector<Collector<Moments>> collectors(shares, Collector<Moments>(scene.map));
    pool.run([&](int share) {
      SlidingBoxSums<Moments> box_sums(cube(2));
      box_sums.compute(scene.map, columns, rows[share], rows[share + 1], collectors[share]);
    });
    Collector<Moments>::Sums together;
    for (auto& collector : collectors) together.merge(collector.take());
    ASSERT_EQ(together == expected, true) << shares << " shares";
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, BoxSums,
                         testing::Combine(testing::ValuesIn(test::boxSumSceneKinds()),
                                          testing::ValuesIn(test::boxSumSceneShapes())),
                         [](const auto& maps) {
                           return std::get<0>(maps.param) + "_" +
                                  test::shapeName(std::get<1>(maps.param));
                         });

TEST(BoxSumsReuse, BuffersOfEarlierMapsLeaveNoTrace) {
  SlidingBoxSums<Moments> box_sums(cube(2));
  BoxSumScene scene({9, 9, 70}, {0, 0, 0});
  for (int step = 0; step < 12; ++step) {
    scene.fill(step % 4 == 0 ? "planar" : "random");
    scene.scrollTo({step, -2 * step, step % 2});
    const ColumnSet columns = step % 3 == 0 ? someColumns(&scene, 4) : allColumns(scene.map);
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, columns, &box_sums)) << "step " << step;
    scene.scrollTo({step + 7, -2 * step, 0});
  }
  scene.scrollTo({1000, 0, 0});
  ASSERT_NO_FATAL_FAILURE(expectIn(scene, allColumns(scene.map), &box_sums));
  EXPECT_GT(box_sums.memoryBytes(), 0U);
}

TEST(BoxSumsReuse, MapsOfOtherShapesLeaveNoTrace) {
  SlidingBoxSums<Moments> box_sums(cube(2));
  for (const MapShape& shape : {MapShape{9, 9, 70},
                                {9, 4, 70},
                                {9, 14, 70},
                                {9, 14, 5},
                                {80, 14, 5},
                                {3, 4, 130},
                                {9, 9, 70}}) {
    BoxSumScene scene(shape, {3, -4, 5});
    scene.fill("random");
    ASSERT_NO_FATAL_FAILURE(expectIn(scene, allColumns(scene.map), &box_sums))
        << test::shapeName(shape);
  }
}

TEST(ShareRows, SplitsTheVoxelsOfTheColumnsIntoEqualParts) {
  BoxSumScene scene({20, 60, 10}, {0, 0, 0});
  scene.insertSomewhere(500);
  for (int i = 0; i < 3000; ++i) {  // most of them in a few rows
    const int64_t x = scene.random.integer(0, 19);
    const int64_t y = scene.random.integer(40, 49);
    scene.insertLocal(x, y, scene.random.integer(0, 9));
  }
  const ColumnSet some = someColumns(&scene, 2);
  std::vector<int> voxels_in_row(60, 0);
  for (const auto& [place, sum] : expectedIn<OccupiedCount>(scene, some, cube(0))) {
    voxels_in_row[place[0]] += static_cast<int>(sum.count());
  }
  int total = 0;
  for (const int voxels : voxels_in_row) total += voxels;
  const int largest = *std::max_element(voxels_in_row.begin(), voxels_in_row.end());
  for (const int shares : {1, 2, 3, 5, 100}) {
    const std::vector<int> rows = shareRows(scene.map, some, shares);
    ASSERT_EQ(rows.size(), shares + std::size_t{1});
    EXPECT_EQ(rows.front(), 0);
    EXPECT_EQ(rows.back(), 60);
    for (int share = 0; share < shares; ++share) {
      ASSERT_LE(rows[share], rows[share + 1]);
      int voxels = 0;
      for (int y = rows[share]; y < rows[share + 1]; ++y) voxels += voxels_in_row[y];
      EXPECT_LE(voxels, total / shares + largest + 1) << share << " of " << shares;
    }
  }
}

}  // namespace
}  // namespace ladar_perception
