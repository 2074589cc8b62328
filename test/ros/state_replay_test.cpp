// SPDX-License-Identifier: BSD-3-Clause
// A simulated drive round a loop, by an odometry that drifts, through the pose re-sampler and the
// delayed state in one manager: the loop is closed, and slam_bag says the same bit by bit.
#include <geometry_msgs/PoseStamped.h>
#include <ladar_perception/PoseResamplerStatistics.h>

#include "ros_process.h"
#include "ros_state_client.h"

namespace ladar_perception::test {
namespace {

constexpr uint64_t kScans = 225;
constexpr uint64_t kSamples = 1500;  // a pose

/// True positions by stamps.
class Truth {
 public:
  Truth() {
    subscriber_ = ros::NodeHandle().subscribe<geometry_msgs::PoseStamped>(
        "/ground_truth", 10000, [this](const geometry_msgs::PoseStampedConstPtr& pose) {
          positions_[pose->header.stamp.toNSec()] =
              Eigen::Vector3d(pose->pose.position.x, pose->pose.position.y, pose->pose.position.z);
        });
  }
  std::size_t size() const { return positions_.size(); }
  /// The nearest in time; they come at least every scan's.
  Eigen::Vector3d at(const ros::Time& stamp) const {
    auto after = positions_.lower_bound(stamp.toNSec());
    if (after == positions_.end()) return std::prev(after)->second;
    if (after == positions_.begin()) return after->second;
    const auto before = std::prev(after);
    const uint64_t ns = stamp.toNSec();
    return ns - before->first < after->first - ns ? before->second : after->second;
  }

 private:
  std::map<uint64_t, Eigen::Vector3d> positions_;
  ros::Subscriber subscriber_;
};

TEST(StateReplay, ALoopIsClosedAndTheProgramSaysTheSame) {
  TemporaryFolder folder;
  const std::string bag = folder.file("loop.bag");
  const std::string output = folder.file("output.txt");
  ChildProcess simulator({programPath("simulate_ladar"), "--scene", "campus", "--sensor", "vlp16",
                          "--speed", "15", "--duration", "22.5", "--odometry-scale-error", "2",
                          "--odometry-heading-drift", "2", "--out", bag},
                         output);
  StateClient client("/delayed_state", "/", "slam_path");
  Truth truth;
  ASSERT_TRUE(client.hears());
  ASSERT_TRUE(waitFor([&] { return !simulator.running(); }, 120.0));
  ASSERT_EQ(simulator.exitCode(), 0) << textOf(output);

  ChildProcess player({"rosbag", "play", "--clock", "--quiet", "--delay", "2", "--rate", "2", bag},
                      output);
  ASSERT_TRUE(waitFor([&] { return !player.running(); }, 60.0));
  ASSERT_EQ(player.exitCode(), 0) << textOf(output);
  EXPECT_GT(client.transforms.size(), 100U);
  PoseResamplerStatistics last;
  const auto subscriber = ros::NodeHandle().subscribe<PoseResamplerStatistics>(
      "pose_statistics", 10,
      [&](const PoseResamplerStatisticsConstPtr& message) { last = *message; });
  ASSERT_TRUE(waitFor(
      [&] {
        return last.scans == kScans && last.poses_waiting == 0 && last.poses_published > 0 &&
               client.statistics().poses == last.poses_published &&
               client.path().poses.size() == last.poses_published;
      },
      60.0));
  const DelayedStateStatistics& s = client.statistics();
  expectAccounted(s);
  EXPECT_EQ(sumOf(s.poses_dropped) + s.poses_missing, 0U);
  EXPECT_GE(s.loops_closed, 1U);
  EXPECT_GT(s.correction_m, 3.0F) << "the odometry is off by that much in the end";
  // Nothing is kept of a pose but its samples, with colours and labels.
  EXPECT_EQ(s.samples, s.poses * kSamples);
  EXPECT_EQ(s.cloud_bytes, s.samples * 29);

  double odometry_m2 = 0.0;
  double estimate_m2 = 0.0;
  ASSERT_TRUE(waitFor([&] { return client.graph().poses.size() == s.poses; }));
  for (const GraphPose& pose : client.graph().poses) {
    const Eigen::Vector3d p = truth.at(pose.stamp);
    odometry_m2 += (poseOf(pose.odometry).translation() - p).squaredNorm() / s.poses;
    estimate_m2 += (poseOf(pose.pose.pose).translation() - p).squaredNorm() / s.poses;
  }
  EXPECT_GT(std::sqrt(odometry_m2), 2.0);
  EXPECT_LT(std::sqrt(estimate_m2), std::sqrt(odometry_m2) / 4.0)
      << std::sqrt(estimate_m2) << " of " << std::sqrt(odometry_m2);

  // The program optimises everything at the end.
  ASSERT_TRUE(client.optimize());
  const std::string state = folder.file("state.bin");
  ASSERT_TRUE(client.save(state));
  ChildProcess program({programPath("slam_bag"), bag, "--out", folder.file("off"), "--poses",
                        std::string(LADAR_SOURCE_DIR) + "/test/data/ros_slam_poses.yaml",
                        "--config", kTestStateConfig},
                       output);
  ASSERT_TRUE(waitFor([&] { return !program.running(); }, 60.0));
  ASSERT_EQ(program.exitCode(), 0) << textOf(output);
  EXPECT_EQ(textOf(state), textOf(folder.file("off") + "/state.bin")) << "the bits differ";
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "state_replay_test");
}
