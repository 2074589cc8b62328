// SPDX-License-Identifier: BSD-3-Clause
// Poses that come faster than they can be re-sampled: none that joined is lost, and what waits is
// told.
#include "ros_pose_client.h"

namespace ladar_perception::test {
namespace {

constexpr int kScans = 30;

class PoseBacklog : public testing::Test {
 protected:
  /// A re-sampler that takes its time.
  static ParamMap slow(int queue_size, int pose_queue_size) {
    return {{"join", std::string("every_scan")},
            {"policies", std::string("normal_variation:mode=attract,ratio=16")},
            {"count", 6000},
            {"queue_size", queue_size},
            {"pose_queue_size", pose_queue_size}};
  }
  void burst(PoseClient* client) {
    std::vector<sensor_msgs::PointCloud2> scans;
    for (int i = 0; i < kScans; ++i) scans.push_back(drive_.scan(i));
    client->sendMount();
    client->send(drive_.vehicleTransforms(0, kScans));
    for (const auto& scan : scans) client->send(scan);
  }
  /// Waits for the end, and looks at what was told on the way.
  bool waitForAll(PoseClient* client) {
    return waitFor(
        [&] {
          const PoseResamplerStatistics& s = client->statistics;
          most_waiting_ = std::max(most_waiting_, s.poses_waiting);
          longest_ = std::max(longest_, s.backlog_s);
          most_scans_waiting_ = std::max(most_scans_waiting_, s.scans_waiting);
          return client->scansDone() == kScans && s.poses > 0 && s.poses_waiting == 0 &&
                 client->poses.size() == s.poses;
        },
        3 * kPatience_s);
  }
  static void expectInOrder(const PoseClient& client) {
    for (std::size_t i = 0; i < client.poses.size(); ++i) {
      EXPECT_EQ(client.poses[i]->id, i);
      if (i == 0) continue;
      EXPECT_LT(client.poses[i - 1]->header.stamp, client.poses[i]->header.stamp);
    }
  }

  Drive drive_;
  uint32_t most_waiting_ = 0;
  uint32_t most_scans_waiting_ = 0;
  float longest_ = 0.0F;
};

TEST_F(PoseBacklog, EveryPoseOfABurstComes) {
  DiagnosticsListener diagnostics("pose_resampler");
  LoadedPoses poses("/burst", slow(100, 4));
  ASSERT_TRUE(poses.ready());
  burst(&*poses);
  ASSERT_TRUE(waitForAll(&*poses));
  EXPECT_EQ(poses->poses.size(), static_cast<std::size_t>(kScans));
  expectInOrder(*poses);
  expectAccounted(poses->statistics);
  EXPECT_EQ(sumOf(poses->statistics.scans_dropped), 0U);
  // Four in the queue, one re-sampled, one that waits for room.
  EXPECT_GE(most_waiting_, 4U);
  EXPECT_LE(most_waiting_, 6U);
  EXPECT_GT(most_scans_waiting_, 10U);
  EXPECT_GT(longest_, 0.0F);
  // The last scan of the burst waited for all others.
  EXPECT_GT(poses->statistics.lag_max_ms, 5.0F * poses->statistics.stages.back().p50_ms);
  EXPECT_EQ(poses->path.poses.size(), static_cast<std::size_t>(kScans));
}

TEST_F(PoseBacklog, ScansAreDroppedBeforeTheyBecomePoses) {
  LogListener log;
  LoadedPoses poses("/overrun", slow(3, 1));
  ASSERT_TRUE(poses.ready());
  burst(&*poses);
  ASSERT_TRUE(waitForAll(&*poses));
  const PoseResamplerStatistics& s = poses->statistics;
  EXPECT_GT(countOf(s.scans_dropped, "queue_full"), 0U);
  EXPECT_EQ(s.poses + sumOf(s.scans_dropped), static_cast<uint64_t>(kScans));
  EXPECT_EQ(poses->poses.size(), s.poses) << "a pose that joined comes";
  EXPECT_EQ(poses->poses.back()->header.stamp, drive_.scanStamp(kScans - 1))
      << "the oldest scans leave, the newest stay";
  expectInOrder(*poses);
  expectAccounted(s);
  EXPECT_GT(log.count("pose_queue_size"), 0);
  EXPECT_GT(log.count("queue_full"), 0);
}

TEST_F(PoseBacklog, UnloadingTellsWhatIsLost) {
  LogListener log;
  {
    LoadedPoses poses("/cut", slow(100, 100));
    ASSERT_TRUE(poses.ready());
    ASSERT_TRUE(log.hears("/manager"));
    burst(&*poses);
    ASSERT_TRUE(poses->waitForStatistics([](const auto& s) { return s.poses_waiting > 10; }));
  }
  EXPECT_TRUE(waitFor([&] { return log.count("poses that joined were re-sampled") == 1; }));
}

TEST_F(PoseBacklog, AWaitForTransformsHoldsNobodyUp) {
  LoadedPoses waiting("/waiting", {{"tf_timeout_s", 10.0}});
  ASSERT_TRUE(waiting.ready());
  const ros::WallTime begin = ros::WallTime::now();
  sensor_msgs::PointCloud2 lost = drive_.scan(0, 0.25);
  lost.header.frame_id = "nowhere";
  waiting->send(lost);
  EXPECT_TRUE(waiting->addPose());
  EXPECT_TRUE(waiting->reset());
  EXPECT_LT((ros::WallTime::now() - begin).toSec(), 5.0) << "services waited for tf";
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_backlog_test");
}
