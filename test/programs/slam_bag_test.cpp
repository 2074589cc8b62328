// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <nlohmann/json.hpp>

#include "ladar_perception/io/pcl_reader.h"
#include "ladar_perception/io/pose_file.h"
#include "program_bag.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

using Json = nlohmann::json;

Json jsonOf(const std::string& path) {
  std::ifstream file(path);
  return Json::parse(file);
}

/// 20 m through the campus; odometry measures 10 % too far and turns 30 degrees per 100 m.
class SlamBag : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    bag_ = folder_->file("drive.bag");
    expectSuccess(runProgram(
        "simulate_ladar",
        {"--scene", "campus", "--sensor", "vlp16", "--speed", "8", "--duration", "2.6", "--out",
         bag_, "--odometry-scale-error", "10", "--odometry-heading-drift", "30"}));
  }
  static void TearDownTestSuite() { delete folder_; }

  /// Runs on the drive with results in `name`.
  static ProgramRun run(const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {bag_, "--out", folder_->file(name), "--count", "1500"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runProgram("slam_bag", arguments);
  }
  static std::string result(const std::string& name, const std::string& file) {
    return folder_->file(name) + "/" + file;
  }

  static ScratchFolder* folder_;
  static std::string bag_;
};

ScratchFolder* SlamBag::folder_ = nullptr;
std::string SlamBag::bag_;

TEST_F(SlamBag, CorrectsTheOdometryAndWritesWhatItFound) {
  expectSuccess(run("a"));
  const Json metrics = jsonOf(result("a", "metrics.json"));
  const auto poses = metrics["poses"].get<std::size_t>();
  EXPECT_GE(poses, 12u);
  EXPECT_EQ(metrics["scans"], 26);
  EXPECT_EQ(metrics["samples"], 1500 * poses);
  EXPECT_EQ(metrics["pose_ms"].size(), poses);
  const Json& counts = metrics["constraints"];
  EXPECT_EQ(counts["odometry"], poses - 1);
  EXPECT_EQ(
      counts["tried"].get<int>(),
      counts["accepted"].get<int>() + counts["rejected"].get<int>() + counts["waiting"].get<int>());
  EXPECT_GT(counts["accepted"].get<std::size_t>(), poses / 2);
  const Json& error = metrics["error"];
  EXPECT_EQ(error["poses_with_truth"], poses);
  EXPECT_GT(error["odometry"]["rms_m"], 0.8);
  EXPECT_LT(error["estimate"]["rms_m"].get<double>(),
            error["odometry"]["rms_m"].get<double>() / 5.0);

  const ladar_perception::Poses tum =
      readPoses(result("a", "trajectory_tum.txt"), PoseFormat::kTum);
  const ladar_perception::Poses kitti =
      readPoses(result("a", "trajectory_kitti.txt"), PoseFormat::kKitti);
  const ladar_perception::Poses odometry =
      readPoses(result("a", "odometry_tum.txt"), PoseFormat::kTum);
  ASSERT_EQ(tum.T_map_lidar.size(), poses);
  ASSERT_EQ(kitti.T_map_lidar.size(), poses);
  ASSERT_EQ(odometry.T_map_lidar.size(), poses);
  EXPECT_TRUE(tum.T_map_lidar.back().isApprox(kitti.T_map_lidar.back(), 1e-6));
  EXPECT_GT(
      (tum.T_map_lidar.back().translation() - odometry.T_map_lidar.back().translation()).norm(),
      1.0);

  const Json graph = jsonOf(result("a", "graph.json"));
  EXPECT_EQ(graph["poses"].size(), poses);
  EXPECT_EQ(graph["constraints"].size(),
            counts["odometry"].get<std::size_t>() + counts["accepted"].get<std::size_t>());
  EXPECT_EQ(graph["constraints"][0]["information_upper"].size(), 21u);
  EXPECT_EQ(graph["poses"][0]["sigma"][0], 0.0);
  EXPECT_GT(graph["poses"].back()["sigma"][0], 0.0);

  const Scan map = readPcdScan(result("a", "map.pcd"));
  EXPECT_EQ(map.size(), 1500 * poses);
  for (const char* field : {"x", "normal_z", "rgb", "label", "pose"}) {
    EXPECT_NE(map.layout.find(field), nullptr) << field;
  }
  EXPECT_EQ(readColumn(map, "pose").back(), static_cast<double>(poses - 1));
  EXPECT_GT(std::filesystem::file_size(result("a", "state.bin")), 1500 * poses * 24);
}

TEST_F(SlamBag, TheSameBitsForAnyNumberOfThreads) {
  expectSuccess(run("one", {"--pose-distance", "3"}));
  expectSuccess(run("three", {"--pose-distance", "3", "--threads", "3"}));
  for (const char* file : {"trajectory_tum.txt", "graph.json", "map.pcd", "state.bin"}) {
    EXPECT_EQ(fileBytes(result("one", file)), fileBytes(result("three", file))) << file;
  }
}

TEST_F(SlamBag, SaysWhatIsWrong) {
  expectFailure(runProgram("slam_bag", {"/no/such.bag", "--out", folder_->file("x")}),
                {"slam_bag", "/no/such.bag", "cannot be opened"});
  expectFailure(run("x", {"--topic", "/nothing"}), {"'/nothing'", "/points"});
  expectFailure(runProgram("slam_bag", {bag_, "--out", "/proc/nothing"}), {"/proc/nothing"});
  std::ofstream(folder_->file("bad.yaml")) << "gate_chi: 3\nthreads: 0\n";
  expectFailure(runProgram("slam_bag", {bag_, "--out", folder_->file("x"), "--config",
                                        folder_->file("bad.yaml")}),
                {"bad.yaml", "gate_chi", "threads"}, 3);
  std::ofstream(folder_->file("frame.yaml")) << "odom_frame: nowhere\n";
  expectFailure(runProgram("slam_bag", {bag_, "--out", folder_->file("x"), "--poses",
                                        folder_->file("frame.yaml")}),
                {"not one pose", "nowhere"}, 3);
  expectHelp("slam_bag", {"--out", "--config", "--poses", "--truth-topic", "--threads"});
}

}  // namespace
}  // namespace ladar_perception::test
