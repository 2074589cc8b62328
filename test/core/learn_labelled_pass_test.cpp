// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <map>

#include "hand_model.h"
#include "io_test_files.h"
#include "ladar_perception/learn/labelled_pass.h"
#include "terrain_scenes.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::handModel;
using Points = std::vector<Vector3d>;

Scan scanOf(const Points& points) {
  std::vector<Column> columns;
  for (int axis = 0; axis < 3; ++axis) {
    columns.push_back({std::string(1, "xyz"[axis]), ScalarType::kFloat64, {}});
    for (const Vector3d& p : points) columns.back().values.push_back(p[axis]);
  }
  return makeScan(columns);
}

struct Seen {
  int times = 0;
  bool in_map = false;
  PointLabel label;
  std::vector<float> features;
};

/// What becomes of every point. Points are told apart by their truth, which is their number from 1.
std::map<std::size_t, Seen> runPass(const Points& points, Pass pass,
                                    const TerrainConfig& config = {}, int* scans = nullptr) {
  std::vector<double> truth;
  for (std::size_t i = 0; i < points.size(); ++i) truth.push_back(static_cast<double>(i + 1));
  std::map<std::size_t, Seen> seen;
  runLabelledPass(scanOf(points), truth, pass, config, handModel(), "test",
                  [&](const TerrainPipeline& pipeline, const std::vector<double>& scan_truth) {
                    if (scans != nullptr) ++*scans;
                    EXPECT_EQ(scan_truth.size(), pipeline.pointCells().size());
                    for (std::size_t i = 0; i < scan_truth.size(); ++i) {
                      if (scan_truth[i] == 0.0) continue;
                      Seen& one = seen[static_cast<std::size_t>(scan_truth[i]) - 1];
                      ++one.times;
                      const CellId cell = pipeline.pointCells()[i];
                      one.in_map = cell != kNoCell;
                      one.label = pipeline.pointLabels()[i];
                      if (!one.in_map) continue;
                      const float* values = pipeline.features(pipeline.map().slotOf(cell));
                      one.features.assign(values, values + 3);
                    }
                  });
  return seen;
}

void expectAllOnce(const std::map<std::size_t, Seen>& seen, std::size_t points) {
  ASSERT_EQ(seen.size(), points);
  for (const auto& [i, one] : seen) ASSERT_EQ(one.times, 1) << i;
}

Points moved(Points points, const Vector3d& by) {
  for (Vector3d& p : points) p += by;
  return points;
}

TEST(LearnLabelledPass, WholeHoldsEveryPoint) {
  // Points at the very origin, where a sensor would see itself, too.
  const Points points = test::MixedScene().points;
  int scans = 0;
  const auto seen = runPass(points, Pass::kWhole, {}, &scans);
  EXPECT_EQ(scans, 1);
  expectAllOnce(seen, points.size());
  std::size_t labelled = 0;
  for (const auto& [i, one] : seen) {
    ASSERT_TRUE(one.in_map) << i;
    labelled += one.label.label != kUnknownLabel ? 1 : 0;
  }
  EXPECT_GT(labelled, points.size() * 99 / 100);
}

TEST(LearnLabelledPass, WholeGivesWhatOneScanIntoALargeMapGives) {
  const Points points = test::MixedScene().points;
  TerrainConfig config;
  config.min_range_m = 0.0;
  config.map_size_z_m = 10.0;
  TerrainPipeline pipeline(config, handModel());
  test::processPoints(&pipeline, test::xyzCloud(points), Eigen::Isometry3d::Identity(),
                      Vector3d::Zero());
  const auto seen = runPass(points, Pass::kWhole);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(seen.at(i).label.label, pipeline.pointLabels()[i].label) << i;
    ASSERT_EQ(seen.at(i).label.confidence, pipeline.pointLabels()[i].confidence) << i;
  }
}

TEST(LearnLabelledPass, FarFromTheOriginNothingChanges) {
  const Points points = test::MixedScene().points;
  // As in UTM; whole voxels, so that points keep their places in them.
  const Points far = moved(points, {500000.0, 8400000.0, 300.0});
  for (const Pass pass : {Pass::kWhole, Pass::kStream}) {
    const auto here = runPass(points, pass);
    const auto there = runPass(far, pass);
    expectAllOnce(there, points.size());
    std::size_t differ = 0;
    for (const auto& [i, one] : here) differ += one.label.label != there.at(i).label.label;
    // A float64 so far out is no longer exact to the middle of a step.
    EXPECT_LE(differ, points.size() / 1000) << passName(pass);
  }
}

/// A path of ground with a wire beside it, longer than a map can be.
Points longRoad(double length_m) {
  test::TestRandom random(3);
  Points points;
  for (double x = 0.0; x < length_m; x += 0.1) {
    for (int i = 0; i < 4; ++i) points.push_back({x, random.real(0, 2), 0.003 * random.normal()});
    points.push_back({x, 3.0 + 0.003 * random.normal(), 1.5});
  }
  for (Vector3d& p : points) p = test::stepMiddle(p);
  return points;
}

TEST(LearnLabelledPass, PiecesOfALargeCloudFitTogether) {
  const Points points = longRoad(700.0);
  int scans = 0;
  const auto pieces = runPass(points, Pass::kWhole, {}, &scans);
  EXPECT_GE(scans, 3);
  expectAllOnce(pieces, points.size());
  // The same by parts of 50 m, each with 10 m around it.
  for (double begin = 0.0; begin < 700.0; begin += 50.0) {
    Points part;
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].x() < begin - 10.0 || points[i].x() > begin + 60.0) continue;
      part.push_back(points[i]);
      numbers.push_back(i);
    }
    const auto alone = runPass(part, Pass::kWhole);
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i].x() < begin || part[i].x() > begin + 50.0) continue;
      ASSERT_EQ(alone.at(i).features, pieces.at(numbers[i]).features) << part[i].transpose();
      ASSERT_EQ(alone.at(i).label.label, pieces.at(numbers[i]).label.label);
    }
  }
}

TEST(LearnLabelledPass, FaultyPointsAreSeenAndUnknown) {
  Points points = test::MixedScene().points;
  const std::size_t sound = points.size();
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  points.insert(points.end(), {{nan, 0, 0}, {0, inf, 0}, {1e12, 0, 0}, {0, 0, -1e300}});
  for (const Pass pass : {Pass::kWhole, Pass::kStream}) {
    const auto seen = runPass(points, pass);
    expectAllOnce(seen, points.size());
    for (std::size_t i = sound; i < points.size(); ++i) {
      EXPECT_FALSE(seen.at(i).in_map);
      EXPECT_EQ(seen.at(i).label.label, kUnknownLabel);
    }
    EXPECT_NE(seen.at(0).label.label, kUnknownLabel);
  }
  // Nothing else: they still count.
  expectAllOnce(runPass({{nan, nan, nan}, {1e12, 0, 0}}, Pass::kWhole), 2);
}

TEST(LearnLabelledPass, OfACloudTooHighForAMapTheLowerPartIsIn) {
  Points points = longRoad(30.0);
  const std::size_t low = points.size();
  points.push_back({5, 1, 90});
  points.push_back({5, 1, 250});
  points.push_back({5, 1, 9000});
  const auto seen = runPass(points, Pass::kWhole);
  expectAllOnce(seen, points.size());
  EXPECT_TRUE(seen.at(low).in_map);
  EXPECT_FALSE(seen.at(low + 1).in_map);
  EXPECT_FALSE(seen.at(low + 2).in_map);
  for (std::size_t i = 0; i < low; ++i) EXPECT_TRUE(seen.at(i).in_map);
}

TEST(LearnLabelledPass, StreamUsesTheVehiclesMap) {
  const Points points = longRoad(700.0);
  int scans = 0;
  const auto seen = runPass(points, Pass::kStream, {}, &scans);
  EXPECT_GE(scans, 2);
  expectAllOnce(seen, points.size());
  std::size_t in_map = 0;
  for (const auto& [i, one] : seen) in_map += one.in_map ? 1 : 0;
  // 10,000 points are 200 m of the road, of which a map of 20 m holds some.
  EXPECT_GT(in_map, 1000u);
  EXPECT_LT(in_map, points.size() / 4);
  TerrainConfig wide;
  wide.map_size_x_m = 400.0;
  wide.map_size_y_m = 20.0;
  wide.max_range_m = 1000.0;
  wide.min_range_m = 0.0;
  std::size_t in_wide_map = 0;
  for (const auto& [i, one] : runPass(points, Pass::kStream, wide)) in_wide_map += one.in_map;
  EXPECT_EQ(in_wide_map, points.size());
}

TEST(LearnLabelledPass, RefusesACloudWithoutPoints) {
  expectError([] { runPass({}, Pass::kWhole); }, {"no points"});
}

TEST(LearnLabelledPass, ConfigurationFollowsTheModel) {
  ClassifierModel model = handModel();
  model.voxel_size_m = 0.25;
  model.support_radius_voxels = 2;
  model.support_kernel = "gaussian";
  TerrainConfig config;
  config.min_support_points = 9;
  const TerrainConfig fitting = configFor(model, config);
  EXPECT_EQ(modelMisfit(model, fitting.voxel_size_m, fitting.support_radius_voxels,
                        fitting.support_kernel),
            "");
  EXPECT_EQ(fitting.min_support_points, 9);
  model.voxel_size_m = 0.01;
  config.map_size_x_m = 200.0;
  expectError([&] { configFor(model, config); }, {"map_size_x_m", "20000 voxels"});
}

}  // namespace
}  // namespace ladar_perception
