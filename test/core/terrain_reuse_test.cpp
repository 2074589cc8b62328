// SPDX-License-Identifier: BSD-3-Clause
// Temporal re-use: only what a scan can have changed is computed anew, and yet what is known of
// every voxel is, after every scan and bit by bit, what computing all of them anew gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "random_drive.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::DriveCase;
using test::handModel;
using test::MixedScene;
using test::modelFor;
using test::processAt;
using test::smallMap;

std::vector<DriveCase> driveCases() {
  std::vector<DriveCase> cases;
  const auto add = [&](const std::string& name) -> TerrainConfig& {
    cases.push_back({name, smallMap(), {}, true});
    return cases.back().config;
  };
  add("plain");
  add("threads").threads = 3;
  add("not_smoothed").smooth_labels = false;
  add("small_support").support_radius_voxels = 2;
  add("kernel").support_kernel = "gaussian";
  add("forget_scans").forget_after_scans = 40;
  add("forget_at_once").forget_after_scans = 1;
  cases.back().reuses = false;
  add("forget_seconds").forget_after_s = 3.0;
  add("tall").map_size_z_m = 7.0;
  add("very_tall").map_size_z_m = 13.0;
  TerrainConfig& fine = add("fine_voxels");
  fine.voxel_size_m = 0.025;
  fine.map_size_x_m = 2.0;
  fine.map_size_y_m = 1.0;
  TerrainConfig& all = add("everything_at_once");
  all.threads = 5;
  all.support_radius_voxels = 2;
  all.support_kernel = "gaussian";
  all.forget_after_scans = 25;
  all.map_size_z_m = 7.0;
  TerrainConfig& narrow = add("map_narrower_than_the_support");
  narrow.map_size_y_m = 1.0;
  narrow.voxel_size_m = 0.2;
  narrow.support_radius_voxels = 6;
  cases.back().reuses = false;
  for (DriveCase& drive : cases) drive.model = modelFor(drive.config);
  return cases;
}

class Reuse : public testing::TestWithParam<DriveCase> {};

TEST_P(Reuse, WhatIsKnownIsWhatComputingAllAnewGives) { test::expectRightAllTheWay(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Drives, Reuse, testing::ValuesIn(driveCases()),
                         [](const auto& drive) { return drive.param.name; });

/// Occupied voxels within the support radius of one of the columns, along x and along y.
std::size_t voxelsNear(const VoxelMap& map, const std::set<std::pair<int, int>>& columns, int r) {
  std::size_t near = 0;
  map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t /*slot*/) {
    const bool is_near = std::any_of(columns.begin(), columns.end(), [&](const auto& column) {
      return std::abs(column.first - voxel.x) <= r && std::abs(column.second - voxel.y) <= r;
    });
    near += is_near ? 1 : 0;
  });
  return near;
}

/// A pipeline whose map is full of a scene seen from the origin.
class FilledMap : public testing::Test {
 protected:
  FilledMap() { processAt(&pipeline_, scene_.points, Vector3d::Zero()); }

  std::size_t updated() const { return pipeline_.report().updated_voxels; }
  std::size_t occupied() const { return pipeline_.report().occupied_voxels; }
  /// Columns of voxels that `leaves`.
  template <typename Leaves>
  std::set<std::pair<int, int>> columnsWhere(const Leaves& leaves) const {
    std::set<std::pair<int, int>> columns;
    pipeline_.map().forEachVoxel([&](const VoxelIndex& voxel, std::size_t /*slot*/) {
      if (leaves(voxel)) columns.insert({voxel.x, voxel.y});
    });
    return columns;
  }

  static constexpr int kRadius = 6;
  TerrainPipeline pipeline_{{}, handModel()};
  MixedScene scene_;
};

TEST_F(FilledMap, WasComputedAsAWhole) {
  EXPECT_GT(occupied(), 5000U);
  EXPECT_EQ(updated(), occupied());
}

TEST_F(FilledMap, AFewPointsInACornerConcernTheirSurroundings) {
  processAt(&pipeline_, {{4.93, 4.91, -0.45}, {4.97, 4.88, -0.45}, {4.72, 4.91, -0.45}},
            Vector3d::Zero());
  EXPECT_EQ(pipeline_.report().points_inserted, 3U);
  EXPECT_EQ(updated(), voxelsNear(pipeline_.map(), {{49, 49}, {49, 48}, {47, 49}}, kRadius));
  EXPECT_GT(updated(), 0U);
  EXPECT_LT(updated(), occupied() / 50);
}

TEST_F(FilledMap, NothingNewConcernsNothing) {
  processAt(&pipeline_, {}, Vector3d::Zero());
  EXPECT_EQ(updated(), 0U);
  processAt(&pipeline_, {{50, 0, 0}, {0, 0, 30}, {0.1, 0, 0}}, Vector3d::Zero());  // none inside
  EXPECT_EQ(pipeline_.report().points_inserted, 0U);
  EXPECT_EQ(updated(), 0U);
  processAt(&pipeline_, {}, Vector3d(0.05, 0.05, 0.05));  // the same voxel
  EXPECT_EQ(updated(), 0U);
  EXPECT_GT(occupied(), 5000U);
}

TEST_F(FilledMap, TheSameSceneAgainConcernsAllOfIt) {
  processAt(&pipeline_, MixedScene(2).points, Vector3d::Zero());
  EXPECT_EQ(updated(), occupied());
  pipeline_.reset();
  processAt(&pipeline_, scene_.points, Vector3d::Zero());
  EXPECT_EQ(updated(), occupied());
}

TEST_F(FilledMap, ScrollingConcernsWhatIsNextToWhatLeft) {
  // The ground ends at 5 m, the map at 10 m.
  processAt(&pipeline_, {}, Vector3d(3.0, -2.0, 0.0));
  EXPECT_EQ(updated(), 0U);
  const int min_x = pipeline_.map().minCorner().x;
  ASSERT_EQ(min_x, -70);
  const auto left = columnsWhere([&](const VoxelIndex& voxel) { return voxel.x < -48; });
  ASSERT_FALSE(left.empty());
  processAt(&pipeline_, {}, Vector3d(5.2, -2.0, 0.0));
  ASSERT_EQ(pipeline_.map().minCorner().x, -48);
  EXPECT_EQ(updated(), voxelsNear(pipeline_.map(), left, kRadius));
  EXPECT_GT(updated(), 0U);
  EXPECT_LT(updated(), occupied() / 10);
}

TEST_F(FilledMap, ScrollingUpConcernsWhatIsNextToWhatSank) {
  // The map reaches from -1 to 2 m, the ground lies at -0.45 m.
  processAt(&pipeline_, {}, Vector3d(0, 0, 0.4));
  EXPECT_EQ(updated(), 0U);
  const auto left = columnsWhere([&](const VoxelIndex& voxel) { return voxel.z < -4; });
  ASSERT_FALSE(left.empty());
  processAt(&pipeline_, {}, Vector3d(0, 0, 0.6));
  ASSERT_EQ(pipeline_.map().minCorner().z, -4);
  EXPECT_EQ(updated(), voxelsNear(pipeline_.map(), left, kRadius));
  EXPECT_GT(updated(), 0U);
}

TEST_F(FilledMap, AJumpConcernsOnlyWhatIsNew) {
  processAt(&pipeline_, {{3, 0, 0}, {3.05, 0, 0.31}}, Vector3d(1000, 0, 0));
  EXPECT_EQ(occupied(), 2U);
  EXPECT_EQ(updated(), 2U);
}

/// Confidences of all voxels, in the map's order.
std::vector<float> confidences(const TerrainPipeline& pipeline) {
  std::vector<float> all;
  pipeline.map().forEachVoxel([&](const VoxelIndex& /*voxel*/, std::size_t slot) {
    all.push_back(pipeline.classification(slot).confidence);
  });
  return all;
}

/// A pole at x = 0 leaves the map, out of reach of what any feature looks at, and level ground from
/// `gap` voxels on stays.
void expectThePoleCountsNoMore(const TerrainConfig& config, const ClassifierModel& model, int gap) {
  const int edge = config.support_radius_voxels + 1;
  const Vector3d before_place(2.55, 0, 0);
  const Vector3d after_place(3.05 + 0.1 * edge, 0, 0);
  std::vector<Vector3d> ground;
  for (int i = 0; i < 200; ++i) {
    ground.emplace_back(0.1 * gap + 0.002 * i, 0.05 + 0.01 * (i % 7), 0.03);
  }
  std::vector<Vector3d> both = ground;
  for (int i = 0; i < 60; ++i) both.emplace_back(0.05, 0.05, 0.02 * i);
  TerrainPipeline pipeline(config, model);
  TerrainPipeline without_pole(config, model);
  test::processInMap(&pipeline, both, before_place);
  std::vector<float> before = confidences(pipeline);
  test::processInMap(&pipeline, {}, after_place);
  ASSERT_EQ(pipeline.map().minCorner().x, edge);
  EXPECT_EQ(pipeline.report().updated_voxels, 0U);
  test::processInMap(&without_pole, ground, after_place);
  ASSERT_NO_FATAL_FAILURE(test::expectSameVoxels(pipeline, without_pole));
  const std::vector<float> after = confidences(pipeline);
  ASSERT_GT(before.size(), after.size());
  before.erase(before.begin(), before.end() - static_cast<std::ptrdiff_t>(after.size()));
  EXPECT_EQ(before != after, gap <= model.calibration.smoothing.radii_voxels[0]);
}

TEST(Smoothing, LabelsAreAveragedAnewNextToWhatLeftTheMap) {
  for (const auto& [support, smoothing] : {std::pair<int, int>{1, 8}, {1, 2}, {3, 7}, {4, 5}}) {
    TerrainConfig config = smallMap();
    config.support_radius_voxels = support;
    ClassifierModel model = modelFor(config);
    model.calibration.smoothing.radii_voxels = {smoothing};
    model.calibration.smoothing.exponents = {0.0, 1.0};
    for (int gap = support + 1; gap <= smoothing + 1; ++gap) {
      ASSERT_NO_FATAL_FAILURE(expectThePoleCountsNoMore(config, model, gap))
          << support << ", " << smoothing << ", " << gap;
    }
  }
}

TEST(FullVoxels, RefusedPointsConcernNothing) {
  TerrainPipeline pipeline({}, handModel());
  const std::vector<Vector3d> many(maxPointsPerVoxel(6), Vector3d(3.05, 0.05, 0.55));
  processAt(&pipeline, many, Vector3d::Zero());
  EXPECT_EQ(pipeline.report().updated_voxels, 1U);
  processAt(&pipeline, many, Vector3d::Zero());
  EXPECT_EQ(pipeline.report().points_inserted, 0U);
  EXPECT_EQ(pipeline.report().updated_voxels, 0U);
}

TEST(Forgetting, ConcernsWhatIsNextToWhatIsForgotten) {
  TerrainConfig config;
  config.forget_after_scans = 8;
  TerrainPipeline pipeline(config, handModel());
  processAt(&pipeline, {{3.05, 0.05, 0.5}, {3.35, 0.05, 0.5}}, Vector3d::Zero());
  processAt(&pipeline, {{3.75, 0.05, 0.5}, {-3.05, 0.05, 0.5}}, Vector3d::Zero());
  EXPECT_EQ(pipeline.report().updated_voxels, 3U);  // the voxel 0.7 m away is none of them
  for (int scan = 2; scan < 8; ++scan) {
    processAt(&pipeline, {}, Vector3d::Zero());
    EXPECT_EQ(pipeline.report().updated_voxels, 0U) << scan;
  }
  processAt(&pipeline, {}, Vector3d::Zero());
  EXPECT_EQ(pipeline.report().occupied_voxels, 2U);
  EXPECT_EQ(pipeline.report().updated_voxels, 1U);
}

}  // namespace
}  // namespace ladar_perception
