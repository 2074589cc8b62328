// SPDX-License-Identifier: BSD-3-Clause
// A simulated drive round a loop, by an odometry that drifts, through the pose re-sampler and the
// delayed state in one manager: the loop is closed, and slam_bag says the same bit by bit.
#include <geometry_msgs/PoseStamped.h>
#include <ladar_perception/PoseResamplerStatistics.h>

#include <cmath>
#include <map>
#include <utility>

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
  /// Plays the bag, and waits until all of it is in the state.
  void play() {
    PoseResamplerStatistics resampled;
    const auto subscriber = ros::NodeHandle().subscribe<PoseResamplerStatistics>(
        "pose_statistics", 10,
        [&](const PoseResamplerStatisticsConstPtr& message) { resampled = *message; });
    ChildProcess player(
        {"rosbag", "play", "--clock", "--quiet", "--delay", "2", "--rate", "2", bag_}, output_);
    ASSERT_TRUE(waitFor([&] { return !player.running(); }, 60.0));
    ASSERT_EQ(player.exitCode(), 0) << textOf(output_);
    ASSERT_TRUE(waitFor(
        [&] {
          const std::size_t poses = resampled.poses_published;
          return resampled.scans == kScans && resampled.poses_waiting == 0 && poses > 0 &&
                 client_.statistics().poses == poses && client_.path().poses.size() == poses &&
                 client_.graph().poses.size() == poses;
        },
        60.0));
  }
  /// Errors of the positions from the start, rms: of the odometry, and of the estimate.
  std::pair<double, double> errors() const {
    double odometry_m2 = 0.0;
    double estimate_m2 = 0.0;
    const std::vector<GraphPose>& poses = client_.graph().poses;
    for (const GraphPose& pose : poses) {
      const Eigen::Vector3d p = truth_.at(pose.stamp);
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
  Truth truth_;
};

TEST_F(StateReplay, ALoopIsClosedAndTheProgramSaysTheSame) {
  ASSERT_TRUE(client_.hears());
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
  EXPECT_GT(client_.transforms.size(), 100U);
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
