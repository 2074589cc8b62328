// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "box_sum_scene.h"
#include "ladar_perception/saliency/box_stack.h"
#include "ladar_perception/util/thread_pool.h"
#include "map_oracle.h"

namespace ladar_perception {
namespace {

using test::boxSumByLookUp;
using test::BoxSumScene;
using test::TestRandom;

int radiusOf(const BoxStack& stack) { return stack[0].box.radius_xy; }

/// Cubes with `weights` at distance 0, 1, ..., none of them for nothing, the widest first.
void expectWeights(const BoxStack& stack, const std::vector<uint32_t>& weights) {
  ASSERT_FALSE(stack.empty());
  EXPECT_EQ(radiusOf(stack) + std::size_t{1}, weights.size());
  for (std::size_t i = 0; i < stack.size(); ++i) {
    EXPECT_EQ(stack[i].box.radius_xy, stack[i].box.radius_z);
    EXPECT_GT(stack[i].weight, 0U);
    if (i > 0) {
      EXPECT_LT(stack[i].box.radius_xy, stack[i - 1].box.radius_xy);
    }
  }
  for (std::size_t d = 0; d < weights.size(); ++d) {
    EXPECT_EQ(weightAt(stack, static_cast<int>(d)), weights[d]) << "distance " << d;
  }
  EXPECT_EQ(weightAt(stack, static_cast<int>(weights.size())), 0U);
  EXPECT_EQ(weightAt(stack, 1000), 0U);
}

TEST(MakeBoxStack, GivesEveryDistanceItsWeight) {
  expectWeights(makeBoxStack({4.0, 4.0, 2.0, 1.0, 1.0}, 4), {4, 4, 2, 1, 1});
  expectWeights(makeBoxStack({1.0, 0.5, 0.25}, 8), {8, 4, 2});
  // Rounded to the nearest level, but never away.
  expectWeights(makeBoxStack({10.0, 6.3, 6.2, 0.1}, 4), {4, 3, 2, 1});
  expectWeights(makeBoxStack({1.0, 1e-9}, 100), {100, 1});
}

TEST(MakeBoxStack, HasOneBoxPerStep) {
  EXPECT_EQ(makeBoxStack({4.0, 4.0, 2.0, 1.0, 1.0}, 4).size(), 3U);
  EXPECT_EQ(makeBoxStack({3.0, 3.0, 3.0}, 3).size(), 1U);
  EXPECT_EQ(makeBoxStack({3.0, 2.99, 2.98}, 4).size(), 1U);
  EXPECT_EQ(makeBoxStack({4.0, 3.0, 2.0, 1.0}, 4).size(), 4U);
}

TEST(MakeBoxStack, OfOneLevelIsABox) {
  const BoxStack stack = makeBoxStack({5.0, 2.0, 0.01}, 1);
  ASSERT_EQ(stack.size(), 1U);
  expectWeights(stack, {1, 1, 1});
}

TEST(MakeBoxStack, OfOneWeightIsTheVoxelItself) {
  expectWeights(makeBoxStack({0.3}, 1), {1});
  expectWeights(makeBoxStack({0.3}, 7), {7});
  EXPECT_EQ(makeBoxStack({0.3}, 7).size(), 1U);
}

TEST(MakeBoxStack, RoundsAnyWeightsThatDoNotGrow) {
  TestRandom random(1);
  for (int round = 0; round < 500; ++round) {
    std::vector<double> weights;
    for (int64_t d = random.integer(0, 8); d >= 0; --d) weights.push_back(random.real(0.001, 3.0));
    std::sort(weights.rbegin(), weights.rend());
    const auto levels = static_cast<int>(random.integer(1, 12));
    std::vector<uint32_t> expected;
    for (const double weight : weights) {
      const long level = std::lround(weight / weights[0] * levels);
      expected.push_back(static_cast<uint32_t>(std::max(level, 1L)));
    }
    const BoxStack stack = makeBoxStack(weights, levels);
    ASSERT_NO_FATAL_FAILURE(expectWeights(stack, expected));
    const auto steps = std::unique(expected.begin(), expected.end()) - expected.begin();
    ASSERT_EQ(stack.size(), static_cast<std::size_t>(steps));
  }
}

TEST(GaussianBoxStack, IsTheDocumentedOneForRadiusFour) {
  expectWeights(gaussianBoxStack(4), {4, 4, 2, 1, 1});
}

TEST(GaussianBoxStack, IsWithinHalfALevelOfTheGaussian) {
  for (int radius = 1; radius <= 6; ++radius) {
    const BoxStack stack = gaussianBoxStack(radius);
    EXPECT_EQ(radiusOf(stack), radius);
    EXPECT_EQ(weightAt(stack, 0), 4U);
    for (int d = 0; d <= radius; ++d) {
      const double gaussian = 4.0 * std::exp(-2.0 * d * d / (radius * radius));
      EXPECT_NEAR(weightAt(stack, d), gaussian, 0.5) << "radius " << radius << ", distance " << d;
      EXPECT_GT(weightAt(stack, d), 0U) << "radius " << radius << ", distance " << d;
    }
    std::vector<uint32_t> weights;
    for (int d = 0; d <= radius; ++d) weights.push_back(weightAt(stack, d));
    expectWeights(stack, weights);
  }
}

TEST(WeightAt, OfABoxThatIsNoCubeIsThatOfTheCubeInIt) {
  const BoxStack stack = {{{5, 2}, 3}, {{1, 4}, 2}};
  const std::vector<uint32_t> expected = {5, 5, 3, 0};
  for (int d = 0; d < 4; ++d) EXPECT_EQ(weightAt(stack, d), expected[d]) << d;
}

__extension__ typedef __int128 Int128;

/// The largest sums: points at the outer corners of the voxels of part of the support volume.
class FullSupport {
 public:
  FullSupport(const BoxStack& stack, const VoxelIndex& center) : stack_(stack), center_(center) {}

  /// `n` points at the corner away from the centre of every voxel whose offset `takes`.
  void fill(uint32_t n, const std::function<bool(const VoxelIndex&)>& takes) {
    sums_.assign(stack_.size(), Moments());
    exact_ = {};
    const int r_xy = widest([](const SupportBox& box) { return box.radius_xy; });
    const int r_z = widest([](const SupportBox& box) { return box.radius_z; });
    for (int x = -r_xy; x <= r_xy; ++x) {
      for (int y = -r_xy; y <= r_xy; ++y) {
        for (int z = -r_z; z <= r_z; ++z) {
          if (takes({x, y, z})) fillVoxel({x, y, z}, n);
        }
      }
    }
  }
  void expectExact() const {
    const CenteredMoments m = weightedSum(stack_, sums_.data()).about(centerOf(center_));
    const int64_t found[10] = {m.n, m.x, m.y, m.z, m.xx, m.xy, m.xz, m.yy, m.yz, m.zz};
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(Int128{found[i]} == exact_[i]) << "moment " << i;
  }
  double greatestFirstMoment() const {
    double greatest = 0.0;
    for (int i = 1; i <= 3; ++i) {
      greatest = std::max(greatest, std::abs(static_cast<double>(exact_[i])));
    }
    return greatest;
  }

 private:
  template <typename Radius>
  int widest(const Radius& radius) const {
    int result = 0;
    for (const WeightedBox& weighted : stack_) result = std::max(result, radius(weighted.box));
    return result;
  }
  void fillVoxel(const VoxelIndex& offset, uint32_t n) {
    const auto corner = [](int32_t at) { return at < 0 ? int64_t{0} : kStepsPerVoxel - 1; };
    const VoxelIndex voxel = {center_.x + offset.x, center_.y + offset.y, center_.z + offset.z};
    const FixedPoint q = {voxel.x * kStepsPerVoxel + corner(offset.x),
                          voxel.y * kStepsPerVoxel + corner(offset.y),
                          voxel.z * kStepsPerVoxel + corner(offset.z)};
    Moments full;
    for (uint32_t i = 0; i < n; ++i) full.add(q);
    const FixedPoint c = centerOf(center_);
    const Int128 x = q.x - c.x;
    const Int128 y = q.y - c.y;
    const Int128 z = q.z - c.z;
    const Int128 moments[10] = {1, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z};
    for (std::size_t i = 0; i < stack_.size(); ++i) {
      const SupportBox& box = stack_[i].box;
      if (std::max(std::abs(offset.x), std::abs(offset.y)) > box.radius_xy) continue;
      if (std::abs(offset.z) > box.radius_z) continue;
      sums_[i] += full;
      for (int j = 0; j < 10; ++j) exact_[j] += moments[j] * n * stack_[i].weight;
    }
  }

  BoxStack stack_;
  VoxelIndex center_;
  std::vector<Moments> sums_;
  std::array<Int128, 10> exact_{};  // n, x, y, z, xx, xy, xz, yy, yz, zz
};

const std::vector<BoxStack>& someStacks() {
  static const std::vector<BoxStack> kStacks = {{{cube(0), 1}},
                                                {{cube(1), 1}},
                                                {{cube(4), 1}},
                                                {{cube(2), 7}},
                                                gaussianBoxStack(2),
                                                gaussianBoxStack(4),
                                                makeBoxStack({9.0, 5.0, 3.0, 1.0}, 9),
                                                {{{3, 1}, 1}, {{1, 2}, 4}},
                                                {{{1, 9}, 3}, {{2, 0}, 2}, {cube(0), 100}}};
  return kStacks;
}

TEST(MaxPointsPerVoxel, KeepsWeightedSumsExactAtTheirWorst) {
  const std::vector<std::function<bool(const VoxelIndex&)>> parts = {
      [](const VoxelIndex&) { return true; },
      [](const VoxelIndex& v) { return v.x < 0; },
      [](const VoxelIndex& v) { return v.x >= 0; },
      [](const VoxelIndex& v) { return v.y < 0; },
      [](const VoxelIndex& v) { return v.y >= 0 && v.z < 0; },
      [](const VoxelIndex& v) { return v.z < 0; },
      [](const VoxelIndex& v) { return v.z >= 0; },
      [](const VoxelIndex& v) { return v.x < 0 && v.y >= 0; },
      [](const VoxelIndex& v) { return v.x < 0 && v.y < 0 && v.z < 0; },
      [](const VoxelIndex& v) { return v.x == v.y && v.y == v.z; },
  };
  for (const BoxStack& stack : someStacks()) {
    const uint32_t most = maxPointsPerVoxel(stack);
    ASSERT_GT(most, 0U);
    for (const VoxelIndex& center : {VoxelIndex{0, 0, 0}, {1000000000, -1000000000, -7}}) {
      FullSupport support(stack, center);
      for (std::size_t part = 0; part < parts.size(); ++part) {
        support.fill(most, parts[part]);
        ASSERT_NO_FATAL_FAILURE(support.expectExact())
            << "radius " << radiusOf(stack) << ", part " << part;
        ASSERT_LT(support.greatestFirstMoment(), 0x1p31);
      }
    }
  }
}

TEST(MaxPointsPerVoxel, OfASingleBoxIsThatOfItsRadius) {
  for (int radius = 0; radius <= 6; ++radius) {
    EXPECT_EQ(maxPointsPerVoxel(BoxStack{{cube(radius), 1}}), maxPointsPerVoxel(radius)) << radius;
  }
}

TEST(MaxPointsPerVoxel, FallsWithTheWeight) {
  for (const uint32_t weight : {2U, 3U, 10U}) {
    const uint32_t most = maxPointsPerVoxel(BoxStack{{cube(4), weight}});
    EXPECT_LE(most, maxPointsPerVoxel(4) / weight);
    EXPECT_GE(most + 1, maxPointsPerVoxel(4) / weight);
  }
  EXPECT_LT(maxPointsPerVoxel(gaussianBoxStack(4)), maxPointsPerVoxel(4));
}

TEST(Moments, TimesAWeightAreThoseOfAsManyPoints) {
  TestRandom random(2);
  for (const int64_t away : {int64_t{0}, int64_t{256000000000}, int64_t{-256000000000}}) {
    for (const uint32_t weight : {0U, 1U, 2U, 3U, 17U, 1000U}) {
      Moments once;
      Moments often;
      for (int i = 0; i < 20; ++i) {
        const int64_t x = away + random.integer(-1000, 1000);
        const int64_t y = -away + random.integer(-1000, 1000);
        const FixedPoint q = {x, y, random.integer(-1000, 1000)};
        once.add(q);
        for (uint32_t j = 0; j < weight; ++j) often.add(q);
      }
      once *= weight;
      EXPECT_TRUE(once == often) << weight;
    }
  }
}

/// Keeps what BoxStackSums gives, by voxel.
class StackCollector {
 public:
  using Place = std::array<int, 3>;  // local y, x, z
  using Sums = std::map<Place, std::vector<Moments>>;

  StackCollector(const VoxelMap& map, std::size_t boxes) : map_(map), boxes_(boxes) {}

  void accept(std::size_t slot, int x, int y, int z, const Moments* sums) {
    const VoxelIndex& min = map_.minCorner();
    const VoxelIndex voxel = {min.x + x, min.y + y, min.z + z};
    EXPECT_EQ(&map_.record(slot), map_.find(voxel)) << testing::PrintToString(voxel);
    const Place at = {y, x, z};
    EXPECT_LT(last_, at) << "row by row, along x and by ascending z";
    last_ = at;
    sums_[at].assign(sums, sums + boxes_);
  }
  Sums take() { return std::move(sums_); }

 private:
  const VoxelMap& map_;
  std::size_t boxes_;
  Place last_ = {-1, -1, -1};
  Sums sums_;
};

ColumnSet allColumns(const VoxelMap& map) {
  ColumnSet columns;
  columns.assignAll(map.shape().nx, map.shape().ny);
  return columns;
}

/// One column in `one_in`, occupied or not.
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

/// The sums of every voxel of the map by look-ups.
StackCollector::Sums sumsByLookUp(const BoxSumScene& scene, const std::vector<SupportBox>& boxes) {
  StackCollector::Sums sums;
  const VoxelIndex& min = scene.map.minCorner();
  scene.map.forEachVoxel([&](const VoxelIndex& v, std::size_t /*slot*/) {
    for (const SupportBox& box : boxes) {
      sums[{v.y - min.y, v.x - min.x, v.z - min.z}].push_back(
          boxSumByLookUp<Moments>(scene.oracle, v, box));
    }
  });
  return sums;
}

StackCollector::Sums only(const ColumnSet& columns, const StackCollector::Sums& all) {
  StackCollector::Sums some;
  for (const auto& [place, sums] : all) {
    if (columns.contains(place[1], place[0])) some[place] = sums;
  }
  return some;
}

const std::vector<std::vector<SupportBox>>& someBoxes() {
  static const std::vector<std::vector<SupportBox>> kBoxes = {
      {cube(4), cube(2), cube(1)},
      {{3, 1}, {1, 3}, {0, 0}},  // some wider along z, some across
      {{2, 70}, {0, 1}},
      {cube(2)},
      {cube(1), cube(1)}};
  return kBoxes;
}

class StackSums : public testing::TestWithParam<std::tuple<std::string, MapShape>> {};

TEST_P(StackSums, EqualTheLookUpsForEveryBox) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {-3, 1000000, -2});
  scene.fill(kind);
  for (const auto& boxes : someBoxes()) {
    const StackCollector::Sums expected = sumsByLookUp(scene, boxes);
    ASSERT_EQ(expected.size(), scene.map.occupied());
    BoxStackSums<Moments> sums(boxes);
    for (const int one_in : {1, 1, 3, 20}) {  // used again, with what is left in its buffers
      const ColumnSet columns = one_in == 1 ? allColumns(scene.map) : someColumns(&scene, one_in);
      StackCollector collector(scene.map, boxes.size());
      sums.compute(scene.map, columns, 0, shape.ny, collector);
      ASSERT_EQ(collector.take() == only(columns, expected), true)
          << boxes.size() << " boxes, one column in " << one_in;
    }
    EXPECT_GT(sums.memoryBytes(), 0U);
  }
}

TEST_P(StackSums, RowsCanBeSharedInAnyWay) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {5, -3, 0});
  scene.fill(kind);
  const std::vector<SupportBox> boxes = {cube(3), {1, 2}, cube(0)};
  const StackCollector::Sums all = sumsByLookUp(scene, boxes);
  for (const int shares : {2, 3, 7, 16}) {
    const ColumnSet columns = shares == 3 ? someColumns(&scene, 4) : allColumns(scene.map);
    const std::vector<int> rows = shareRows(scene.map, columns, shares);
    ThreadPool pool(shares);
    std::vector<StackCollector> collectors(shares, StackCollector(scene.map, boxes.size()));
    pool.run([&](int share) {
      BoxStackSums<Moments> sums(boxes);
      sums.compute(scene.map, columns, rows[share], rows[share + 1], collectors[share]);
    });
    StackCollector::Sums together;
    for (StackCollector& collector : collectors) together.merge(collector.take());
    ASSERT_EQ(together == only(columns, all), true) << shares << " shares";
  }
}

TEST_P(StackSums, WeightedAreThoseOfPointsInsertedAsOften) {
  const auto& [kind, shape] = GetParam();
  BoxSumScene scene(shape, {7, 7, -70});
  scene.fill(kind);
  for (const BoxStack& stack : {gaussianBoxStack(3), makeBoxStack({9.0, 5.0, 1.0}, 9)}) {
    std::vector<SupportBox> boxes;
    for (const WeightedBox& weighted : stack) boxes.push_back(weighted.box);
    BoxStackSums<Moments> sums(boxes);
    StackCollector collector(scene.map, boxes.size());
    sums.compute(scene.map, allColumns(scene.map), 0, shape.ny, collector);
    const VoxelIndex& min = scene.map.minCorner();
    const int r = radiusOf(stack);
    for (const auto& [place, found] : collector.take()) {
      const VoxelIndex center = {min.x + place[1], min.y + place[0], min.z + place[2]};
      Moments expected;
      for (int dx = -r; dx <= r; ++dx) {
        for (int dy = -r; dy <= r; ++dy) {
          for (int dz = -r; dz <= r; ++dz) {
            const int distance = std::max({std::abs(dx), std::abs(dy), std::abs(dz)});
            const Moments* record =
                scene.oracle.find({center.x + dx, center.y + dy, center.z + dz});
            if (record == nullptr) continue;
            for (uint32_t i = 0; i < weightAt(stack, distance); ++i) expected += *record;
          }
        }
      }
      ASSERT_EQ(weightedSum(stack, found.data()) == expected, true)
          << testing::PrintToString(center);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Maps, StackSums,
                         testing::Combine(testing::Values("random", "planar", "border", "empty"),
                                          testing::ValuesIn(test::boxSumSceneShapes())),
                         [](const auto& maps) {
                           return std::get<0>(maps.param) + "_" +
                                  test::shapeName(std::get<1>(maps.param));
                         });

TEST(StackSumsReuse, OtherMapsLeaveNoTrace) {
  const std::vector<SupportBox> boxes = {cube(2), {1, 1}};
  BoxStackSums<Moments> sums(boxes);
  for (const MapShape& shape :
       {MapShape{9, 9, 70}, {9, 4, 70}, {9, 14, 5}, {80, 6, 5}, {3, 4, 130}, {9, 9, 70}}) {
    BoxSumScene scene(shape, {3, -4, 5});
    scene.fill("random");
    for (int step = 0; step < 3; ++step) {
      StackCollector collector(scene.map, boxes.size());
      sums.compute(scene.map, allColumns(scene.map), 0, shape.ny, collector);
      ASSERT_EQ(collector.take() == sumsByLookUp(scene, boxes), true)
          << test::shapeName(shape) << ", step " << step;
      scene.scrollTo({3 + 2 * step, -4 + step, 5 - step});
      scene.insertSomewhere(40);
    }
  }
}

}  // namespace
}  // namespace ladar_perception
