// SPDX-License-Identifier: BSD-3-Clause
// terrain_and_poses.launch: in one manager, terrain's labels steer the re-sampling.
#include <ros/service_manager.h>

#include <algorithm>

#include "ros_pose_client.h"

namespace ladar_perception::test {
namespace {

constexpr int kScans = 10;

/// Share of the points of a true class.
double shareOf(const sensor_msgs::PointCloud2& cloud, uint8_t label) {
  const std::vector<double> truth = fieldValues(cloud, "truth");
  const auto count = std::count(truth.begin(), truth.end(), static_cast<double>(label));
  return truth.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(truth.size());
}

TEST(TerrainAndPoses, LabelsSteerTheSamples) {
  TerrainClient terrain("/terrain");
  PoseClient poses("/pose_resampler");
  ASSERT_TRUE(terrain.connected());
  ASSERT_TRUE(poses.hears());
  terrain.sendMount();
  const Drive drive;
  EXPECT_EQ(terrain.labelScans(drive, 0, kScans), kScans);
  ASSERT_TRUE(poses.waitForStatistics([](const auto& s) {
    return s.scans + sumOf(s.scans_dropped) == kScans && s.poses_waiting == 0;
  }));
  const PoseResamplerStatistics& s = poses.statistics;
  expectAccounted(s);
  EXPECT_EQ(sumOf(s.scans_dropped), 0U);
  EXPECT_EQ(sumOf(s.poses_dropped), 0U);
  ASSERT_TRUE(waitFor([&] { return poses.poses.size() == 4 && poses.clouds.size() == 4; }));
  for (const auto& pose : poses.poses) {
    const sensor_msgs::PointCloud2& cloud = pose->cloud;
    EXPECT_EQ(std::size_t{cloud.width} * cloud.height, 800U);
    const sensor_msgs::PointCloud2 raw = drive.scan(static_cast<int>(3 * pose->id));
    // The wire is 12 m long and as thin as a sample's distance to the next; leaves are asked for a
    // tenth as densely as everything else.
    EXPECT_GT(shareOf(cloud, kLinearLabel), 0.04);
    EXPECT_LT(shareOf(cloud, kScatterLabel), 0.5 * shareOf(raw, kScatterLabel));
    // Labels came along, and are right.
    const std::vector<double> label = fieldValues(cloud, "label");
    const std::vector<double> truth = fieldValues(cloud, "truth");
    ASSERT_EQ(label.size(), 800U);
    int right = 0;
    for (std::size_t i = 0; i < label.size(); ++i) right += label[i] == truth[i] ? 1 : 0;
    EXPECT_GT(right, 700);
    EXPECT_EQ(fieldValues(cloud, "confidence").size(), 800U);
  }
}

TEST(TerrainAndPoses, BothAreInOneManager) {
  const auto processOf = [](const std::string& service) {
    std::string host;
    uint32_t port = 0;
    EXPECT_TRUE(ros::service::exists(service, false)) << service;
    EXPECT_TRUE(ros::ServiceManager::instance()->lookupService(service, host, port)) << service;
    return port;
  };
  EXPECT_EQ(processOf("/terrain/reset"), processOf("/pose_resampler/reset"));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "terrain_and_poses_test");
}
