// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "hand_model.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "terrain_comparisons.h"
#include "terrain_scenes.h"

namespace ladar_perception {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using test::expectSame;
using test::expectSameLabels;
using test::expectSameVoxels;
using test::handModel;
using test::kLinearLabel;
using test::kScatterLabel;
using test::kSurfaceLabel;
using test::listVoxels;
using test::MixedScene;
using test::processAt;
using test::processPoints;
using test::stepMiddle;
using test::TestRandom;

std::size_t dropped(const ScanReport& report, PointDrop reason) {
  return report.dropped[static_cast<int>(reason)];
}

/// What must hold after every scan.
void expectConsistent(const TerrainPipeline& pipeline, std::size_t points) {
  const ScanReport& report = pipeline.report();
  EXPECT_EQ(report.points_in, points);
  EXPECT_EQ(report.points_in,
            std::accumulate(report.dropped.begin(), report.dropped.end(), report.points_inserted));
  ASSERT_EQ(pipeline.pointLabels().size(), points);
  ASSERT_EQ(pipeline.pointCells().size(), points);
  EXPECT_LE(report.updated_voxels, report.occupied_voxels);
  EXPECT_EQ(report.occupied_voxels, pipeline.map().occupied());
  EXPECT_GE(report.memory_bytes, pipeline.map().memoryBytes());
  std::vector<std::size_t> counts(pipeline.model().classes.size() + 1, 0);
  for (std::size_t i = 0; i < points; ++i) {
    const PointLabel& label = pipeline.pointLabels()[i];
    Classification expected;
    const CellId cell = pipeline.pointCells()[i];
    if (cell != kNoCell) {
      expected = pipeline.classification(pipeline.map().slotOf(cell));
    }
    ASSERT_EQ(label.label, expected.label);
    ASSERT_EQ(label.confidence, expected.confidence);
    ASSERT_EQ(label.rgb, pipeline.model().labelColor(label.label));
    ++counts[label.label];
  }
  EXPECT_EQ(report.label_counts, counts);
}

double shareOf(const TerrainPipeline& pipeline, std::size_t begin, std::size_t end, uint8_t label) {
  const auto& labels = pipeline.pointLabels();
  const auto count = std::count_if(labels.begin() + begin, labels.begin() + end,
                                   [&](const PointLabel& l) { return l.label == label; });
  return static_cast<double>(count) / static_cast<double>(end - begin);
}

TEST(TerrainPipeline, GroundWireAndLeavesGetTheirLabels) {
  TerrainPipeline pipeline({}, handModel());
  const MixedScene scene;
  processAt(&pipeline, scene.points, Vector3d::Zero());
  expectConsistent(pipeline, scene.points.size());
  EXPECT_GT(shareOf(pipeline, 0, 20000, kSurfaceLabel), 0.97);
  EXPECT_GT(shareOf(pipeline, 20000, 21000, kLinearLabel), 0.97);
  // At the corners of the box an eighth of the support volume is left.
  EXPECT_GT(shareOf(pipeline, 21000, 25000, kScatterLabel), 0.9);
}

TEST(TerrainPipeline, NormalsAndTangentsPointTheRightWay) {
  TerrainPipeline pipeline({}, handModel());
  processAt(&pipeline, MixedScene().points, Vector3d::Zero());
  const auto& cells = pipeline.pointCells();
  for (std::size_t i = 0; i < 21000; i += 50) {
    const SaliencyF& saliency = pipeline.saliency(pipeline.map().slotOf(cells[i]));
    if (i < 20000) {
      EXPECT_GT(saliency.normal.z(), 0.99) << i;
    } else {
      EXPECT_GT(std::abs(saliency.tangent.y()), 0.99) << i;
    }
  }
}

TEST(TerrainPipeline, KeepsTheFeaturesOfEveryVoxelWhenAsked) {
  // What they must be terrain_reuse_features_test knows.
  TerrainConfig config;
  config.map_size_x_m = 12.0;
  config.threads = 2;
  ClassifierModel model = handModel();
  model.features = parseFeatures({"scatter", "surface", "linear"});
  TerrainPipeline pipeline(config, model);
  TerrainPipeline without(config, model);
  pipeline.keepFeatures(true);
  for (int scan = 0; scan < 4; ++scan) {
    const MixedScene scene(scan);
    processAt(&pipeline, scene.points, Vector3d(0.7 * scan, 0, 0));
    processAt(&without, scene.points, Vector3d(0.7 * scan, 0, 0));
    std::size_t compared = 0;
    pipeline.map().forEachVoxel([&](const VoxelIndex&, std::size_t slot) {
      if (!pipeline.saliency(slot).defined) return;
      ++compared;
      const SaliencyF& saliency = pipeline.saliency(slot);
      ASSERT_EQ(pipeline.features(slot)[0], saliency.scatter);
      ASSERT_EQ(pipeline.features(slot)[1], saliency.surface);
      ASSERT_EQ(pipeline.features(slot)[2], saliency.linear);
    });
    EXPECT_GT(compared, 5000u);
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline, without));
  }
  const std::size_t kept_bytes = pipeline.report().memory_bytes;
  EXPECT_GT(kept_bytes, without.report().memory_bytes);
  pipeline.keepFeatures(false);
  processAt(&pipeline, {}, Vector3d(2.1, 0, 0));
  EXPECT_LT(pipeline.report().memory_bytes, kept_bytes);
}

TEST(TerrainPipeline, EveryDropIsCountedWithItsReason) {
  TerrainPipeline pipeline({}, handModel());
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<Vector3d> points = {
      {3, 0, 0},    {nan, 0, 0},  {3, nan, 0},   {3, 0, -inf},    {inf, inf, inf}, {0, 0, 0},
      {0.4, 0, 0},  {0, 0.51, 0}, {99, 0, 0},    {101, 0, 0},     {1e30, 0, 0},    {0, 0, 2.6},
      {3, 0, -1.6}, {-3, -3, 1},  {-10.2, 0, 0}, {0, 9.99, -0.99}};
  const ScanReport& report = processAt(&pipeline, points, Vector3d::Zero());
  EXPECT_EQ(report.points_in, 16U);
  EXPECT_EQ(report.points_inserted, 4U);
  EXPECT_EQ(dropped(report, PointDrop::kNotFinite), 4U);
  EXPECT_EQ(dropped(report, PointDrop::kTooNear), 2U);
  EXPECT_EQ(dropped(report, PointDrop::kTooFar), 2U);
  EXPECT_EQ(dropped(report, PointDrop::kOutsideMap), 4U);
  EXPECT_EQ(dropped(report, PointDrop::kSaturated), 0U);
  expectConsistent(pipeline, points.size());
  for (const PointLabel& label : pipeline.pointLabels()) EXPECT_EQ(label.label, kUnknownLabel);
}

TEST(TerrainPipeline, SaturatedPointsAreCountedAndStillLabelled) {
  TerrainPipeline pipeline({}, handModel());
  TestRandom random(1);
  std::vector<Vector3d> points;
  for (int i = 0; i < 4000; ++i) {
    // A stick along y: one voxel full, its neighbours not.
    const double y = i < 3000 ? random.real(0.01, 0.09) : random.real(-0.4, 0.5);
    points.push_back(stepMiddle({2.05, y, 0.05}));
  }
  const ScanReport& report = processAt(&pipeline, points, Vector3d::Zero());
  const std::size_t cap = maxPointsPerVoxel(6);
  EXPECT_GE(dropped(report, PointDrop::kSaturated), 3000 - cap);
  EXPECT_EQ(pipeline.map().find({20, 0, 0})->count(), cap);
  expectConsistent(pipeline, points.size());
  EXPECT_EQ(pipeline.pointLabels()[2999].label, kLinearLabel);
}

TEST(TerrainPipeline, ThinSupportIsUnknown) {
  TerrainConfig config;
  config.min_support_points = 5;
  for (const int count : {1, 2, 3, 4, 5}) {
    TerrainPipeline pipeline(config, handModel());
    std::vector<Vector3d> points;
    for (int i = 0; i < count; ++i) points.emplace_back(3.0 + 0.1 * i, 0.01 * (i % 2), 0.5);
    processAt(&pipeline, points, Vector3d::Zero());
    for (const PointLabel& label : pipeline.pointLabels()) {
      EXPECT_EQ(label.label != kUnknownLabel, count == 5) << count;
      EXPECT_EQ(label.confidence > 0.0F, count == 5) << count;
    }
  }
  // Enough points, but all in one place: they span nothing.
  TerrainPipeline pipeline(config, handModel());
  processAt(&pipeline, std::vector<Vector3d>(50, Vector3d(3, 0, 0.5)), Vector3d::Zero());
  EXPECT_EQ(pipeline.report().points_inserted, 50U);
  EXPECT_EQ(pipeline.report().label_counts[kUnknownLabel], 50U);
}

TEST(TerrainPipeline, AMillionMetresAwayNothingChanges) {
  TerrainPipeline near({}, handModel());
  TerrainPipeline far({}, handModel());
  const MixedScene scene;
  processAt(&near, scene.points, Vector3d::Zero());
  const Vector3d away(1e6, -1e6, 1000);
  processAt(&far, scene.points, away);
  EXPECT_EQ(near.report().dropped, far.report().dropped);
  expectSameLabels(near, far);
  ASSERT_EQ(near.map().occupied(), far.map().occupied());
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    const CellId a = near.pointCells()[i];
    const CellId b = far.pointCells()[i];
    ASSERT_EQ(a == kNoCell, b == kNoCell);
    if (a == kNoCell) continue;
    ASSERT_NO_FATAL_FAILURE(
        expectSame(near.saliency(near.map().slotOf(a)), far.saliency(far.map().slotOf(b))));
  }
}

TEST(TerrainPipeline, AnyNumberOfThreadsGivesTheSameBits) {
  TerrainPipeline one({}, handModel());
  for (const int threads : {2, 5}) {
    TerrainConfig config;
    config.threads = threads;
    TerrainPipeline many(config, handModel());
    one.reset();
    for (int scan = 0; scan < 3; ++scan) {
      const MixedScene scene(scan);
      const Vector3d place(0.7 * scan, -0.3 * scan, 0.1 * scan);
      processAt(&one, scene.points, place);
      processAt(&many, scene.points, place);
      ASSERT_NO_FATAL_FAILURE(expectSameVoxels(one, many));
      ASSERT_NO_FATAL_FAILURE(expectSameLabels(one, many));
    }
  }
}

/// A random walk of the vehicle, with all points that ought to be in the map.
class Walk {
 public:
  explicit Walk(const TerrainConfig& config) : config_(config), pipeline_(config, handModel()) {}

  const TerrainPipeline& pipeline() const { return pipeline_; }

  void scanAt(const Vector3d& p_map_vehicle) {
    std::vector<Vector3d> scan;
    for (int i = 0; i < 600; ++i) {
      const double x = random_.real(-4, 4);
      const double y = random_.real(-4, 4);
      const double z = i % 3 == 0 ? random_.real(-1.5, 1.5) : 0.1 * std::sin(x);
      scan.push_back(stepMiddle({x, y, z}));
    }
    // The sensor sits on a voxel corner, so that points stay in the middles of steps.
    processAt(&pipeline_, scan, p_map_vehicle);
    forgetOutside();
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (pipeline_.pointCells()[i] != kNoCell) inside_.push_back(scan[i] + p_map_vehicle);
    }
  }
  /// A new pipeline, fed with the points still inside in another order, agrees bit by bit.
  void expectEqualsFreshPipeline(const Vector3d& p_map_vehicle) {
    TerrainPipeline fresh(config_, handModel());
    Isometry3d T_map_sensor = Isometry3d::Identity();
    T_map_sensor.translation() = p_map_vehicle + Vector3d(0, 0, -50);
    std::vector<Vector3d> p_sensor;
    for (const Vector3d& p_map : inside_) p_sensor.push_back(p_map - T_map_sensor.translation());
    std::reverse(p_sensor.begin(), p_sensor.end());
    processPoints(&fresh, test::xyzCloud(p_sensor), T_map_sensor, p_map_vehicle);
    ASSERT_EQ(fresh.report().points_inserted, inside_.size());
    ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline_, fresh));
  }

 private:
  void forgetOutside() {
    const VoxelIndex& min = pipeline_.map().minCorner();
    const MapShape& shape = pipeline_.map().shape();
    const auto outside = [&](const Vector3d& p) {
      const double x = std::floor(p.x() / 0.1) - min.x;
      const double y = std::floor(p.y() / 0.1) - min.y;
      const double z = std::floor(p.z() / 0.1) - min.z;
      return x < 0 || x >= shape.nx || y < 0 || y >= shape.ny || z < 0 || z >= shape.nz;
    };
    inside_.erase(std::remove_if(inside_.begin(), inside_.end(), outside), inside_.end());
  }

  TerrainConfig config_;
  TerrainPipeline pipeline_;
  TestRandom random_{11};
  std::vector<Vector3d> inside_;
};

TEST(TerrainPipeline, ALongWalkEqualsRecomputingFromScratch) {
  TerrainConfig config;
  config.map_size_x_m = 6.0;
  config.map_size_y_m = 5.0;
  config.map_size_z_m = 2.0;
  Walk walk(config);
  TestRandom random(12);
  Vector3d place(0, 0, 0);
  const auto step = [&](int64_t voxels) {
    return 0.1 * static_cast<double>(random.integer(-voxels, voxels));
  };
  for (int i = 0; i < 60; ++i) {
    const int64_t reach = i % 20 == 19 ? 5000 : i % 7 == 6 ? 40 : 3;
    const double dx = step(reach);
    const double dy = step(reach);
    place += Vector3d(dx, dy, step(std::min<int64_t>(reach, 8)));
    place = (place * 10.0).array().round().matrix() / 10.0;
    walk.scanAt(place);
    ASSERT_NO_FATAL_FAILURE(expectConsistent(walk.pipeline(), 600));
    ASSERT_NO_FATAL_FAILURE(walk.expectEqualsFreshPipeline(place)) << "scan " << i;
  }
}

TEST(TerrainPipeline, AJumpFartherThanTheMapForgetsEverything) {
  TerrainPipeline pipeline({}, handModel());
  TerrainPipeline fresh({}, handModel());
  processAt(&pipeline, MixedScene(1).points, Vector3d::Zero());
  const Vector3d away(5000, -20, 0);
  processAt(&pipeline, MixedScene(2).points, away);
  processAt(&fresh, MixedScene(2).points, away);
  expectSameVoxels(pipeline, fresh);
  expectSameLabels(pipeline, fresh);
}

TEST(TerrainPipeline, ResetForgetsEverything) {
  TerrainPipeline pipeline({}, handModel());
  processAt(&pipeline, MixedScene(1).points, Vector3d(3, 4, 0));
  pipeline.reset();
  EXPECT_EQ(pipeline.map().occupied(), 0U);
  EXPECT_TRUE(pipeline.pointLabels().empty());
  EXPECT_EQ(pipeline.report().points_in, 0U);
  TerrainPipeline fresh({}, handModel());
  processAt(&pipeline, MixedScene(2).points, Vector3d::Zero());
  processAt(&fresh, MixedScene(2).points, Vector3d::Zero());
  expectSameVoxels(pipeline, fresh);
}

TEST(TerrainPipeline, AnEmptyCloudKeepsTheMapAndScrollsIt) {
  TerrainPipeline pipeline({}, handModel());
  processAt(&pipeline, {}, Vector3d::Zero());
  expectConsistent(pipeline, 0);
  EXPECT_EQ(pipeline.report().label_counts, std::vector<std::size_t>(4, 0));
  processAt(&pipeline, MixedScene().points, Vector3d::Zero());
  const std::size_t occupied = pipeline.map().occupied();
  processAt(&pipeline, {}, Vector3d(0.2, 0, 0));
  expectConsistent(pipeline, 0);
  EXPECT_EQ(pipeline.map().occupied(), occupied);
  processAt(&pipeline, {}, Vector3d(500, 0, 0));
  expectConsistent(pipeline, 0);
  EXPECT_EQ(pipeline.map().occupied(), 0U);
}

TEST(TerrainPipeline, SmoothingTakesTimeAndRemovesWhatStandsAlone) {
  TerrainConfig config;
  TerrainPipeline smooth(config, handModel());
  config.smooth_labels = false;
  TerrainPipeline rough(config, handModel());
  const MixedScene scene;
  processAt(&smooth, scene.points, Vector3d::Zero());
  processAt(&rough, scene.points, Vector3d::Zero());
  EXPECT_GT(smooth.report().stage_ms[static_cast<int>(Stage::kSmooth)], 0.01);
  EXPECT_LT(rough.report().stage_ms[static_cast<int>(Stage::kSmooth)], 0.01);
  EXPECT_GT(smooth.report().memory_bytes, rough.report().memory_bytes);
  // Leaves, of which some are taken for something else.
  const double before = shareOf(rough, 21000, 25000, kScatterLabel);
  EXPECT_LT(before, 1.0);
  EXPECT_GT(shareOf(smooth, 21000, 25000, kScatterLabel), before);
  EXPECT_EQ(smooth.report().label_counts[kUnknownLabel],
            rough.report().label_counts[kUnknownLabel]);
  ASSERT_EQ(listVoxels(smooth.map()).size(), listVoxels(rough.map()).size());
  for (const auto& [voxel, slot] : listVoxels(smooth.map())) {
    ASSERT_NO_FATAL_FAILURE(expectSame(smooth.saliency(slot), rough.saliency(slot)));
  }
}

TEST(TerrainPipeline, UpdatingAllVoxelsChangesNothing) {
  for (const bool smooth : {true, false}) {
    TerrainConfig config;
    config.smooth_labels = smooth;
    config.threads = 2;
    TerrainPipeline pipeline(config, handModel());
    TerrainPipeline updated(config, handModel());
    updated.updateAllVoxels();  // of an empty map
    for (int scan = 0; scan < 3; ++scan) {
      const Vector3d place(1.3 * scan, -0.4 * scan, 0.1 * scan);
      processAt(&pipeline, MixedScene(scan).points, place);
      processAt(&updated, MixedScene(scan).points, place);
      updated.updateAllVoxels();
      ASSERT_NO_FATAL_FAILURE(expectSameVoxels(pipeline, updated));
    }
  }
}

TEST(TerrainPipeline, TheMapIsCentredOnTheVehicle) {
  TerrainConfig config;
  TerrainPipeline pipeline(config, handModel());
  processAt(&pipeline, {}, Vector3d(-7.31, 12.05, 0.98));
  // Vehicle voxel (-74, 120, 9); the middle is 0.5 m higher.
  EXPECT_EQ(pipeline.map().minCorner(), (VoxelIndex{-174, 20, -1}));
}

TEST(TerrainPipeline, TurnedSensorsPutPointsWhereTheyAre) {
  Isometry3d T_map_sensor = Isometry3d::Identity();
  T_map_sensor.linear() =
      (Eigen::AngleAxisd(1.2, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.7, Vector3d::UnitX()))
          .toRotationMatrix();
  T_map_sensor.translation() = Vector3d(3, -2, 1);
  TerrainPipeline pipeline({}, handModel());
  const Vector3d p_map(5.05, -3.05, 0.55);
  const auto cloud = test::xyzCloud({T_map_sensor.inverse() * p_map});
  processPoints(&pipeline, cloud, T_map_sensor, Vector3d::Zero());
  EXPECT_EQ(pipeline.report().points_inserted, 1U);
  EXPECT_NE(pipeline.map().find({50, -31, 5}), nullptr);
}

/// A wall seen by a sensor that drives towards it and turns, one point at a time.
class MovingWall {
 public:
  MovingWall() {
    TestRandom random(1);
    for (int i = 0; i < kPoints; ++i) {
      const double y = random.real(-4, 4);
      const Vector3d p_map(kWall_m, y, random.real(-0.9, 1.9));
      offsets_s.push_back(static_cast<float>(0.1 * i / kPoints - 0.05));
      p_sensor.push_back(motion.poseAt(offsets_s.back()).inverse() * p_map);
    }
  }

  static constexpr int kPoints = 8000;
  static constexpr double kWall_m = 6.05;  // the middle of a voxel
  SensorMotion motion{{{-0.05, pose(0.0, -0.05)}, {0.05, pose(1.0, 0.05)}}};
  std::vector<float> offsets_s;
  std::vector<Vector3d> p_sensor;

 private:
  static Isometry3d pose(double x, double yaw_rad) {
    Isometry3d T = Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
    T.translation().x() = x;
    return T;
  }
};

double greatestDistanceFromWall(const TerrainPipeline& pipeline) {
  double greatest = 0.0;
  pipeline.map().forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
    const FixedPoint center = centerOf(voxel);
    const CenteredMoments m = pipeline.map().record(slot).about(center);
    const double mean =
        static_cast<double>(center.x) + static_cast<double>(m.x) / static_cast<double>(m.n) + 0.5;
    greatest = std::max(greatest, std::abs(mean / 2560.0 - MovingWall::kWall_m));
  });
  return greatest;
}

TEST(TerrainPipeline, MotionCompensationRebuildsAWall) {
  const MovingWall wall;
  const auto cloud = test::xyzCloud(wall.p_sensor);
  std::string error;
  const auto fields = findPointFields(cloud.view(), &error);
  TerrainPipeline compensated({}, handModel());
  compensated.process(cloud.view(), *fields, wall.offsets_s, wall.motion, Vector3d::Zero());
  EXPECT_EQ(compensated.report().points_inserted, std::size_t{MovingWall::kPoints});
  EXPECT_LT(greatestDistanceFromWall(compensated), 0.002);
  EXPECT_GT(shareOf(compensated, 0, MovingWall::kPoints, kSurfaceLabel), 0.99);
  TerrainPipeline smeared({}, handModel());
  smeared.process(cloud.view(), *fields, {}, wall.motion, Vector3d::Zero());
  EXPECT_GT(greatestDistanceFromWall(smeared), 0.2);
}

TEST(TerrainPipeline, ManyScansNeedNoMoreMemoryThanTheFirstLaps) {
  TerrainPipeline pipeline({}, handModel());
  std::vector<std::size_t> bytes;
  for (int scan = 0; scan < 60; ++scan) {
    processAt(&pipeline, MixedScene(scan % 5).points, Vector3d(scan % 10, 0, 0));
    if (scan % 10 == 9) bytes.push_back(pipeline.report().memory_bytes);
  }
  EXPECT_EQ(bytes.back(), bytes[3]);
}

TEST(Names, OfDropsAndStagesAreUnique) {
  std::set<std::string> names;
  for (int i = 0; i < kPointDrops; ++i) names.insert(pointDropName(static_cast<PointDrop>(i)));
  for (int i = 0; i < kStages; ++i) names.insert(stageName(static_cast<Stage>(i)));
  EXPECT_STREQ(stageName(Stage::kSmooth), "smooth");
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kPointDrops + kStages));
  EXPECT_EQ(names.count(""), 0U);
}

}  // namespace
}  // namespace ladar_perception
