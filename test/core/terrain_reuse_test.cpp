// SPDX-License-Identifier: BSD-3-Clause
// Temporal re-use: only what a scan can have changed is computed anew, and yet what is known of
// every voxel is, after every scan and bit by bit, what computing all of them anew gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hand_model.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "map_oracle.h"
#include "terrain_comparisons.h"
#include "terrain_recomputation.h"
#include "terrain_scenes.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::handModel;
using test::listVoxels;
using test::MixedScene;
using test::modelFor;
using test::processAt;
using test::Recomputation;
using test::TestRandom;

/// A vehicle that goes anywhere and sees a few points each time.
class RandomDrive {
 public:
  explicit RandomDrive(const TerrainConfig& config, uint64_t seed = 1)
      : config_(config),
        random_(seed),
        pipeline_(config, modelFor(config)),
        recomputation_(config) {}

  const TerrainPipeline& pipeline() const { return pipeline_; }
  std::size_t updatedVoxels() const { return updated_voxels_; }
  std::size_t occupiedVoxels() const { return occupied_voxels_; }

  void step() {
    move();
    if (random_.integer(0, 149) == 0) {
      pipeline_.reset();
      if (random_.integer(0, 1) == 0) stamp_s_ = 0.0;
    }
    chooseScan();
    stamp_s_ += random_.integer(0, 39) == 0 ? random_.real(0.0, 5.0) : random_.real(0.0, 0.2);
    // A clock that is set back for a moment must not harm.
    const double late_s = random_.integer(0, 19) == 0 ? 0.3 : 0.0;
    processAt(&pipeline_, scan_, place_, std::max(stamp_s_ - late_s, 0.0));
    updated_voxels_ += pipeline_.report().updated_voxels;
    occupied_voxels_ += pipeline_.report().occupied_voxels;
  }
  void expectAllIsKnown() {
    const VoxelMap& map = pipeline_.map();
    ASSERT_LE(pipeline_.report().updated_voxels, map.occupied());
    const auto all = recomputation_.ofAll(map);
    const auto voxels = listVoxels(map);
    for (const auto& [voxel, slot] : voxels) {
      ASSERT_NO_FATAL_FAILURE(expectKnown(voxel, slot, all[slot]));
    }
    for (int i = 0; i < 12 && !voxels.empty(); ++i) {
      const auto& [voxel, slot] =
          voxels[random_.integer(0, static_cast<int64_t>(voxels.size()) - 1)];
      ASSERT_NO_FATAL_FAILURE(expectKnown(voxel, slot, recomputation_.of(map, voxel)));
    }
    expectLabels();
  }

 private:
  void expectKnown(const VoxelIndex& voxel, std::size_t slot,
                   const Recomputation::Voxel& expected) const {
    ASSERT_TRUE(test::same(pipeline_.saliency(slot), expected.saliency))
        << testing::PrintToString(voxel) << ": " << pipeline_.saliency(slot).points << " points, "
        << expected.saliency.points << " expected";
    ASSERT_TRUE(test::same(pipeline_.classification(slot), expected.classification))
        << testing::PrintToString(voxel);
  }
  void expectLabels() const {
    for (std::size_t i = 0; i < scan_.size(); ++i) {
      const CellId cell = pipeline_.pointCells()[i];
      Classification expected;
      if (cell != kNoCell) expected = pipeline_.classification(pipeline_.map().slotOf(cell));
      ASSERT_EQ(pipeline_.pointLabels()[i].label, expected.label);
      ASSERT_EQ(pipeline_.pointLabels()[i].confidence, expected.confidence);
    }
  }

  Vector3d offset(double x_voxels, double y_voxels, double z_voxels) {
    const double x = random_.real(-x_voxels, x_voxels);
    const double y = random_.real(-y_voxels, y_voxels);
    return config_.voxel_size_m * Vector3d(x, y, random_.real(-z_voxels, z_voxels));
  }
  void move() {
    const MapShape& shape = pipeline_.map().shape();
    const int64_t kind = random_.integer(0, 99);
    if (kind < 20) return;
    if (kind < 32) {
      place_ -= last_move_;  // back again
      return;
    }
    if (kind < 92) {
      last_move_ = offset(1.5, 1.5, kind < 40 ? 1.5 : 0.0);
    } else if (kind < 94) {
      last_move_ = offset(0.0, 0.0, 0.3 * shape.nz);
    } else if (kind < 96) {
      last_move_ = offset(0.4 * shape.nx, 0.4 * shape.ny, 0.0);
    } else if (kind < 99) {
      last_move_ = offset(0.9 * shape.nx, 0.9 * shape.ny, 0.5 * shape.nz);
    } else {
      last_move_ = offset(3.0 * shape.nx, 0.0, 0.0);
    }
    place_ += last_move_;
  }

  void chooseScan() {
    const int64_t kind = random_.integer(0, 99);
    if (kind < 12) return;  // the same points as before, from the sensor's new place
    scan_.clear();
    if (kind < 22) return;
    const MapShape& shape = pipeline_.map().shape();
    const Vector3d size = config_.voxel_size_m * Vector3d(shape.nx, shape.ny, shape.nz);
    const Vector3d middle(0, 0, config_.map_center_height_m);
    if (kind < 50) addPatch(middle + somewhere(0.5 * size), size);
    if (kind >= 50 && kind < 65) {
      const Vector3d corner(random_.integer(0, 1) - 0.5, random_.integer(0, 1) - 0.5,
                            random_.integer(0, 1) - 0.5);
      addPatch(middle + 0.98 * corner.cwiseProduct(size), size);
    }
    if (kind >= 65 && kind < 80) addPole(middle + somewhere(0.5 * size), size.z());
    if (kind >= 80) {
      for (int64_t i = random_.integer(1, 30); i > 0; --i) {
        scan_.push_back(middle + somewhere(0.55 * size));
      }
    }
  }
  Vector3d somewhere(const Vector3d& reach) {
    const double x = random_.real(-reach.x(), reach.x());
    const double y = random_.real(-reach.y(), reach.y());
    return {x, y, random_.real(-reach.z(), reach.z())};
  }
  void addPatch(const Vector3d& middle, const Vector3d& size) {
    const Vector3d reach(0.1 * size.x(), 0.1 * size.y(), 0.4 * config_.voxel_size_m);
    for (int64_t i = random_.integer(1, 60); i > 0; --i) {
      scan_.push_back(middle + somewhere(reach));
    }
  }
  void addPole(const Vector3d& foot, double height_m) {
    const Vector3d reach(0.2 * config_.voxel_size_m, 0.2 * config_.voxel_size_m, 0.5 * height_m);
    for (int64_t i = random_.integer(1, 40); i > 0; --i) {
      scan_.push_back(foot + somewhere(reach));
    }
  }

  TerrainConfig config_;
  TestRandom random_;
  TerrainPipeline pipeline_;
  Recomputation recomputation_;
  Vector3d place_ = {0.05, -0.02, 0.03};
  Vector3d last_move_ = Vector3d::Zero();
  double stamp_s_ = 100.0;
  std::vector<Vector3d> scan_;
  std::size_t updated_voxels_ = 0;
  std::size_t occupied_voxels_ = 0;
};

/// A drive by the name of what is special of it.
struct DriveCase {
  std::string name;
  TerrainConfig config;
  bool reuses = true;  // whether most voxels are of other scans' surroundings
};

void PrintTo(const DriveCase& drive, std::ostream* out) { *out << drive.name; }

TerrainConfig smallMap() {
  TerrainConfig config;
  config.map_size_x_m = 6.0;
  config.map_size_y_m = 5.0;
  config.map_size_z_m = 2.0;
  config.min_range_m = 0.0;
  return config;
}

std::vector<DriveCase> driveCases() {
  std::vector<DriveCase> cases;
  const auto add = [&](const std::string& name) -> TerrainConfig& {
    cases.push_back({name, smallMap(), true});
    return cases.back().config;
  };
  add("plain");
  add("threads").threads = 3;
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
  all.threads = 3;
  all.support_radius_voxels = 2;
  all.support_kernel = "gaussian";
  all.forget_after_scans = 25;
  all.map_size_z_m = 7.0;
  TerrainConfig& narrow = add("map_narrower_than_the_support");
  narrow.map_size_y_m = 1.0;
  narrow.voxel_size_m = 0.2;
  narrow.support_radius_voxels = 6;
  cases.back().reuses = false;
  return cases;
}

constexpr int kScans = 600;

class Reuse : public testing::TestWithParam<DriveCase> {};

TEST_P(Reuse, WhatIsKnownIsWhatComputingAllAnewGives) {
  RandomDrive drive(GetParam().config);
  for (int scan = 0; scan < kScans; ++scan) {
    drive.step();
    ASSERT_NO_FATAL_FAILURE(drive.expectAllIsKnown()) << "scan " << scan;
  }
  // Otherwise the drive has shown little.
  EXPECT_GT(drive.updatedVoxels(), std::size_t{10 * kScans});
  if (GetParam().reuses) {
    EXPECT_GT(drive.occupiedVoxels(), 3 * drive.updatedVoxels());
  }
}

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

  static constexpr int kRadius = 4;
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

TEST(FullVoxels, RefusedPointsConcernNothing) {
  TerrainPipeline pipeline({}, handModel());
  const std::vector<Vector3d> many(maxPointsPerVoxel(4), Vector3d(3.05, 0.05, 0.55));
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
  processAt(&pipeline, {{3.65, 0.05, 0.5}, {-3.05, 0.05, 0.5}}, Vector3d::Zero());
  EXPECT_EQ(pipeline.report().updated_voxels, 3U);  // the voxel 0.6 m away is none of them
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
