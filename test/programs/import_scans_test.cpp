// SPDX-License-Identifier: BSD-3-Clause
// From files to bags, end to end; the readers' own tests are test/core/io_*.
#include <cmath>

#include "program_bag.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

/// A turn of `yaw` about z and a step, as a line of a KITTI pose file.
std::string poseLine(double yaw, double x, double y, double z) {
  std::ostringstream line;
  line.precision(17);
  line << std::cos(yaw) << " " << -std::sin(yaw) << " 0 " << x << " " << std::sin(yaw) << " "
       << std::cos(yaw) << " 0 " << y << " 0 0 1 " << z << "\n";
  return line.str();
}

Eigen::Isometry3d yawPose(double yaw, double x, double y, double z) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

class ImportScans : public ::testing::Test {
 protected:
  ProgramRun import(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--out", bag()});
    return runProgram("import_scans", arguments);
  }
  std::string bag() const { return folder_.file("out.bag"); }
  /// Neither a bag nor the beginning of one.
  void expectNoBag() const {
    EXPECT_EQ(folder_.list().find("out.bag"), std::string::npos) << folder_.list();
  }
  /// Pose of the clouds' frame in the map at a stamp, as tf has it.
  Eigen::Isometry3d T_map_sensor(const ros::Time& stamp) const {
    tf2::BufferCore buffer(ros::Duration(1000.0));
    fillBuffer(bag(), &buffer);
    return poseOf(buffer.lookupTransform("odom", "ladar", stamp).transform);
  }
  /// Three scans of two points, in the order of their numbers, not of their letters.
  std::string kittiFolder() const {
    for (const int i : {2, 9, 10}) {
      const auto f = static_cast<float>(i);
      folder_.write("scans/" + std::to_string(i) + ".bin",
                    bytesOf<float>({f, 1.0F, -1.0F, 0.25F, f, 2.0F, -1.5F, 0.5F}));
    }
    return folder_.file("scans");
  }

  ScratchFolder folder_;
};

TEST_F(ImportScans, KittiFolderWithPoses) {
  const std::string poses =
      folder_.write("poses.txt", poseLine(0.0, 0.0, 0.0, 0.0) + poseLine(0.5, 1.0, 2.0, 0.1) +
                                     poseLine(1.5, 1e5, 3.0, 0.2));
  const ProgramRun run =
      import({"--format", "kitti", "--poses", poses, "--sensor-height", "1.73", kittiFolder()});
  expectSuccess(run);
  EXPECT_NE(run.out.find("3 scans, 6 points"), std::string::npos) << run.out;

  const auto scans = readClouds(bag(), "/points");
  ASSERT_EQ(scans.size(), 3u);
  const std::vector<float> first_x = {2.0F, 9.0F, 10.0F};
  const std::vector<Eigen::Isometry3d> expected = {
      yawPose(0.0, 0.0, 0.0, 0.0), yawPose(0.5, 1.0, 2.0, 0.1), yawPose(1.5, 1e5, 3.0, 0.2)};
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto& cloud = scans[i].cloud;
    EXPECT_EQ(fieldsOf(cloud), "x:7 y:7 z:7 intensity:7");
    EXPECT_EQ(cloud.header.frame_id, "ladar");
    EXPECT_NEAR(cloud.header.stamp.toSec(), 1000.0 + 0.1 * static_cast<double>(i), 1e-6);
    EXPECT_TRUE(cloud.is_dense);
    EXPECT_EQ(valuesOf<float>(cloud, "x"), (std::vector<float>{first_x[i], first_x[i]}));
    EXPECT_EQ(valuesOf<float>(cloud, "intensity"), (std::vector<float>{0.25F, 0.5F}));
    EXPECT_TRUE(T_map_sensor(cloud.header.stamp).isApprox(expected[i], 1e-9)) << i;
  }
  // The vehicle's frame lies on the ground under the sensor.
  const Poses mount = readTransforms(bag(), "/tf_static");
  EXPECT_NEAR(mount.at({"base_link", "ladar"}).begin()->second.translation().z(), 1.73, 1e-12);
  // A pose before the first and one after the last scan, between which tf can interpolate.
  const Poses track = readTransforms(bag(), "/tf");
  EXPECT_LT(track.at({"odom", "base_link"}).begin()->first, scans.front().cloud.header.stamp);
  EXPECT_GT(track.at({"odom", "base_link"}).rbegin()->first, scans.back().cloud.header.stamp);
}

TEST_F(ImportScans, StaticTransformIsLatched) {
  expectSuccess(import({"--format", "kitti", kittiFolder()}));
  for (const auto& [topic, type, time, latched, bytes] : readRaw(bag(), {"/points", "/tf"})) {
    EXPECT_EQ(topic, "/tf_static");
    EXPECT_TRUE(latched);
  }
}

TEST_F(ImportScans, KittiLabelsBecomeTruth) {
  const std::string scans = kittiFolder();
  for (const char* name : {"2", "9", "10"}) {
    folder_.write(std::string("labels/") + name + ".label",
                  bytesOf<uint32_t>({40 + (7 << 16), 99}));
  }
  const std::string classes = folder_.write("classes.yaml",
                                            "classes:\n  - {name: other, labels: [1]}\n"
                                            "  - {name: road, labels: [40]}\n");
  const ProgramRun run = import({"--format", "kitti", "--classes", classes, scans});
  expectSuccess(run);
  EXPECT_NE(run.out.find("ignored 3, other 0, road 3"), std::string::npos) << run.out;
  for (const RecordedCloud& scan : readClouds(bag(), "/points")) {
    EXPECT_EQ(valuesOf<uint8_t>(scan.cloud, "truth"), (std::vector<uint8_t>{2, 0}));
  }
}

TEST_F(ImportScans, TumPosesGiveTheStamps) {
  const std::string poses = folder_.write("poses.txt",
                                          "# stamp x y z qx qy qz qw\n"
                                          "1500000000.25 0 0 0 0 0 0 1\n"
                                          "1500000000.75 1 0 0 0 0 0 1\n"
                                          "1500000002.00 2 0 0 0 0 1 0\n");
  expectSuccess(
      import({"--format", "kitti", "--poses", poses, "--pose-format", "tum", kittiFolder()}));
  const auto scans = readClouds(bag(), "/points");
  ASSERT_EQ(scans.size(), 3u);
  EXPECT_NEAR(scans[0].cloud.header.stamp.toSec(), 1500000000.25, 1e-6);
  EXPECT_NEAR(scans[2].cloud.header.stamp.toSec(), 1500000002.00, 1e-6);
  EXPECT_TRUE(T_map_sensor(scans[2].cloud.header.stamp)
                  .isApprox(yawPose(std::acos(-1.0), 2.0, 0.0, 0.0), 1e-9));
}

TEST_F(ImportScans, XyzWithColumnsAndNames) {
  const std::string text = folder_.write("cloud.xyz",
                                         "# a comment\n"
                                         "1 2 3 9 0.01\n"
                                         "\n"
                                         "-4.5 5e-1 6 9 0.02\n"
                                         "nan 0 0 9 0.03\n");
  expectSuccess(import({"--format", "xyz", "--columns", "x,y,z,_,t", text, "--topic", "/scan",
                        "--map-frame", "world", "--base-frame", "robot", "--sensor-frame", "eye",
                        "--start-time", "77", "--rate", "4"}));
  const auto scans = readClouds(bag(), "/scan");
  ASSERT_EQ(scans.size(), 1u);
  const auto& cloud = scans[0].cloud;
  EXPECT_EQ(cloud.header.frame_id, "eye");
  EXPECT_EQ(cloud.header.stamp, ros::Time(77.0));
  EXPECT_FALSE(cloud.is_dense);
  ASSERT_EQ(cloud.width * cloud.height, 3u);
  const auto p = positionsOf(cloud);
  EXPECT_EQ(p[1], Eigen::Vector3d(-4.5, 0.5, 6.0));
  EXPECT_TRUE(std::isnan(p[2].x()));
  EXPECT_NE(findField(cloud, "t"), nullptr) << fieldsOf(cloud);
  EXPECT_EQ(findField(cloud, "_"), nullptr);
  EXPECT_EQ(readTransforms(bag(), "/tf").count({"world", "robot"}), 1u);
}

TEST_F(ImportScans, PcdAscii) {
  const std::string pcd = folder_.write("cloud.pcd",
                                        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity ring\n"
                                        "SIZE 4 4 4 4 2\nTYPE F F F F U\nCOUNT 1 1 1 1 1\n"
                                        "WIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\n"
                                        "DATA ascii\n1 2 3 0.5 7\n4 5 6 1.5 8\n7 8 9 2.5 9\n");
  expectSuccess(import({"--format", "pcd", pcd}));
  const auto scans = readClouds(bag(), "/points");
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(fieldsOf(scans[0].cloud), "x:7 y:7 z:7 intensity:7 ring:4");
  EXPECT_EQ(positionsOf(scans[0].cloud)[2], Eigen::Vector3d(7.0, 8.0, 9.0));
  EXPECT_EQ(valuesOf<uint16_t>(scans[0].cloud, "ring"), (std::vector<uint16_t>{7, 8, 9}));
}

TEST_F(ImportScans, OaklandTileAsAStream) {
  // A strip of ground 60 m long far from the origin, with a hedge and something unlabelled.
  constexpr int kPoints = 3000;
  std::ostringstream text;
  text.precision(9);
  for (int i = 0; i < kPoints; ++i) {
    const int label = i % 10 == 0 ? 1301 : i % 10 == 1 ? 9999 : 1202;
    text << 1000.0 + 0.02 * i << " " << -500.0 + 0.5 * (i % 9) << " "
         << (label == 1301 ? 51.0 : 50.0) << " " << label << " 0\n";
  }
  const std::string tile = folder_.write("tile.xyz_label_conf", text.str());
  const ProgramRun run = import({"--format", "oakland", "--points-per-second", "5000", "--rate",
                                 "10", "--sensor-height", "2", tile});
  expectSuccess(run);
  EXPECT_NE(run.out.find("truth: ignored 300, surface 2400, scatter 300, linear 0"),
            std::string::npos)
      << run.out;

  std::vector<int> seen(kPoints, 0);
  const auto scans = readClouds(bag(), "/points");
  EXPECT_EQ(scans.size(), 6u);
  for (const RecordedCloud& scan : scans) {
    const Eigen::Isometry3d T = T_map_sensor(scan.cloud.header.stamp);
    EXPECT_NEAR(T.translation().z(), 52.0, 0.5) << "2 m above the ground";
    const auto truth = valuesOf<uint8_t>(scan.cloud, "truth");
    const auto label = valuesOf<uint16_t>(scan.cloud, "label");
    const auto p_sensor = positionsOf(scan.cloud);
    for (std::size_t i = 0; i < p_sensor.size(); ++i) {
      const Eigen::Vector3d p_map = T * p_sensor[i];
      const int index = static_cast<int>(std::lround((p_map.x() - 1000.0) / 0.02));
      ASSERT_GE(index, 0);
      ASSERT_LT(index, kPoints);
      ++seen[index];
      ASSERT_NEAR(p_map.y(), -500.0 + 0.5 * (index % 9), 1e-3);
      ASSERT_EQ(truth[i], label[i] == 1202 ? 1 : label[i] == 1301 ? 2 : 0);
      ASSERT_LT(p_sensor[i].norm(), 30.0) << "the vehicle follows its points";
    }
  }
  EXPECT_EQ(seen, std::vector<int>(kPoints, 1));
}

TEST_F(ImportScans, SameArgumentsSameBytes) {
  const std::string scans = kittiFolder();
  expectSuccess(import({"--format", "kitti", scans}));
  const std::size_t first = digestOf(bag());
  expectSuccess(import({"--format", "kitti", scans}));
  EXPECT_EQ(digestOf(bag()), first);
}

TEST_F(ImportScans, RefusesPosesThatDoNotMatch) {
  const std::string scans = kittiFolder();
  const std::string two = folder_.write("two.txt", poseLine(0, 0, 0, 0) + poseLine(0, 1, 0, 0));
  const auto with = [&](const std::string& poses) {
    return import({"--format", "kitti", "--poses", poses, scans});
  };
  expectFailure(with(two), {two, "2 poses", "3 scans"});
  expectFailure(with(folder_.write("short.txt", poseLine(0, 0, 0, 0) + "1 0 0\n")),
                {"short.txt:2", "3", "12"});
  expectFailure(with(folder_.write("bad.txt", poseLine(0, 0, 0, 0) + poseLine(0, 0, 0, 0) +
                                                  "1 0 0 here 0 1 0 0 0 0 1 0\n")),
                {"bad.txt:3", "here"});
  expectFailure(with(folder_.write("scale.txt", "2 0 0 0 0 2 0 0 0 0 2 0\n")),
                {"scale.txt:1", "rotation"});
  expectFailure(with(folder_.file("none.txt")), {"none.txt"});
  expectNoBag();
}

TEST_F(ImportScans, RefusesDamagedScans) {
  const std::string scans = kittiFolder();
  const std::string cut = folder_.write("scans/11.bin", std::string(30, '\0'));
  expectFailure(import({"--format", "kitti", scans}), {cut, "30 bytes", "16"});
  expectNoBag();

  const std::string text = folder_.write("bad.xyz", "1 2 3\n4 five 6\n");
  expectFailure(import({"--format", "xyz", text}), {text + ":2", "five"});
  const std::string ragged = folder_.write("ragged.xyz", "1 2 3\n4 5\n");
  expectFailure(import({"--format", "xyz", ragged}), {ragged + ":2"});
  const std::string tile = folder_.write("bad.xyz_label_conf", "1 2 3 1200 0\n1 2 3 tree 0\n");
  expectFailure(import({"--format", "oakland", tile}), {tile + ":2", "tree"});
  const std::string pcd = folder_.write("bad.pcd", "# .PCD v0.7\nVERSION 0.7\nFIELDS x y\n");
  EXPECT_EQ(import({"--format", "pcd", pcd}).status, 1);
  expectNoBag();
}

TEST_F(ImportScans, RefusesInputsThatAreNotThere) {
  const std::string nowhere = folder_.file("nowhere");
  expectFailure(import({"--format", "kitti", nowhere}), {nowhere});
  const std::string bare = folder_.file("bare");
  std::filesystem::create_directories(bare);
  expectFailure(import({"--format", "kitti", bare}), {bare, ".bin"});
  const std::string empty = folder_.write("empty.xyz", "");
  EXPECT_EQ(import({"--format", "xyz", empty}).status, 1);
  expectNoBag();
}

TEST_F(ImportScans, RefusesBadArguments) {
  const std::string scans = kittiFolder();
  expectFailure(import({"--format", "las", scans}), {"--format", "las", "kitti"});
  expectFailure(import({scans}), {"--format"});
  expectFailure(import({"--format", "kitti", "--rate", "0", scans}), {"--rate", "0"});
  expectFailure(import({"--format", "kitti", "--rate", "fast", scans}), {"--rate", "fast"});
  expectFailure(import({"--format", "kitti", "--sensor-height", "nan", scans}),
                {"--sensor-height"});
  expectFailure(import({"--format", "kitti", "--map-frame", "ladar", scans}), {"--map-frame"});
  expectFailure(import({"--format", "kitti", "--start-time", "0.05", scans}), {"--start-time"});
  expectFailure(import({"--format", "kitti", "--columns", "x,y,z", scans}), {"--columns", "xyz"});
  expectFailure(import({"--format", "kitti", "--classes", folder_.file("no.yaml"), scans}),
                {"no.yaml"});
  expectNoBag();
}

TEST_F(ImportScans, RefusesAPathItCannotWrite) {
  const std::string path = folder_.file("none/out.bag");
  expectFailure(runProgram("import_scans", {"--format", "kitti", kittiFolder(), "--out", path}),
                {path});
  EXPECT_EQ(folder_.list(), "scans");
}

TEST_F(ImportScans, Helps) {
  expectHelp("import_scans", {"--format", "oakland", "kitti", "pcd", "ply", "xyz", "--poses",
                              "--rate", "--sensor-height", "--classes", "--stream", "--out"});
}

}  // namespace
}  // namespace ladar_perception::test
