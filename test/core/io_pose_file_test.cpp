// SPDX-License-Identifier: BSD-3-Clause
#include "io_test_files.h"
#include "ladar_perception/io/pose_file.h"

namespace ladar_perception {
namespace {

// A quarter turn to the left, then 1 2 3.
const std::string kTurn34 = "0 -1 0 1  1 0 0 2  0 0 1 3";

TEST(IoPoseFile, ReadsKittiLines) {
  const Poses poses = readPoses(
      writeFile("p.txt", "# lidar to map\n" + kTurn34 + "\r\n\n" + kTurn34 + " 0 0 0 1 # 4x4\n"),
      PoseFormat::kKitti);
  ASSERT_EQ(poses.T_map_lidar.size(), 2u);
  EXPECT_TRUE(poses.stamps_s.empty());
  for (const Eigen::Isometry3d& T : poses.T_map_lidar) {
    EXPECT_TRUE((T * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3)));
  }
}

TEST(IoPoseFile, ReadsTumLines) {
  const Poses poses =
      readPoses(writeFile("p.txt", "1.5 1 2 3 0 0 0.70710678 0.70710678\n1.6 0 0 0 0 0 0 1\n"),
                PoseFormat::kTum);
  ASSERT_EQ(poses.T_map_lidar.size(), 2u);
  EXPECT_EQ(poses.stamps_s, (std::vector<double>{1.5, 1.6}));
  const Eigen::Vector3d p_map = poses.T_map_lidar[0] * Eigen::Vector3d(1, 0, 0);
  EXPECT_TRUE(p_map.isApprox(Eigen::Vector3d(1, 3, 3)));
}

TEST(IoPoseFile, MakesRoundedRotationsExact) {
  const Poses poses = readPoses(writeFile("p.txt", "1 -0.0004 0 0 0.0004 1 0 0 0 0 1.0003 0\n"),
                                PoseFormat::kKitti);
  const Eigen::Matrix3d R = poses.T_map_lidar[0].linear();
  EXPECT_TRUE((R.transpose() * R).isIdentity(1e-12));
}

TEST(IoPoseFile, NamesTheLineThatIsWrong) {
  const auto expectMessage = [](const std::string& line, PoseFormat format,
                                const std::vector<std::string>& parts) {
    const std::string path = writeFile("bad.txt", "# first line\n" + line + "\n");
    expectError([&] { readPoses(path, format); }, parts);
  };
  const PoseFormat kitti = PoseFormat::kKitti;
  const PoseFormat tum = PoseFormat::kTum;
  expectMessage("1 2 3", kitti, {"bad.txt:2", "3 numbers", "12", "16"});
  expectMessage("1 0 0 0 0 1 0 0 0 0 1 x", kitti, {"bad.txt:2", "'x'"});
  expectMessage("1 0 0 0 0 1 0 0 0 0 1 nan", kitti, {"bad.txt:2", "'nan'", "finite"});
  expectMessage("2 0 0 0 0 1 0 0 0 0 1 0", kitti, {"bad.txt:2", "not a rotation"});
  expectMessage("-1 0 0 0 0 1 0 0 0 0 1 0", kitti, {"bad.txt:2", "not a rotation", "-1"});
  expectMessage(kTurn34 + " 0 0 1 1", kitti, {"bad.txt:2", "last row"});
  expectMessage("1 0 0 0 0 0 0 2", tum, {"bad.txt:2", "norm 2"});
  expectMessage("1 0 0 0 0 0 1", tum, {"bad.txt:2", "7 numbers", "8"});
  expectMessage("2 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1", tum, {"bad.txt:3", "not after"});
  expectMessage("", kitti, {"bad.txt", "no poses"});
}

}  // namespace
}  // namespace ladar_perception
