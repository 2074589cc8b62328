// SPDX-License-Identifier: BSD-3-Clause
// Long drives at random, and what is known after every scan of them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "ladar_perception/terrain/terrain_pipeline.h"
#include "map_oracle.h"
#include "terrain_comparisons.h"
#include "terrain_recomputation.h"
#include "terrain_scenes.h"

namespace ladar_perception::test {

/// A vehicle that goes anywhere and sees a few points each time.
class RandomDrive {
 public:
  RandomDrive(const TerrainConfig& config, const ClassifierModel& model, uint64_t seed = 1)
      : config_(config), random_(seed), pipeline_(config, model), recomputation_(config, model) {
    pipeline_.keepFeatures(true);
  }

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
  /// Labels that voxels had at one time or another.
  std::size_t labelsSeen() const {
    return static_cast<std::size_t>(std::count(label_seen_.begin(), label_seen_.end(), true));
  }
  void expectAllIsKnown() {
    const VoxelMap& map = pipeline_.map();
    ASSERT_LE(pipeline_.report().updated_voxels, map.occupied());
    const auto all = recomputation_.ofAll(map);
    const auto voxels = listVoxels(map);
    for (const auto& [voxel, slot] : voxels) {
      ASSERT_NO_FATAL_FAILURE(expectKnown(voxel, slot, all[slot]));
      label_seen_[all[slot].classification.label] = true;
    }
    for (int i = 0; i < 12 && !voxels.empty(); ++i) {
      const auto& [voxel, slot] =
          voxels[random_.integer(0, static_cast<int64_t>(voxels.size()) - 1)];
      // The recomputation of all of them against that of one alone.
      Recomputation::Voxel alone = recomputation_.of(map, voxel);
      ASSERT_EQ(alone.posterior, all[slot].posterior);
      if (config_.smooth_labels) alone.classification = all[slot].classification;
      ASSERT_NO_FATAL_FAILURE(expectKnown(voxel, slot, alone));
    }
    expectLabels();
  }

 private:
  using Vector3d = Eigen::Vector3d;

  void expectKnown(const VoxelIndex& voxel, std::size_t slot,
                   const Recomputation::Voxel& expected) const {
    ASSERT_TRUE(test::same(pipeline_.saliency(slot), expected.saliency))
        << testing::PrintToString(voxel) << ": " << pipeline_.saliency(slot).points << " points, "
        << expected.saliency.points << " expected";
    ASSERT_TRUE(test::same(pipeline_.classification(slot), expected.classification))
        << testing::PrintToString(voxel) << ": " << +pipeline_.classification(slot).label << " at "
        << pipeline_.classification(slot).confidence << ", expected "
        << +expected.classification.label << " at " << expected.classification.confidence;
    const auto& features = pipeline_.model().features;
    for (std::size_t f = 0; f < features.size(); ++f) {
      ASSERT_EQ(pipeline_.features(slot)[f], expected.features[f])
          << testing::PrintToString(voxel) << ": " << featureName(features[f]);
    }
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
    if (kind < 84) {
      last_move_ = offset(1.5, 1.5, kind < 40 ? 1.5 : 0.0);
    } else if (kind < 92) {
      last_move_ = offset(9.0, 9.0, 0.0);
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
  std::array<bool, kMaxClasses + 1> label_seen_{};
};

/// A drive by the name of what is special of it.
struct DriveCase {
  std::string name;
  TerrainConfig config;
  ClassifierModel model;
  bool reuses = true;  // whether most voxels are of other scans' surroundings
  int scans = 600;
};

inline void PrintTo(const DriveCase& drive, std::ostream* out) { *out << drive.name; }

/// A map that is computed anew, voxel by voxel, in a moment.
inline TerrainConfig smallMap() {
  TerrainConfig config;
  config.map_size_x_m = 6.0;
  config.map_size_y_m = 5.0;
  config.map_size_z_m = 2.0;
  config.min_range_m = 0.0;
  return config;
}

/// Compares after every scan. Most scans must have changed something, and most voxels must have
/// been left alone, or the drive would show little.
inline void expectRightAllTheWay(const DriveCase& drive_case) {
  RandomDrive drive(drive_case.config, drive_case.model);
  for (int scan = 0; scan < drive_case.scans; ++scan) {
    drive.step();
    ASSERT_NO_FATAL_FAILURE(drive.expectAllIsKnown()) << "scan " << scan;
  }
  EXPECT_GT(drive.updatedVoxels(), static_cast<std::size_t>(10 * drive_case.scans));
  if (drive_case.reuses) {
    EXPECT_GT(drive.occupiedVoxels(), 3 * drive.updatedVoxels());
  }
  EXPECT_GE(drive.labelsSeen(), 3U) << "unknown, and two classes at the least";
}

}  // namespace ladar_perception::test
