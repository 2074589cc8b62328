// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "ladar_perception/sim/true_cloud.h"

namespace ladar_perception::sim {
namespace {

TrueCloudConfig smallConfig() {
  TrueCloudConfig config;
  config.points = 12000;
  return config;
}

const World& campus() {
  static const World world = makeWorld("campus", 1);
  return world;
}

const Eigen::Vector3d& sensor() {
  static const Eigen::Vector3d p_world = placeBesideTrack(campus(), 152.0, -4.5, 1.7);
  return p_world;
}

TEST(SimTrueCloud, HasAboutAsManyPointsAsWanted) {
  for (const int points : {3000, 12000, 50000}) {
    TrueCloudConfig config;
    config.points = points;
    const auto cloud = takeTrueCloud(campus().scene, sensor(), config, 1);
    EXPECT_NEAR(static_cast<double>(cloud.size()), points, 0.03 * points);
  }
}

TEST(SimTrueCloud, TruthIsOnTheSurfaceAndNoiseAlongTheBeam) {
  TrueCloudConfig config = smallConfig();
  config.range_sigma_m = 0.03;
  const auto cloud = takeTrueCloud(campus().scene, sensor(), config, 1);
  double squares = 0.0;
  for (const TruePoint& point : cloud) {
    const Eigen::Vector3d beam = point.p_true_m.normalized();
    const double error_m = (point.p_m - point.p_true_m).dot(beam);
    EXPECT_NEAR((point.p_m - point.p_true_m).norm(), std::abs(error_m), 1e-9);
    EXPECT_NEAR(point.normal.norm(), 1.0, 1e-5);
    EXPECT_LT(point.normal.dot(beam), 1e-3) << "surfaces are seen from their outside";
    EXPECT_LE(point.p_true_m.norm(), config.max_range_m);
    squares += error_m * error_m;
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(cloud.size())), 0.03, 0.001);
  for (std::size_t i = 0; i < cloud.size(); i += 40) {
    const Eigen::Vector3d p_world = sensor() + cloud[i].p_true_m;
    EXPECT_LT(campus().scene.nearestSurface(p_world).distance_m, 1e-4);
  }
}

TEST(SimTrueCloud, SeesWhatTheControlVolumesNeed) {
  TrueCloudConfig config = smallConfig();
  config.range_sigma_m = 0.0;
  const auto cloud = takeTrueCloud(campus().scene, sensor(), config, 1);
  std::map<Label, int> counts;
  int flat = 0;
  for (const TruePoint& point : cloud) {
    EXPECT_EQ(point.p_m, point.p_true_m);
    if (point.p_m.norm() < 15.0) ++counts[point.label];
    flat += point.face != 0 ? 1 : 0;
  }
  EXPECT_GT(counts[Label::kPavement], 1000);
  EXPECT_GT(counts[Label::kTube], 100) << "bicycles and their stand";
  EXPECT_GT(counts[Label::kFacade], 1000);
  EXPECT_GT(counts[Label::kFoliage], 100);
  EXPECT_GT(flat, 1000);
}

TEST(SimTrueCloud, SameSeedSameCloud) {
  const auto a = takeTrueCloud(campus().scene, sensor(), smallConfig(), 7);
  const auto b = takeTrueCloud(campus().scene, sensor(), smallConfig(), 7);
  const auto c = takeTrueCloud(campus().scene, sensor(), smallConfig(), 8);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i].p_m, b[i].p_m);
  EXPECT_NE(a.front().p_m, c.front().p_m);
}

TEST(SimTrueCloud, SeesNothingInAnEmptyScene) {
  Scene nothing{HeightField()};
  nothing.finish();
  EXPECT_TRUE(takeTrueCloud(nothing, {0, 0, 1}, smallConfig(), 1).empty());
}

TEST(SimTrueCloud, RefusesWhatMakesNoSense) {
  EXPECT_TRUE(TrueCloudConfig().validate().empty());
  TrueCloudConfig config;
  config.points = 10;
  config.low_deg = 50.0;
  config.high_deg = 91.0;
  config.max_range_m = 0.0;
  config.range_sigma_m = std::nan("");
  EXPECT_EQ(config.validate().size(), 4u);  // low_deg lies below high_deg
  config.low_deg = 91.5;
  EXPECT_EQ(config.validate().size(), 5u);
}

}  // namespace
}  // namespace ladar_perception::sim
