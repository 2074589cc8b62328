// SPDX-License-Identifier: BSD-3-Clause
// A simulated drive round a loop, by an odometry that drifts, through the pose re-sampler and the
// delayed state in one manager: the loop is closed, and slam_bag says the same bit by bit.
#include <geometry_msgs/PoseStamped.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <cmath>
#include <map>
#include <utility>

#include "ros_pose_client.h"
#include "ros_process.h"
#include "ros_state_client.h"

namespace ladar_perception::test {
namespace {

constexpr uint64_t kScans = 225;
constexpr uint64_t kSamples = 1500;  // a pose
constexpr uint64_t kAhead = 3;

class StateReplay : public testing::Test {
 protected:
  void simulate() {
    ChildProcess simulator({programPath("simulate_ladar"), "--scene", "campus", "--sensor", "vlp16",
                            "--speed", "15", "--duration", "22.5", "--odometry-scale-error", "2",
                            "--odometry-heading-drift", "2", "--out", bag_},
                           output_);
    ASSERT_TRUE(waitFor([&] { return !simulator.running(); }, 120.0));
    ASSERT_EQ(simulator.exitCode(), 0) << textOf(output_);
  }
  /// Sends what is in the bag, a few scans ahead of the re-sampler (played by the clock, transforms
  /// are lost on a busy machine), and waits until all of it is in the state.
  void play() {
    rosbag::Bag bag(bag_);
    uint64_t sent = 0;
    for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
      if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
        poses_.send(transforms->transforms);
      } else if (const auto truth = message.instantiate<geometry_msgs::PoseStamped>()) {
        const auto& p = truth->pose.position;
        truth_[truth->header.stamp.toNSec()] = Eigen::Vector3d(p.x, p.y, p.z);
      } else if (const auto scan = message.instantiate<sensor_msgs::PointCloud2>()) {
        ASSERT_TRUE(waitFor([&] { return poses_.scansDone() + kAhead > sent; }));
        poses_.send(*scan);
        ++sent;
      }
    }
    ASSERT_EQ(sent, kScans);
    ASSERT_TRUE(waitFor(
        [&] {
          const std::size_t poses = poses_.statistics.poses_published;
          return poses_.statistics.scans == kScans && poses_.statistics.poses_waiting == 0 &&
                 client_.statistics().poses == poses && client_.path().poses.size() == poses &&
                 client_.graph().poses.size() == poses;
        },
        60.0));
  }
  /// Scans have the stamps of true poses, but for what float64 seconds have no room for.
  Eigen::Vector3d truthAt(const ros::Time& stamp) const {
    const auto after = truth_.lower_bound(stamp.toNSec() - 1000);
    return after == truth_.end() ? Eigen::Vector3d::Constant(1e9) : after->second;
  }
  /// Errors of the positions from the start, rms: of the odometry, and of the estimate.
  std::pair<double, double> errors() const {
    double odometry_m2 = 0.0;
    double estimate_m2 = 0.0;
    const std::vector<GraphPose>& poses = client_.graph().poses;
    for (const GraphPose& pose : poses) {
      const Eigen::Vector3d p = truthAt(pose.stamp);
      odometry_m2 += (poseOf(pose.odometry).translation() - p).squaredNorm();
      estimate_m2 += (poseOf(pose.pose.pose).translation() - p).squaredNorm();
    }
    const auto count = static_cast<double>(poses.size());
    return {std::sqrt(odometry_m2 / count), std::sqrt(estimate_m2 / count)};
  }

  TemporaryFolder folder_;
  const std::string bag_ = folder_.file("loop.bag");
  const std::string output_ = folder_.file("output.txt");
  StateClient client_{"/delayed_state", "/", "slam_path"};
  PoseClient poses_{"/pose_resampler"};
  std::map<uint64_t, Eigen::Vector3d> truth_;  // positions by stamps, ns
};

TEST_F(StateReplay, ALoopIsClosedAndTheProgramSaysTheSame) {
  ASSERT_TRUE(client_.hears() && poses_.connected());
  ASSERT_NO_FATAL_FAILURE(simulate());
  const std::string offline = folder_.file("offline");
  const std::string log = folder_.file("offline.txt");
  ChildProcess program({programPath("slam_bag"), bag_, "--out", offline, "--poses",
                        std::string(LADAR_SOURCE_DIR) + "/test/data/ros_slam_poses.yaml",
                        "--config", kTestStateConfig},
                       log);
  ASSERT_NO_FATAL_FAILURE(play());
  const DelayedStateStatistics& s = client_.statistics();
  expectAccounted(s);
  EXPECT_EQ(sumOf(s.poses_dropped) + s.poses_missing, 0U);
  EXPECT_GE(s.loops_closed, 1U);
  EXPECT_GT(s.correction_m, 3.0F) << "the odometry is off by that much in the end";
  EXPECT_GT(client_.transforms.size(), static_cast<std::size_t>(s.poses)) << "one a pose, and more";
  // Nothing is kept of a pose but its samples, with colours and labels.
  EXPECT_EQ(s.samples, s.poses * kSamples);
  EXPECT_EQ(s.cloud_bytes, s.samples * 29);
  const auto [odometry_m, estimate_m] = errors();
  EXPECT_GT(odometry_m, 2.0);
  EXPECT_LT(estimate_m, odometry_m / 4.0);

  // The program optimises everything at the end.
  ASSERT_TRUE(client_.optimize());
  const std::string state = folder_.file("state.bin");
  ASSERT_TRUE(client_.save(state));
  ASSERT_TRUE(waitFor([&] { return !program.running(); }, 60.0));
  ASSERT_EQ(program.exitCode(), 0) << textOf(log);
  EXPECT_TRUE(textOf(state) == textOf(offline + "/state.bin")) << "the bits differ";
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "state_replay_test");
}
