// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "io_test_files.h"
#include "ladar_perception/io/pose_file.h"
#include "ladar_perception/slam/trajectory.h"
#include "slam_cases.h"

namespace ladar_perception {
namespace {

using test::randomPose;
using test::squareDrive;
using test::TestRandom;

TEST(SlamTrajectory, FilesAreReadAsTheyWereWritten) {
  TestRandom random(1);
  Trajectory poses;
  std::vector<double> stamps_s;
  for (int i = 0; i < 20; ++i) {
    poses.push_back(randomPose(&random, 500.0, 1.0));
    stamps_s.push_back(1700000000.125 + 0.1 * i);
  }
  const std::string tum = (testFolder() / "tum.txt").string();
  const std::string kitti = (testFolder() / "kitti.txt").string();
  writeTum(tum, stamps_s, poses);
  writeKitti(kitti, poses);
  const Poses read_tum = readPoses(tum, PoseFormat::kTum);
  const Poses read_kitti = readPoses(kitti, PoseFormat::kKitti);
  ASSERT_EQ(read_tum.T_map_lidar.size(), poses.size());
  ASSERT_EQ(read_kitti.T_map_lidar.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(read_tum.stamps_s[i], stamps_s[i], 1e-6);
    EXPECT_LT(minus(read_tum.T_map_lidar[i], poses[i]).norm(), 1e-5);
    EXPECT_LT(minus(read_kitti.T_map_lidar[i], poses[i]).norm(), 1e-5);
  }
  expectError([&] { writeTum("/no/such/folder/t.txt", stamps_s, poses); }, {"/no/such/folder"});
  expectError([&] { writeKitti("/no/such/folder/k.txt", poses); }, {"/no/such/folder"});
}

TEST(SlamTrajectory, NoErrorInAnotherMapFrame) {
  TestRandom random(2);
  const Trajectory truth = squareDrive(5, 1, 2.0);
  const Eigen::Isometry3d T = randomPose(&random, 100.0, 1.0);
  Trajectory poses;
  for (const Eigen::Isometry3d& pose : truth) poses.push_back(T * pose);
  EXPECT_LT(errorFromStart(poses, truth).max_m, 1e-10);
  EXPECT_LT(errorAligned(poses, truth).max_m, 1e-10);
}

TEST(SlamTrajectory, CountsWhatIsLeftAfterTheBestRigidMotion) {
  const Trajectory truth = squareDrive(5, 1, 2.0);
  Trajectory poses = truth;
  // Every second pose up, the others down: no rigid motion helps, but the start is off, too.
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].translation().z() += i % 2 == 0 ? 0.1 : -0.1;
  }
  EXPECT_NEAR(errorAligned(poses, truth).rms_m, 0.1, 0.005);
  EXPECT_NEAR(errorFromStart(poses, truth).max_m, 0.2, 1e-12);
  EXPECT_NEAR(errorFromStart(poses, truth).rms_m, 0.2 * std::sqrt(0.5), 1e-12);
}

TEST(SlamTrajectory, AFlatTrajectoryIsNotMirrored) {
  const Trajectory truth = squareDrive(5, 1, 2.0);
  Trajectory mirrored = truth;
  for (Eigen::Isometry3d& pose : mirrored) {
    pose.translation().y() *= -1.0;
    pose.translation().z() = 0.01 * pose.translation().x();
  }
  EXPECT_LT(errorAligned(mirrored, truth).rms_m, 0.1) << "turned over it fits";
  for (Eigen::Isometry3d& pose : mirrored)
    pose.translation().z() = std::sin(pose.translation().x());
  EXPECT_GT(errorAligned(mirrored, truth).rms_m, 0.1);
}

TEST(SlamTrajectory, FewPosesAndLinesAreComparedFromTheStart) {
  EXPECT_EQ(errorAligned({}, {}).rms_m, 0.0);
  EXPECT_EQ(errorFromStart({}, {}).rms_m, 0.0);
  Trajectory truth(5, Eigen::Isometry3d::Identity());
  EXPECT_EQ(errorAligned(truth, truth).rms_m, 0.0) << "a vehicle that stands";
  for (int i = 0; i < 5; ++i) truth[i].translation().x() = i;
  Trajectory poses = truth;
  poses[4].translation().x() += 1.0;
  EXPECT_NEAR(errorAligned(poses, truth).max_m, 1.0, 1e-12);
  EXPECT_NEAR(errorAligned({poses[0]}, {truth[3]}).max_m, 0.0, 1e-12);
}

}  // namespace
}  // namespace ladar_perception
