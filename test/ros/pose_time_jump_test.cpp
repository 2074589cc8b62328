// SPDX-License-Identifier: BSD-3-Clause
// Time that jumps back, as with a bag that loops: the path begins anew, once and said once, and no
// pose is lost.
#include <rosgraph_msgs/Clock.h>

#include "ros_pose_client.h"

namespace ladar_perception::test {
namespace {

constexpr double kDensity = 0.25;
constexpr int kScans = 15;

class PoseTimeJump : public testing::Test {
 protected:
  PoseTimeJump() { clock_ = ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", 100); }

  /// One turn of a loop: clock, transforms and scans as they were recorded.
  void play(PoseClient* client, bool with_clock) {
    for (int i = 0; i < kScans; ++i) {
      if (with_clock || i == 0) {
        rosgraph_msgs::Clock clock;
        clock.clock = drive_.scanStamp(with_clock ? i : 0);
        clock_.publish(clock);
        // tf's listeners notice a jump by the clock they have when a transform comes.
        waitFor([] { return false; }, 0.02);
      }
      client->send(drive_.vehicleTransforms(i, i + 1));
      const uint64_t done = client->scansDone();
      client->send(drive_.scan(i, kDensity));
      ASSERT_TRUE(waitFor([&] { return client->scansDone() > done; }));
    }
  }
  static void expectResets(PoseClient* client, const LogListener& log, uint32_t resets) {
    waitFor([&] {
      return client->statistics.resets >= resets &&
             log.count("jumped back") >= static_cast<int>(resets);
    });
    waitFor([] { return false; }, 0.3);  // what would be one too many has time to come
    EXPECT_EQ(client->statistics.resets, resets);
    EXPECT_EQ(log.count("jumped back"), static_cast<int>(resets));
  }

  Drive drive_;
  ros::Publisher clock_;
};

TEST_F(PoseTimeJump, EveryTurnBeginsAPath) {
  for (const bool with_clock : {true, false}) {
    SCOPED_TRACE(with_clock ? "the clock jumps" : "stamps alone jump");
    LogListener log;
    LoadedPoses poses(with_clock ? "/clock_jumps" : "/stamps_jump",
                      {{"tf_timeout_s", 2.0},
                       {"gather", std::string("until_next")},
                       {"gather_timeout_s", 1000.0}});
    ASSERT_TRUE(poses.ready());
    poses->sendMount();
    play(&*poses, with_clock);
    expectResets(&*poses, log, 0);
    ASSERT_TRUE(poses->waitForStatistics([](const auto& s) { return s.poses == 5; }));
    EXPECT_TRUE(waitFor([&] { return poses->poses.size() == 4; })) << "the fifth is being gathered";

    play(&*poses, with_clock);
    expectResets(&*poses, log, 1);
    // The pose that was being gathered at the jump is not lost, but not of the new path either.
    // Transforms at the seam may be lost with tf's buffer, so the turn may begin a scan later.
    ASSERT_TRUE(poses->waitForStatistics([](const auto& s) { return s.poses_published >= 9; }));
    ASSERT_TRUE(waitFor([&] {
      return poses->poses.size() == poses->statistics.poses_published &&
             poses->path.poses.size() + 5 == poses->poses.size();
    }));
    EXPECT_EQ(poses->poses[4]->header.stamp, drive_.scanStamp(12));
    EXPECT_EQ(poses->poses[4]->scans, 3U);
    EXPECT_LE(poses->poses[5]->header.stamp, drive_.scanStamp(1));
    EXPECT_EQ(poses->path.poses[0].header.stamp, poses->poses[5]->header.stamp);
    EXPECT_EQ(poses->poses[5]->id, 5U);
    EXPECT_LE(sumOf(poses->statistics.scans_dropped), 1U);

    play(&*poses, with_clock);
    expectResets(&*poses, log, 2);
  }
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_time_jump_test");
}
