// SPDX-License-Identifier: BSD-3-Clause
// Forgetting, as a user of the pipeline sees it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "hand_model.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "terrain_comparisons.h"
#include "terrain_scenes.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test::expectSameLabels;
using test::expectSameVoxels;
using test::groundPoints;
using test::handModel;
using test::kSurfaceLabel;
using test::modelFor;
using test::processAt;
using test::processPoints;
using test::stepMiddle;
using test::TestRandom;

constexpr int kSlices = EvidenceSlices::kSlices;

/// Ground of that scan, other points each time.
std::vector<Vector3d> groundOf(int scan) {
  TestRandom random(static_cast<uint64_t>(scan) + 100);
  return groundPoints(&random, 3000);
}

/// Somebody who stands 3 m ahead, on the ground.
std::vector<Vector3d> personPoints(int scan) {
  TestRandom random(static_cast<uint64_t>(scan) + 500);
  std::vector<Vector3d> points;
  for (int i = 0; i < 200; ++i) {
    const double x = random.real(3.0, 3.4);
    const double y = random.real(-0.2, 0.2);
    points.push_back(stepMiddle({x, y, random.real(-0.35, 1.3)}));
  }
  return points;
}

std::size_t personVoxels(const TerrainPipeline& pipeline) {
  std::size_t count = 0;
  pipeline.map().forEachVoxel([&](const VoxelIndex& voxel, std::size_t /*slot*/) {
    const bool at_place = voxel.x >= 30 && voxel.x < 34 && voxel.y >= -2 && voxel.y < 2;
    count += at_place && voxel.z >= -4 ? 1 : 0;
  });
  return count;
}

/// A scan of the ground, and of the person if there is one.
void look(TerrainPipeline* pipeline, int scan, bool person, double stamp_s = 0.0) {
  std::vector<Vector3d> points = groundOf(scan);
  if (person) {
    const std::vector<Vector3d> more = personPoints(scan);
    points.insert(points.end(), more.begin(), more.end());
  }
  processAt(pipeline, points, Vector3d::Zero(), stamp_s);
}

/// Points in the support volume of the ground the person stands on.
uint32_t pointsAtTheFeet(const TerrainPipeline& pipeline) {
  const VoxelMap& map = pipeline.map();
  for (const auto& [voxel, slot] : test::listVoxels(map)) {
    if (voxel.x >= 30 && voxel.x < 34 && voxel.y >= -2 && voxel.y < 2 && voxel.z == -5) {
      return pipeline.saliency(slot).points;
    }
  }
  return 0;
}

double surfaceShare(const TerrainPipeline& pipeline) {
  const auto& labels = pipeline.pointLabels();
  const auto surface = std::count_if(labels.begin(), labels.end(), [](const PointLabel& label) {
    return label.label == kSurfaceLabel;
  });
  return static_cast<double>(surface) / static_cast<double>(labels.size());
}

TEST(ForgetAfterScans, APersonWhoWentIsForgottenAndTheGroundIsNot) {
  constexpr int kLastSeen = 5;
  TerrainConfig config;
  config.forget_after_scans = 16;
  TerrainPipeline pipeline(config, handModel());
  TerrainPipeline alone(config, handModel());  // never saw the person
  for (int scan = 0; scan < 40; ++scan) {
    look(&pipeline, scan, scan <= kLastSeen);
    look(&alone, scan, false);
    const int age = scan - kLastSeen;
    if (age < 16 * 7 / 8) {
      EXPECT_GT(personVoxels(pipeline), 20U) << scan;
      EXPECT_GT(pointsAtTheFeet(pipeline), pointsAtTheFeet(alone) + 20) << scan;
    }
    if (age < 16) continue;
    EXPECT_EQ(personVoxels(pipeline), 0U) << scan;
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline, alone)) << scan;
    ASSERT_NO_FATAL_FAILURE(expectSameLabels(pipeline, alone)) << scan;
    EXPECT_GT(pipeline.report().occupied_voxels, 8000U) << scan;
    EXPECT_GT(surfaceShare(pipeline), 0.97) << scan;
  }
}

TEST(ForgetAfterScans, ALifetimeOfOneScanKeepsTheLastScanOnly) {
  TerrainConfig config;
  config.forget_after_scans = 1;
  TerrainPipeline pipeline(config, handModel());
  for (int scan = 0; scan < 4; ++scan) {
    look(&pipeline, scan, scan % 2 == 0);
    TerrainPipeline fresh({}, handModel());
    look(&fresh, scan, scan % 2 == 0);
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline, fresh)) << scan;
    ASSERT_NO_FATAL_FAILURE(expectSameLabels(pipeline, fresh)) << scan;
  }
}

TEST(ForgetAfterScans, DoesNotLookAtTheStamps) {
  TerrainConfig config;
  config.forget_after_scans = 8;
  TerrainPipeline pipeline(config, handModel());
  look(&pipeline, 0, true, 1e9);
  for (int scan = 1; scan < 8; ++scan) {
    look(&pipeline, scan, false, scan % 2 == 0 ? 0.0 : 2e9);
    EXPECT_GT(personVoxels(pipeline), 0U) << scan;
  }
  look(&pipeline, 8, false, 1e9);
  EXPECT_EQ(personVoxels(pipeline), 0U);
}

TEST(ForgetAfterSeconds, APersonWhoWentIsForgottenAndTheGroundIsNot) {
  constexpr double kLastSeen_s = 1.7e9 + 0.55;
  TerrainConfig config;
  config.forget_after_s = 1.6;
  TerrainPipeline pipeline(config, handModel());
  TerrainPipeline alone(config, handModel());
  for (int scan = 0; scan < 35; ++scan) {
    const double stamp_s = 1.7e9 + 0.1 * scan;
    const double age_s = stamp_s - kLastSeen_s;
    look(&pipeline, scan, age_s < 0.0, stamp_s);
    look(&alone, scan, false, stamp_s);
    if (age_s < 1.6 * 7 / 8 - 0.05) {
      EXPECT_GT(personVoxels(pipeline), 20U) << scan;
    }
    if (age_s < 1.6) continue;
    EXPECT_EQ(personVoxels(pipeline), 0U) << scan;
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline, alone)) << scan;
    ASSERT_NO_FATAL_FAILURE(expectSameLabels(pipeline, alone)) << scan;
    EXPECT_GT(pipeline.report().occupied_voxels, 8000U) << scan;
    EXPECT_GT(surfaceShare(pipeline), 0.97) << scan;
  }
}

TEST(ForgetAfterSeconds, ALongPauseForgetsEverything) {
  TerrainConfig config;
  config.forget_after_s = 2.0;
  for (const double pause_s : {2.0, 2.1, 17.0, 86400.0, 3e9}) {
    TerrainPipeline pipeline(config, handModel());
    TerrainPipeline fresh(config, handModel());
    for (int scan = 0; scan < 10; ++scan) look(&pipeline, scan, true, 10.0 + 0.2 * scan);
    const double stamp_s = 10.0 + 0.2 * 9 + pause_s;
    look(&pipeline, 20, false, stamp_s);
    look(&fresh, 20, false, stamp_s);
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline, fresh)) << pause_s;
    ASSERT_NO_FATAL_FAILURE(expectSameLabels(pipeline, fresh)) << pause_s;
    EXPECT_EQ(pipeline.report().updated_voxels, pipeline.report().occupied_voxels) << pause_s;
  }
}

TEST(ForgetAfterSeconds, AnEmptyScanForgetsToo) {
  TerrainConfig config;
  config.forget_after_s = 2.0;
  TerrainPipeline pipeline(config, handModel());
  look(&pipeline, 0, true, 10.0);
  processAt(&pipeline, {}, Vector3d::Zero(), 11.0);
  EXPECT_GT(pipeline.map().occupied(), 0U);
  processAt(&pipeline, {}, Vector3d::Zero(), 12.0);
  EXPECT_EQ(pipeline.map().occupied(), 0U);
  EXPECT_EQ(pipeline.report().occupied_voxels, 0U);
}

TEST(ForgetAfterSeconds, AClockThatIsSetBackForgetsNothing) {
  TerrainConfig config;
  config.forget_after_s = 2.0;
  TerrainPipeline pipeline(config, handModel());
  look(&pipeline, 0, true, 100.0);
  look(&pipeline, 1, false, 5.0);
  look(&pipeline, 2, false, -5.0);
  EXPECT_GT(personVoxels(pipeline), 0U);
  look(&pipeline, 3, false, 101.7);
  EXPECT_GT(personVoxels(pipeline), 0U);
  look(&pipeline, 4, false, 102.0);
  EXPECT_EQ(personVoxels(pipeline), 0U);
}

TEST(ForgetAfterSeconds, ResetStartsTheClockAnew) {
  TerrainConfig config;
  config.forget_after_s = 2.0;
  TerrainPipeline pipeline(config, handModel());
  for (int scan = 0; scan < 5; ++scan) look(&pipeline, scan, false, 1.7e9 + 0.3 * scan);
  pipeline.reset();
  EXPECT_EQ(pipeline.map().occupied(), 0U);
  TerrainPipeline fresh(config, handModel());
  for (int scan = 0; scan < 30; ++scan) {
    const double stamp_s = 3.0 + 0.3 * scan;  // a bag that begins at its own time
    for (TerrainPipeline* each : {&pipeline, &fresh}) look(each, scan, scan < 2, stamp_s);
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline, fresh)) << scan;
    EXPECT_EQ(personVoxels(pipeline) > 0, scan < 8) << scan;  // 3.3 s lives until 5.25 s
  }
}

TEST(ForgetAfterScans, ResetStartsTheCountAnew) {
  TerrainConfig config;
  config.forget_after_scans = 8;
  TerrainPipeline pipeline(config, handModel());
  for (int scan = 0; scan < 5; ++scan) look(&pipeline, scan, true);
  pipeline.reset();
  look(&pipeline, 0, true);
  for (int scan = 1; scan < 8; ++scan) {
    look(&pipeline, scan, false);
    EXPECT_GT(personVoxels(pipeline), 0U) << scan;
  }
  look(&pipeline, 8, false);
  EXPECT_EQ(personVoxels(pipeline), 0U);
}

TEST(Forgetting, IsOffByDefault) {
  TerrainPipeline pipeline({}, handModel());
  look(&pipeline, 0, true, 100.0);
  const std::size_t voxels = personVoxels(pipeline);
  EXPECT_GT(voxels, 20U);
  for (int scan = 1; scan < 30; ++scan) look(&pipeline, scan, false, 100.0 + 3600.0 * scan);
  EXPECT_EQ(personVoxels(pipeline), voxels);
}

TEST(Forgetting, NeedsNoMoreMemoryAfterTheFirstLifetimes) {
  TerrainConfig config;
  config.forget_after_scans = 16;
  TerrainPipeline pipeline(config, handModel());
  std::size_t bytes = 0;
  for (int scan = 0; scan < 120; ++scan) {
    look(&pipeline, scan % 20, scan % 5 == 0);
    if (scan == 60) bytes = pipeline.report().memory_bytes;
  }
  EXPECT_GT(bytes, 0U);
  EXPECT_LE(pipeline.report().memory_bytes, bytes * 11 / 10);
}

/// A drive of a pipeline that forgets, with the scans that are young enough and of them the points
/// that are inside.
class ForgetfulDrive {
 public:
  explicit ForgetfulDrive(const TerrainConfig& config)
      : config_(config), pipeline_(config, modelFor(config)) {}

  std::size_t forgotten() const { return forgotten_; }
  std::size_t scrolledOut() const { return scrolled_out_; }

  void step() {
    const int64_t kind = random_.integer(0, 99);
    if (kind == 0) reset();
    move(kind);
    stamp_s_ += kind == 1 ? 1e5 : kind < 6 ? random_.real(0.0, 4.0) : random_.real(0.0, 0.15);
    const double stamp_s = kind == 7 ? stamp_s_ - 2.0 : stamp_s_;
    YoungScan scan = look();
    processPoints(&pipeline_, test::xyzCloud(scan.p_sensor), scan.T_map_sensor, place_, {},
                  stamp_s);
    forgetOldScans(stamp_s);
    forgetOutside();
    scan.slice = slice_;
    keepInserted(&scan);
    scans_.push_back(std::move(scan));
  }
  /// A pipeline that was only ever fed with the young points agrees bit by bit.
  void expectFresh() const {
    TerrainConfig config = config_;
    config.forget_after_s = 0.0;
    config.forget_after_scans = 0;
    TerrainPipeline fresh(config, modelFor(config));
    std::size_t points = 0;
    for (const YoungScan& scan : scans_) {
      processPoints(&fresh, test::xyzCloud(scan.p_sensor), scan.T_map_sensor, place_);
      ASSERT_EQ(fresh.report().points_inserted, scan.p_sensor.size());
      points += scan.p_sensor.size();
    }
    ASSERT_EQ(fresh.map().minCorner(), pipeline_.map().minCorner());
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline_, fresh)) << points << " points";
  }

 private:
  struct YoungScan {
    std::vector<Vector3d> p_sensor;
    Isometry3d T_map_sensor = Isometry3d::Identity();
    int64_t slice = 0;
  };

  void reset() {
    pipeline_.reset();
    scans_.clear();
    started_ = false;
    count_ = 0;
    stamp_s_ = random_.real(0.0, 1000.0);
  }
  /// By whole voxels, so that points stay in the middles of steps.
  void move(int64_t kind) {
    const int64_t reach = kind >= 97 ? 40 : 1;
    const auto x = static_cast<double>(random_.integer(-reach, reach));
    const auto y = static_cast<double>(random_.integer(-reach, reach));
    const auto z = static_cast<double>(kind >= 90 ? random_.integer(-2, 2) : 0);
    place_voxels_ += Vector3d(x, y, z);
    place_ = 0.1 * place_voxels_ + Vector3d(0.05, 0.05, 0.05);
  }
  YoungScan look() {
    YoungScan scan;
    scan.T_map_sensor.translation() = 0.1 * place_voxels_;
    for (int64_t i = random_.integer(0, 80); i > 0; --i) {
      const double x = random_.real(-3.2, 3.2);
      const double y = random_.real(-2.7, 2.7);
      scan.p_sensor.push_back(stepMiddle({x, y, 0.1 * std::sin(x) + random_.real(0.0, 0.3)}));
    }
    return scan;
  }
  void forgetOldScans(double stamp_s) {
    const double lifetimes = config_.forget_after_s > 0.0
                                 ? stamp_s / config_.forget_after_s
                                 : static_cast<double>(count_) / config_.forget_after_scans;
    ++count_;
    const auto slice = static_cast<int64_t>(std::floor(lifetimes * kSlices));
    slice_ = started_ ? std::max(slice_, slice) : slice;
    started_ = true;
    const auto old = [&](const YoungScan& scan) { return scan.slice + kSlices <= slice_; };
    const auto young = std::remove_if(scans_.begin(), scans_.end(), old);
    forgotten_ += static_cast<std::size_t>(scans_.end() - young);
    scans_.erase(young, scans_.end());
  }
  void forgetOutside() {
    const VoxelIndex& min = pipeline_.map().minCorner();
    const MapShape& shape = pipeline_.map().shape();
    for (YoungScan& scan : scans_) {
      const auto outside = [&](const Vector3d& p_sensor) {
        const Vector3d p = (p_sensor + scan.T_map_sensor.translation()) / 0.1;
        const double x = std::floor(p.x()) - min.x;
        const double y = std::floor(p.y()) - min.y;
        const double z = std::floor(p.z()) - min.z;
        return x < 0 || x >= shape.nx || y < 0 || y >= shape.ny || z < 0 || z >= shape.nz;
      };
      auto& points = scan.p_sensor;
      const auto inside = std::remove_if(points.begin(), points.end(), outside);
      scrolled_out_ += static_cast<std::size_t>(points.end() - inside);
      points.erase(inside, points.end());
    }
  }
  void keepInserted(YoungScan* scan) const {
    std::vector<Vector3d> inserted;
    for (std::size_t i = 0; i < scan->p_sensor.size(); ++i) {
      if (pipeline_.pointCells()[i] != kNoCell) inserted.push_back(scan->p_sensor[i]);
    }
    scan->p_sensor = inserted;
  }

  TerrainConfig config_;
  TerrainPipeline pipeline_;
  TestRandom random_{41};
  Vector3d place_voxels_ = Vector3d::Zero();
  Vector3d place_ = Vector3d::Zero();
  double stamp_s_ = 1.7e9;
  int64_t count_ = 0;
  int64_t slice_ = 0;
  bool started_ = false;
  std::vector<YoungScan> scans_;
  std::size_t forgotten_ = 0;
  std::size_t scrolled_out_ = 0;
};

struct DriveCase {
  std::string name;
  TerrainConfig config;
};

void PrintTo(const DriveCase& drive, std::ostream* out) { *out << drive.name; }

std::vector<DriveCase> driveCases() {
  std::vector<DriveCase> cases;
  const auto add = [&](const std::string& name) -> TerrainConfig& {
    cases.push_back({name, {}});
    TerrainConfig& config = cases.back().config;
    config.map_size_x_m = 6.0;
    config.map_size_y_m = 5.0;
    config.map_size_z_m = 2.0;
    return config;
  };
  add("seconds").forget_after_s = 2.0;
  add("scans").forget_after_scans = 20;
  add("few_scans").forget_after_scans = 3;  // less than the number of slices
  add("scans_no_multiple_of_slices").forget_after_scans = 13;
  TerrainConfig& kernel = add("kernel_and_threads");
  kernel.forget_after_s = 1.3;
  kernel.threads = 3;
  kernel.support_radius_voxels = 2;
  kernel.support_kernel = "gaussian";
  TerrainConfig& tall = add("tall");
  tall.forget_after_scans = 16;
  tall.map_size_z_m = 7.0;
  return cases;
}

class Forget : public testing::TestWithParam<DriveCase> {};

TEST_P(Forget, TheMapIsThatOfAPipelineThatSawTheYoungPointsOnly) {
  ForgetfulDrive drive(GetParam().config);
  for (int scan = 0; scan < 200; ++scan) {
    drive.step();
    ASSERT_NO_FATAL_FAILURE(drive.expectFresh()) << "scan " << scan;
  }
  // Otherwise the drive has shown nothing.
  EXPECT_GT(drive.forgotten(), 100U);
  EXPECT_GT(drive.scrolledOut(), 100U);
}

INSTANTIATE_TEST_SUITE_P(Drives, Forget, testing::ValuesIn(driveCases()),
                         [](const auto& drive) { return drive.param.name; });

}  // namespace
}  // namespace ladar_perception
