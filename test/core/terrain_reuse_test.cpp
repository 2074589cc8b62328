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
#include "ladar_perception/saliency/box_sums.h"
#include "ladar_perception/saliency/features.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "map_oracle.h"
#include "terrain_comparisons.h"
#include "terrain_scenes.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::handModel;
using test::listVoxels;
using test::MixedScene;
using test::processAt;
using test::TestRandom;

ClassifierModel modelFor(const TerrainConfig& config) {
  ClassifierModel model = handModel();
  model.voxel_size_m = config.voxel_size_m;
  model.support_radius_voxels = config.support_radius_voxels;
  model.support_kernel = config.support_kernel;
  return model;
}

/// What has to be known of the voxels of a map, from its records alone.
class Recomputation {
 public:
  struct Voxel {
    SaliencyF saliency;
    Classification classification;
  };

  explicit Recomputation(const TerrainConfig& config)
      : config_(config),
        stack_(config.supportStack()),
        model_(modelFor(config)),
        classifier_(model_) {}

  /// One voxel alone, by as many look-ups as there are voxels in the support volume.
  Voxel of(const VoxelMap& map, const VoxelIndex& center) const {
    const int r = config_.support_radius_voxels;
    Moments sum;
    uint32_t points = 0;
    for (int dx = -r; dx <= r; ++dx) {
      for (int dy = -r; dy <= r; ++dy) {
        for (int dz = -r; dz <= r; ++dz) {
          const Moments* record = map.find({center.x + dx, center.y + dy, center.z + dz});
          if (record == nullptr) continue;
          points += record->count();
          const int distance = std::max({std::abs(dx), std::abs(dy), std::abs(dz)});
          for (uint32_t i = 0; i < weightAt(stack_, distance); ++i) sum += *record;
        }
      }
    }
    return classify({sum}, {points}, {center}).front();
  }
  /// All voxels by slot, from sums over the whole map: in other blocks than the pipeline's.
  std::vector<Voxel> ofAll(const VoxelMap& map) const {
    ColumnSet columns;
    columns.assignAll(map.shape().nx, map.shape().ny);
    SumTable table{std::vector<Moments>(map.slotBound())};
    std::vector<Moments> sums(map.slotBound());
    std::vector<uint32_t> points(map.slotBound());
    for (std::size_t i = 0; i < stack_.size(); ++i) {
      SlidingBoxSums<Moments> box_sums(stack_[i].box);
      box_sums.compute(map, columns, 0, map.shape().ny, table);
      map.forEachVoxel([&](const VoxelIndex& /*voxel*/, std::size_t slot) {
        if (i == 0) points[slot] = table.sums[slot].count();
        for (uint32_t j = 0; j < stack_[i].weight; ++j) sums[slot] += table.sums[slot];
      });
    }
    std::vector<Voxel> result(map.slotBound());
    Batch batch;
    auto voxels = listVoxels(map);
    std::reverse(voxels.begin(), voxels.end());
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      batch.add(sums[voxels[i].second], points[voxels[i].second], voxels[i]);
      if (batch.slots.size() < kSaliencyBlock && i + 1 < voxels.size()) continue;
      const std::vector<Voxel> known = classify(batch.sums, batch.points, batch.voxels);
      for (std::size_t j = 0; j < known.size(); ++j) result[batch.slots[j]] = known[j];
      batch = Batch();
    }
    return result;
  }

 private:
  struct SumTable {
    std::vector<Moments> sums;
    Moments& place(std::size_t slot, int /*x*/, int /*y*/, int /*z*/) { return sums[slot]; }
  };
  struct Batch {
    void add(const Moments& sum, uint32_t count, const std::pair<VoxelIndex, std::size_t>& voxel) {
      sums.push_back(sum);
      points.push_back(count);
      voxels.push_back(voxel.first);
      slots.push_back(voxel.second);
    }
    std::vector<Moments> sums;
    std::vector<uint32_t> points;
    std::vector<VoxelIndex> voxels;
    std::vector<std::size_t> slots;
  };

  /// At most a block of voxels.
  std::vector<Voxel> classify(const std::vector<Moments>& sums, const std::vector<uint32_t>& points,
                              const std::vector<VoxelIndex>& voxels) const {
    const double step_m = config_.voxel_size_m / static_cast<double>(kStepsPerVoxel);
    const auto count = static_cast<int>(sums.size());
    SaliencyBlock block;
    saliencyOfBlock(sums.data(), voxels.data(), count, step_m, &block);
    FeatureBlock features(static_cast<int>(model_.features.size()));
    for (std::size_t f = 0; f < model_.features.size(); ++f) {
      featureValues(model_.features[f], block, features.row(static_cast<int>(f)));
    }
    Classification classified[kSaliencyBlock];
    classifier_.classify(features, count, classified);
    std::vector<Voxel> result(sums.size());
    for (int i = 0; i < count; ++i) {
      result[i].saliency = block.at(i);
      result[i].saliency.points = points[i];
      const bool supported = result[i].saliency.defined &&
                             points[i] >= static_cast<uint32_t>(config_.min_support_points);
      if (supported) result[i].classification = classified[i];
    }
    return result;
  }

  TerrainConfig config_;
  BoxStack stack_;
  ClassifierModel model_;
  Classifier classifier_;
};

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
      const auto& [voxel, slot] = voxels[random_.integer(0, static_cast<int64_t>(voxels.size()) - 1)];
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
