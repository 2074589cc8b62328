// SPDX-License-Identifier: BSD-3-Clause
// Time that jumps back, as with a bag that loops: one reset, said once, and labels go on.
#include <rosgraph_msgs/Clock.h>

#include "ros_terrain_client.h"

namespace ladar_perception::test {
namespace {

constexpr double kDensity = 0.25;
constexpr int kScans = 15;  // 1.5 s
const ParamMap kParameters = {{"tf_timeout_s", 2.0}};

class TimeJump : public testing::Test {
 protected:
  TimeJump() { clock_ = ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", 100); }

  void setClock(const ros::Time& time) {
    rosgraph_msgs::Clock clock;
    clock.clock = time;
    clock_.publish(clock);
  }
  /// Whether a scan was labelled; a scan at the seam of two turns may wait for tf in vain.
  static bool labelOrDrop(TerrainClient* client, const sensor_msgs::PointCloud2& scan) {
    const std::size_t labels = client->labeled.size();
    const uint64_t drops = sumOf(client->statistics.scans_dropped);
    client->send(scan);
    waitFor([&] {
      return client->labeled.size() > labels || sumOf(client->statistics.scans_dropped) > drops;
    });
    return client->labeled.size() > labels &&
           client->labeled.back()->header.stamp == scan.header.stamp;
  }
  /// One turn of a loop: clock, transforms and scans as they were recorded.
  int play(TerrainClient* client, int begin, int end, bool with_clock) {
    int labeled = 0;
    for (int i = begin; i < end; ++i) {
      if (with_clock) {
        setClock(drive_.scanStamp(i));
        // tf's listeners notice a jump by the clock they have when a transform comes.
        waitFor([] { return false; }, 0.02);
      }
      client->send(drive_.vehicleTransforms(i, i + 1));
      labeled += labelOrDrop(client, drive_.scan(i, kDensity)) ? 1 : 0;
    }
    return labeled;
  }
  /// Resets that were counted and those that were said, once both have had time to come.
  static void expectResets(TerrainClient* client, const LogListener& log, uint32_t resets) {
    const uint64_t scans = client->statistics.scans;
    waitFor([&] {
      return client->statistics.resets >= resets &&
             log.count("jumped back") >= static_cast<int>(resets);
    });
    // One more report: what would be one too many is in it.
    client->waitForStatistics([&](const auto& s) { return s.scans >= scans; });
    waitFor([] { return false; }, 0.2);
    EXPECT_EQ(client->statistics.resets, resets);
    EXPECT_EQ(log.count("jumped back"), static_cast<int>(resets));
  }

  Drive drive_;
  ros::Publisher clock_;
};

TEST_F(TimeJump, ALoopResetsTheMapOnce) {
  LogListener log;
  LoadedTerrain terrain("/looped", kParameters);
  ASSERT_TRUE(terrain.ready());
  terrain->sendMount();
  EXPECT_EQ(play(&*terrain, 0, kScans, true), kScans);
  const uint64_t points = drive_.cloud(0, kDensity).layout.pointCount();
  ASSERT_TRUE(terrain->waitForStatistics([](const auto& s) { return s.scans == kScans; }));
  expectResets(&*terrain, log, 0);

  // Transforms at the seam may be lost with the buffer, the scans after it must not be.
  const int labeled = play(&*terrain, 0, kScans, true);
  EXPECT_GE(labeled, kScans - 1);
  ASSERT_TRUE(terrain->waitForStatistics([](const auto& s) {
    return s.scans + sumOf(s.scans_dropped) == 2 * kScans;
  }));
  EXPECT_EQ(terrain->statistics.points_in, 2 * kScans * points);
  expectResets(&*terrain, log, 1);
  // The map of the second turn is the map of the first, not both.
  EXPECT_GT(recallOf(*terrain->labeled.back(), kSurfaceLabel), 0.9);

  EXPECT_GE(play(&*terrain, 0, kScans, true), kScans - 1);
  expectResets(&*terrain, log, 2);
}

TEST_F(TimeJump, StampsAloneMayJump) {
  // A driver whose clock was set back: /clock goes on, so tf keeps transforms of the future.
  LogListener log;
  LoadedTerrain terrain("/stamps", kParameters);
  ASSERT_TRUE(terrain.ready());
  terrain->sendMount();
  setClock(drive_.scanStamp(0));
  EXPECT_EQ(play(&*terrain, 0, kScans, false), kScans);
  EXPECT_GE(play(&*terrain, 0, kScans, false), kScans - 1);
  expectResets(&*terrain, log, 1);
}

TEST_F(TimeJump, FarJumpsAreNoDifferent) {
  // Farther than tf's cache of 10 s, where it refuses what is older.
  LogListener log;
  LoadedTerrain terrain("/far", kParameters);
  ASSERT_TRUE(terrain.ready());
  terrain->sendMount();
  setClock(drive_.scanStamp(0));
  EXPECT_EQ(play(&*terrain, 300, 304, false), 4);
  EXPECT_GE(play(&*terrain, 0, 6, false), 4);
  expectResets(&*terrain, log, 1);
}

TEST_F(TimeJump, SensorsTakeTurnsWithoutReset) {
  // The rear ladar's scans come last but were stamped first; each sensor's own time goes forward.
  LogListener log;
  LoadedTerrain terrain("/two", kParameters);
  ASSERT_TRUE(terrain.ready());
  terrain->sendMount({"front", "rear"});
  const auto playBoth = [&](int scans) {
    int labeled = 0;
    for (int i = 0; i < scans; ++i) {
      terrain->send(drive_.vehicleTransforms(i, i + 1));
      sensor_msgs::PointCloud2 front = drive_.scan(i, kDensity);
      front.header.frame_id = "front";
      sensor_msgs::PointCloud2 rear = drive_.scan(i, kDensity);
      rear.header.frame_id = "rear";
      rear.header.stamp -= ros::Duration(0.03);
      labeled += labelOrDrop(&*terrain, front) ? 1 : 0;
      labeled += labelOrDrop(&*terrain, rear) ? 1 : 0;
    }
    return labeled;
  };
  setClock(drive_.scanStamp(0));
  EXPECT_EQ(playBoth(kScans), 2 * kScans);
  expectResets(&*terrain, log, 0);
  // Both jump, which is one jump.
  setClock(drive_.scanStamp(0) - ros::Duration(100.0));
  waitFor([] { return false; }, 0.02);
  EXPECT_GE(playBoth(kScans), 2 * kScans - 2);
  expectResets(&*terrain, log, 1);
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "time_jump_test");
}
