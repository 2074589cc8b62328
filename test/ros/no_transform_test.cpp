// SPDX-License-Identifier: BSD-3-Clause
// Scans without transforms: they wait, are dropped and counted, and hold nobody else up.
#include "ros_terrain_client.h"

namespace ladar_perception::test {
namespace {

constexpr double kDensity = 0.25;

TEST(NoTransform, ScansAreDroppedAndCountedUntilItComes) {
  LogListener log;
  LoadedTerrain terrain("/late", {{"tf_timeout_s", 0.2}, {"queue_size", 10}});
  ASSERT_TRUE(terrain.ready());
  const Drive drive;
  const uint64_t points = drive.cloud(0, kDensity).layout.pointCount();
  for (int i = 0; i < 3; ++i) terrain->send(drive.scan(i, kDensity));
  ASSERT_TRUE(terrain->waitForStatistics([](const auto& s) {
    return countOf(s.scans_dropped, "no_transform") == 3;
  }));
  EXPECT_EQ(terrain->statistics.scans, 0U);
  EXPECT_EQ(terrain->statistics.points_in, 3 * points);
  EXPECT_EQ(terrain->statistics.points_inserted, 0U);
  EXPECT_EQ(countOf(terrain->statistics.points_dropped, "no_transform"), 3 * points);
  EXPECT_TRUE(terrain->labeled.empty());

  // The warning names topic, stamp, frame and reason, and is not repeated for every scan.
  ASSERT_TRUE(waitFor([&] { return log.count("no_transform") > 0; }));
  const std::string warning = log.find("no_transform");
  for (const char* part : {"/late/points", "1000.000", kSensorFrame, kMapFrame}) {
    EXPECT_NE(warning.find(part), std::string::npos) << part << " in: " << warning;
  }
  EXPECT_EQ(log.count("no_transform"), 1);
  EXPECT_LT(warning.size(), 500U) << "readable at a glance";

  terrain->sendMount();
  terrain->send(drive.vehicleTransforms(3, 6));
  // 0.2 s may be too short for tf on a busy machine, but not again and again.
  bool labeled = false;
  for (int i = 3; i < 6 && !labeled; ++i) {
    labeled = terrain->label(drive.scan(i, kDensity), 2.0) != nullptr;
  }
  EXPECT_TRUE(labeled);
}

TEST(NoTransform, AWaitHoldsNobodyElseUp) {
  // One nodelet waits 10 s for a frame that never comes; the manager has one thread.
  LoadedTerrain waiting("/waiting", {{"tf_timeout_s", 10.0}});
  ASSERT_TRUE(waiting.ready());
  LoadedTerrain other("/other");
  ASSERT_TRUE(other.ready());
  const Drive drive;
  sensor_msgs::PointCloud2 lost = drive.scan(0, kDensity);
  lost.header.frame_id = "nowhere";
  const ros::WallTime begin = ros::WallTime::now();
  waiting->send(lost);
  const auto elapsed_s = [&] { return (ros::WallTime::now() - begin).toSec(); };

  other->sendMount();
  EXPECT_EQ(other->labelScans(drive, 0, 3, kDensity), 3);
  EXPECT_LT(elapsed_s(), 6.0) << "the other nodelet's scans came late";
  EXPECT_TRUE(waiting->reset());
  EXPECT_LT(elapsed_s(), 7.0) << "~reset waited for tf";
  other->send(drive.vehicleTransforms(3, 4));
  EXPECT_TRUE(other->label(drive.scan(3, kDensity)));
  EXPECT_LT(elapsed_s(), 8.0) << "~reset held the manager's only thread up";
  EXPECT_EQ(sumOf(waiting->statistics.scans_dropped), 0U) << "the scan did not wait at all";
}

TEST(NoTransform, UnloadingDoesNotWaitForIt) {
  const ros::WallTime begin = ros::WallTime::now();
  {
    LoadedTerrain terrain("/unloaded", {{"tf_timeout_s", 10.0}, {"queue_size", 10}});
    ASSERT_TRUE(terrain.ready());
    const Drive drive;
    for (int i = 0; i < 3; ++i) terrain->send(drive.scan(i, kDensity));
  }
  EXPECT_LT((ros::WallTime::now() - begin).toSec(), 8.0);
}

TEST(NoTransform, AFullQueueDropsTheOldestAndCountsThem) {
  constexpr uint64_t kScans = 60;
  LoadedTerrain terrain("/flood", {{"tf_timeout_s", 0.3}, {"queue_size", 1}});
  ASSERT_TRUE(terrain.ready());
  const Drive drive;
  std::vector<sensor_msgs::PointCloud2> scans;
  for (uint64_t i = 0; i < kScans; ++i) scans.push_back(drive.scan(static_cast<int>(i), kDensity));
  uint64_t points = 0;
  for (const auto& scan : scans) {
    terrain->send(scan);
    points += uint64_t{scan.width} * scan.height;
  }
  // Every scan is accounted for.
  EXPECT_TRUE(terrain->waitForStatistics(
      [&](const auto& s) { return s.scans + sumOf(s.scans_dropped) == kScans; }, 10.0))
      << "of " << kScans << " scans " << sumOf(terrain->statistics.scans_dropped)
      << " were counted as dropped, " << terrain->statistics.scans << " as labelled";
  const TerrainStatistics s = terrain->statistics;
  EXPECT_EQ(s.points_in, points);
  EXPECT_EQ(s.points_in, s.points_inserted + sumOf(s.points_dropped));
  EXPECT_GT(countOf(s.scans_dropped, "queue_full"), kScans / 2);
  // The newest is what is left: it is dropped for want of tf, not of room.
  EXPECT_GE(countOf(s.scans_dropped, "no_transform"), 1U);
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "no_transform_test");
}
