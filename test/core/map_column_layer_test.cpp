// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "column_layer_oracle.h"
#include "ladar_perception/map/column_layer.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::ColumnLayerOracle;
using test::pointIn;
using test::TestRandom;

constexpr std::array<ColumnQuantity, 3> kQuantities = {
    ColumnQuantity::kLowest, ColumnQuantity::kGround, ColumnQuantity::kFill};

void insert(VoxelMap* map, const VoxelIndex& voxel) {
  CellId cell = 0;
  map->insert(pointIn(voxel), &cell);
}

void fillAtRandom(VoxelMap* map, int voxels, TestRandom* random) {
  const VoxelIndex& min = map->minCorner();
  const MapShape& shape = map->shape();
  for (int i = 0; i < voxels; ++i) {
    const auto x = static_cast<int32_t>(min.x + random->integer(0, shape.nx - 1));
    const auto y = static_cast<int32_t>(min.y + random->integer(0, shape.ny - 1));
    insert(map, {x, y, static_cast<int32_t>(min.z + random->integer(0, shape.nz - 1))});
  }
}

void update(ColumnLayer* layer, const VoxelMap& map) {
  layer->update(map, [](int, int) {});
}

void expectRight(const ColumnLayer& layer, const VoxelMap& map) {
  const ColumnLayerOracle oracle(map);
  for (int y = 0; y < map.shape().ny; ++y) {
    for (int x = 0; x < map.shape().nx; ++x) {
      ASSERT_EQ(layer.at(x, y), oracle.at(layer.quantity(), layer.radius(), x, y))
          << "(" << x << ", " << y << "), radius " << layer.radius() << ", quantity "
          << static_cast<int>(layer.quantity());
    }
  }
}

class ColumnLayers : public testing::TestWithParam<MapShape> {
 protected:
  TestRandom random_{3};
  VoxelMap map_{GetParam(), 1000};
};

TEST_P(ColumnLayers, AreWhatTheirDefinitionSays) {
  map_.scrollTo({-7, 1000000, -40});
  for (const int voxels : {0, 1, 2, 20, 300, 5000}) {
    map_.clear();
    fillAtRandom(&map_, voxels, &random_);
    for (const ColumnQuantity quantity : kQuantities) {
      // About the powers of two, where windows are put together differently.
      for (const int radius : {1, 2, 3, 4, 7, 8, 15, 16, 31, 100}) {
        ColumnLayer layer(quantity, radius);
        update(&layer, map_);
        ASSERT_NO_FATAL_FAILURE(expectRight(layer, map_)) << voxels << " voxels";
      }
    }
  }
}

TEST_P(ColumnLayers, FollowTheMapWhereverItScrolls) {
  std::vector<ColumnLayer> layers;
  for (const ColumnQuantity quantity : kQuantities) {
    for (const int radius : {1, 5}) layers.emplace_back(quantity, radius);
  }
  VoxelIndex min = {-3, 5, -2};
  for (int step = 0; step < 25; ++step) {
    const auto move = [&](int n) { return static_cast<int32_t>(random_.integer(-n / 2 - 1, n)); };
    min.x += move(GetParam().nx / 2);
    min.y += move(GetParam().ny / 2);
    if (step % 3 == 0) min.z += move(GetParam().nz / 2);
    map_.scrollTo(min);
    fillAtRandom(&map_, step % 2 * map_.columnCount() / 3, &random_);
    for (ColumnLayer& layer : layers) {
      update(&layer, map_);
      ASSERT_NO_FATAL_FAILURE(expectRight(layer, map_)) << "step " << step;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ColumnLayers,
                         testing::Values(MapShape{1, 1, 1}, MapShape{1, 40, 3}, MapShape{37, 1, 9},
                                         MapShape{33, 30, 20}, MapShape{20, 36, 64},
                                         MapShape{24, 17, 65}, MapShape{15, 20, 200}),
                         [](const auto& shape) { return test::shapeName(shape.param); });

/// A section along x of a layer over a map of one row: values from z = 0 as digits, '.' nothing.
std::string section(ColumnQuantity quantity, int radius, const VoxelMap& map) {
  ColumnLayer layer(quantity, radius);
  update(&layer, map);
  std::string picture;
  for (int x = 0; x < map.shape().nx; ++x) {
    const int32_t value = layer.at(x, 0);
    picture += value == ColumnLayer::kNothing ? '.' : static_cast<char>('0' + value);
  }
  return picture;
}

/// Voxels of a drawn section: '#' occupied, the lowest row is z = 0.
VoxelMap mapOf(const std::vector<std::string>& rows) {
  const auto nz = static_cast<int>(rows.size());
  VoxelMap map({static_cast<int>(rows[0].size()), 1, nz}, 1000);
  for (int z = 0; z < nz; ++z) {
    for (int x = 0; x < map.shape().nx; ++x) {
      if (rows[nz - 1 - z][x] == '#') insert(&map, {x, 0, z});
    }
  }
  return map;
}

TEST(ColumnLayer, DrawnFromTheSide) {
  // Level ground, a trunk with a crown over a gap, a step up, and a stretch never seen.
  const VoxelMap map =
      mapOf({"....####................", "....####................", ".....#..................",
             ".....#...#######........", "#####.###.......#.....##"});
  EXPECT_EQ(section(ColumnQuantity::kLowest, 1, map), "000000000011111000...000");
  EXPECT_EQ(section(ColumnQuantity::kGround, 1, map), "0000000001111111000.0000");
  EXPECT_EQ(section(ColumnQuantity::kLowest, 3, map), "000000000000100000000000");
}

TEST(ColumnLayer, AnOpeningIsExactOnASlope) {
  const VoxelMap slope =
      mapOf({"..................##", "...............###..", "............###.....",
             ".........###........", "......###...........", "...###..............",
             "###................."});
  // Up to the last squares that the map holds.
  EXPECT_EQ(section(ColumnQuantity::kGround, 2, slope), "00011122233344455555");
  EXPECT_EQ(section(ColumnQuantity::kLowest, 2, slope), "00000111222333444555");
  EXPECT_EQ(section(ColumnQuantity::kGround, 4, slope), "00011122233344455555");
}

/// Height of the tilted plane over a column.
int32_t planeAt(int x, int y, double along_x, double along_y) {
  return static_cast<int32_t>(std::floor(110.0 + along_x * x + along_y * y));
}

/// Walls 8 columns thick hide the ground; no square of 9 fits on them.
bool isWall(int x) { return x % 20 < 8; }

TEST(ColumnLayer, TheGroundUnderThingsOnEverySlope) {
  constexpr int kSize = 60;
  constexpr int kRadius = 4;
  for (const double along_x : {-0.7, 0.0, 0.31, 1.0}) {
    for (const double along_y : {-1.0, -0.2, 0.0, 0.55}) {
      VoxelMap map({kSize, kSize, 256}, 1000);
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
          const int32_t ground = planeAt(x, y, along_x, along_y);
          insert(&map, {x, y, isWall(x) ? ground + 15 : ground});
          insert(&map, {x, y, ground + 20});
        }
      }
      ColumnLayer ground(ColumnQuantity::kGround, kRadius);
      ColumnLayer lowest(ColumnQuantity::kLowest, kRadius);
      update(&ground, map);
      update(&lowest, map);
      int exact = 0;
      // Squares that the map's edge cuts off fit on a wall.
      for (int y = 2 * kRadius; y < kSize - 2 * kRadius; ++y) {
        for (int x = 2 * kRadius; x < kSize - 2 * kRadius; ++x) {
          const int32_t expected = planeAt(x, y, along_x, along_y);
          const double fall = kRadius * (std::abs(along_x) + std::abs(along_y));
          if (isWall(x)) {
            // That of the ground within reach, not of the wall.
            ASSERT_NEAR(ground.at(x, y), expected, 2 * fall + 1);
          } else {
            ASSERT_EQ(ground.at(x, y), expected) << x << ", " << y;
            ++exact;
          }
          const bool is_open = !isWall(x - kRadius) && !isWall(x + kRadius);
          if (is_open) {
            ASSERT_NEAR(lowest.at(x, y), expected - fall, 1.0);
          }
        }
      }
      ASSERT_GT(exact, 500);
    }
  }
}

TEST(ColumnLayer, FillCountsVoxelsPerOccupiedColumn) {
  VoxelMap map({9, 9, 130}, 1000);
  ColumnLayer layer(ColumnQuantity::kFill, 2);
  update(&layer, map);
  EXPECT_EQ(layer.at(4, 4), ColumnLayer::kNothing);
  for (int z = 0; z < 130; z += 2) insert(&map, {4, 4, z});  // 65 in a column
  insert(&map, {5, 4, 3});
  insert(&map, {6, 6, 129});
  update(&layer, map);
  EXPECT_EQ(layer.at(4, 4), 67 * kFillUnit / 3);
  EXPECT_EQ(layer.at(2, 2), 65 * kFillUnit);
  EXPECT_EQ(layer.at(7, 6), 2 * kFillUnit / 2);
  EXPECT_EQ(layer.at(8, 8), kFillUnit);
  EXPECT_EQ(layer.at(0, 8), ColumnLayer::kNothing);
}

/// A map on the move, and a layer of which all that has been told is kept.
class WatchedLayer {
 public:
  WatchedLayer(ColumnQuantity quantity, int radius, const MapShape& shape)
      : layer_(quantity, radius), shape_(shape) {}

  /// Updates, and compares what is told with what has changed.
  void update(const VoxelMap& map) {
    std::set<std::pair<int, int>> told;
    layer_.update(map, [&](int x, int y) {
      ASSERT_TRUE(told.insert({x, y}).second) << "told twice";
    });
    std::set<std::pair<int, int>> changed;
    for (const ColumnIndex& column : map.changedColumns()) changed.insert({column.x, column.y});
    const ColumnLayerOracle oracle(map);
    std::map<std::pair<int, int>, int32_t> values;
    for (int y = 0; y < shape_.ny; ++y) {
      for (int x = 0; x < shape_.nx; ++x) {
        const std::pair<int, int> world = {map.minCorner().x + x, map.minCorner().y + y};
        const int32_t value = oracle.at(layer_.quantity(), layer_.radius(), x, y);
        ASSERT_EQ(layer_.at(x, y), value);
        values[world] = value;
        const auto before = values_.find(world);
        const bool is_told = told.count({x, y}) > 0;
        if (before == values_.end()) {
          // It was outside: whatever stands in it now the map itself tells of.
          ASSERT_TRUE(!oracle.isOccupied(x, y) || changed.count(world) > 0);
          continue;
        }
        const bool expected = oracle.isOccupied(x, y) && before->second != value;
        ASSERT_EQ(is_told, expected) << "(" << x << ", " << y << ")";
        told_ += is_told ? 1 : 0;
        not_told_ += oracle.isOccupied(x, y) && !is_told ? 1 : 0;
      }
    }
    values_ = std::move(values);
  }
  std::size_t told() const { return told_; }
  std::size_t notTold() const { return not_told_; }

 private:
  ColumnLayer layer_;
  MapShape shape_;
  std::map<std::pair<int, int>, int32_t> values_;  // by world column, at the last update
  std::size_t told_ = 0;
  std::size_t not_told_ = 0;
};

TEST(ColumnLayer, TellsOfEveryOccupiedColumnWithAnotherValueAndOfNoOther) {
  const MapShape shape = {20, 17, 70};
  TestRandom random(9);
  VoxelMap map(shape, 1000);
  VoxelMap part(shape, 1000);  // of its points, to be taken out again
  std::vector<WatchedLayer> layers;
  for (const ColumnQuantity quantity : kQuantities) {
    for (const int radius : {1, 3, 9}) layers.emplace_back(quantity, radius, shape);
  }
  for (int step = 0; step < 400; ++step) {
    if (random.integer(0, 2) == 0) {
      VoxelIndex min = map.minCorner();
      const bool far = random.integer(0, 9) == 0;
      const auto move = [&](int n) { return static_cast<int32_t>(random.integer(-n, n)); };
      min.x += move(far ? 15 : 2);
      min.y += move(far ? 15 : 2);
      if (random.integer(0, 3) == 0) min.z += move(far ? 40 : 2);
      map.scrollTo(min);
      part.scrollTo(min);
    }
    fillAtRandom(&map, static_cast<int>(random.integer(0, 6)), &random);
    TestRandom same_points(step);
    TestRandom same_points_again(step);
    fillAtRandom(&map, 5, &same_points);
    fillAtRandom(&part, 5, &same_points_again);
    if (random.integer(0, 7) == 0) {
      map.subtract(part);
      part.clear();
    }
    if (random.integer(0, 99) == 0) {
      map.clear();
      part.clear();
    }
    // Now and then several changes before it is looked at again.
    if (random.integer(0, 4) == 0) continue;
    for (WatchedLayer& layer : layers) {
      ASSERT_NO_FATAL_FAILURE(layer.update(map)) << "step " << step;
    }
    map.forgetChanges();
  }
  for (const WatchedLayer& layer : layers) {
    EXPECT_GT(layer.told(), 1000U);
    EXPECT_GT(layer.notTold(), 1000U);
  }
}

TEST(ColumnLayer, NothingChangedIsNothingTold) {
  TestRandom random(4);
  VoxelMap map({30, 20, 10}, 1000);
  fillAtRandom(&map, 300, &random);
  for (const ColumnQuantity quantity : kQuantities) {
    ColumnLayer layer(quantity, 6);
    std::size_t told = 0;
    layer.update(map, [&](int, int) { ++told; });
    EXPECT_GT(told, 200U) << "everything is new";
    told = 0;
    layer.update(map, [&](int, int) { ++told; });
    EXPECT_EQ(told, 0U);
    EXPECT_GE(layer.memoryBytes(), 3 * 600 * sizeof(int32_t));
  }
}

}  // namespace
}  // namespace ladar_perception
