// SPDX-License-Identifier: BSD-3-Clause
// replay.launch with poses:=true plays a simulated bag through terrain and the pose re-sampler.
#include "ros_pose_client.h"
#include "ros_process.h"

namespace ladar_perception::test {
namespace {

TEST(PoseReplay, EveryPoseOfASimulatedDriveComes) {
  TemporaryFolder folder;
  const std::string bag = folder.file("drive.bag");
  const std::string simulated = folder.file("simulated.txt");
  ChildProcess simulator({programPath("simulate_ladar"), "--scene", "campus", "--sensor", "vlp16",
                          "--duration", "4", "--speed", "6", "--seed", "3", "--out", bag},
                         simulated);
  ASSERT_TRUE(waitFor([&] { return !simulator.running(); }, 60.0));
  ASSERT_EQ(simulator.exitCode(), 0) << textOf(simulated);

  LogListener log;
  PoseClient poses("/pose_resampler");
  const std::string output = folder.file("roslaunch.txt");
  // The delay is for the nodelets to load, on a busy machine too.
  ChildProcess launch(
      {"roslaunch", "ladar_perception", "replay.launch", "bag:=" + bag, "poses:=true",
       "rviz:=false", "rate:=1", "delay:=5", "config:=" + kTestConfig, "model:=" + kTestModel},
      output);
  constexpr uint64_t kScans = 40;
  EXPECT_TRUE(waitFor(
      [&] {
        const bool all = poses.scansDone() >= kScans && poses.statistics.poses_waiting == 0;
        return all || !launch.running();
      },
      60.0))
      << textOf(output);
  EXPECT_TRUE(launch.running()) << textOf(output);
  const PoseResamplerStatistics& s = poses.statistics;
  EXPECT_EQ(poses.scansDone(), kScans);
  expectAccounted(s);
  // Terrain passes on only what it has placed itself, so all can be placed.
  EXPECT_EQ(sumOf(s.scans_dropped), 0U);
  EXPECT_EQ(sumOf(s.poses_dropped), 0U) << log.find("dropped");
  EXPECT_EQ(s.resets, 0U);
  // A scan every 0.6 m, and a pose when it is a metre.
  EXPECT_EQ(s.poses_published, kScans / 2);
  ASSERT_TRUE(waitFor([&] { return poses.poses.size() == s.poses_published; }));
  double length_m = 0.0;
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    const PoseCloud& pose = *poses.poses[i];
    EXPECT_EQ(pose.id, i);
    EXPECT_EQ(std::size_t{pose.cloud.width} * pose.cloud.height, 5000U);
    EXPECT_EQ(fieldValues(pose.cloud, "label").size(), 5000U);
    if (i == 0) continue;
    const auto& a = poses.poses[i - 1]->pose.pose.position;
    const auto& b = pose.pose.pose.position;
    const double step_m = std::hypot(b.x - a.x, b.y - a.y, b.z - a.z);
    EXPECT_GE(step_m, 0.99);
    EXPECT_LT(step_m, 1.21);
    length_m += step_m;
  }
  EXPECT_NEAR(length_m, 22.8, 0.5);
  EXPECT_EQ(poses.path.poses.size(), poses.poses.size());
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_replay_test");
}
