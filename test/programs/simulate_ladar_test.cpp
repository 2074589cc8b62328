// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/PoseStamped.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "program_bag.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

constexpr double kScanPeriod_s = 0.05;

void expectOrganisedScan(const RecordedCloud& scan, std::size_t index,
                         std::array<std::size_t, 4>* truth_counts) {
  const sensor_msgs::PointCloud2& cloud = scan.cloud;
  ASSERT_EQ(cloud.width, 180u);
  ASSERT_EQ(cloud.height, 32u);
  EXPECT_EQ(fieldsOf(cloud), "x:7 y:7 z:7 intensity:7 ring:4 time:7 truth:2 rgb:7 label:4");
  EXPECT_EQ(cloud.header.frame_id, "ladar");
  EXPECT_FALSE(cloud.is_bigendian);
  EXPECT_NEAR(cloud.header.stamp.toSec(), 1000.0 + static_cast<double>(index) * kScanPeriod_s,
              1e-6);
  // A cloud cannot be sent before its last column was measured.
  EXPECT_GE((scan.recorded - cloud.header.stamp).toSec(), kScanPeriod_s - 1e-6);

  const auto p_ladar = positionsOf(cloud);
  const auto ring = valuesOf<uint16_t>(cloud, "ring");
  const auto time_s = valuesOf<float>(cloud, "time");
  const auto truth = valuesOf<uint8_t>(cloud, "truth");
  bool dense = true;
  for (std::size_t i = 0; i < p_ladar.size(); ++i) {
    ASSERT_EQ(ring[i], i / cloud.width);
    ASSERT_GE(time_s[i], 0.0F);
    ASSERT_LT(time_s[i], kScanPeriod_s);
    ASSERT_LE(truth[i], 3);
    ++truth_counts->at(truth[i]);
    const bool valid = p_ladar[i].allFinite();
    dense = dense && valid;
    if (valid) {
      ASSERT_LT(p_ladar[i].norm(), 60.0);
      ASSERT_GT(p_ladar[i].x(), 0.0);  // the field of view is 90 degrees wide, ahead
    } else {
      ASSERT_EQ(truth[i], 0) << "a beam without a return has no class";
    }
  }
  EXPECT_EQ(cloud.is_dense, dense);
}

void expectTransformsCover(const std::string& path, const std::vector<RecordedCloud>& scans) {
  tf2::BufferCore buffer(ros::Duration(60.0));
  fillBuffer(path, &buffer);
  for (const RecordedCloud& scan : scans) {
    for (const double offset_s : {0.0, 0.02, kScanPeriod_s}) {
      std::string why;
      EXPECT_TRUE(buffer.canTransform("odom", "ladar",
                                      scan.cloud.header.stamp + ros::Duration(offset_s), &why))
          << why;
    }
  }
  const auto moved = buffer.lookupTransform("base_link", scans.front().cloud.header.stamp,
                                            "base_link", scans.back().cloud.header.stamp, "odom");
  const double distance_m = poseOf(moved.transform).translation().norm();
  // 1.45 s at 2 m/s, a little less where the track bends.
  EXPECT_NEAR(distance_m, 2.0 * kScanPeriod_s * static_cast<double>(scans.size() - 1), 0.2);
}

class SimulateLadarScene : public ::testing::TestWithParam<const char*> {};

TEST_P(SimulateLadarScene, MakesABag) {
  const ScratchFolder folder;
  const std::string path = folder.file("scene.bag");
  const ProgramRun run = runProgram(
      "simulate_ladar", {"--scene", GetParam(), "--duration", "1.5", "--seed", "5", "--out", path});
  expectSuccess(run);
  EXPECT_NE(run.out.find(path), std::string::npos) << run.out;
  EXPECT_EQ(folder.list(), "scene.bag");

  const auto scans = readClouds(path, "/points");
  ASSERT_EQ(scans.size(), 30u);
  std::array<std::size_t, 4> truth_counts{};
  for (std::size_t i = 0; i < scans.size(); ++i) expectOrganisedScan(scans[i], i, &truth_counts);
  for (std::size_t label = 1; label <= 3; ++label) {
    EXPECT_GT(truth_counts[label], 100u) << "class " << label;
  }
  expectTransformsCover(path, scans);
}

INSTANTIATE_TEST_SUITE_P(Scenes, SimulateLadarScene,
                         ::testing::Values("flat_ground", "forest", "tall_grass", "campus",
                                           "street", "scrubland"),
                         [](const auto& scene) { return std::string(scene.param); });

struct SensorCase {
  const char* name;
  uint32_t width;
  uint32_t height;
  double period_s;
};

class SimulateLadarSensor : public ::testing::TestWithParam<SensorCase> {};

TEST_P(SimulateLadarSensor, WritesItsOwnCloudsAtItsHeight) {
  const ScratchFolder folder;
  const std::string path = folder.file("scene.bag");
  expectSuccess(runProgram("simulate_ladar",
                           {"--scene", "campus", "--sensor", GetParam().name, "--sensor-height",
                            "1.45", "--duration", "0.8", "--speed", "8", "--out", path}));
  const auto scans = readClouds(path, "/points");
  ASSERT_EQ(scans.size(), static_cast<std::size_t>(0.8 / GetParam().period_s + 1e-6));
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const sensor_msgs::PointCloud2& cloud = scans[i].cloud;
    EXPECT_EQ(cloud.width, GetParam().width);
    EXPECT_EQ(cloud.height, GetParam().height);
    const double due_s = 1000.0 + static_cast<double>(i) * GetParam().period_s;
    EXPECT_NEAR(cloud.header.stamp.toSec(), due_s, 1e-6);
    const auto time_s = valuesOf<float>(cloud, "time");
    EXPECT_LT(*std::max_element(time_s.begin(), time_s.end()), GetParam().period_s);
  }
  const Poses poses = readTransforms(path, "/tf");
  for (const auto& [stamp, pose] : poses.at({"base_link", "ladar"})) {
    ASSERT_NEAR(pose.translation().z(), 1.45, 1e-9) << stamp;
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, SimulateLadarSensor,
                         ::testing::Values(SensorCase{"xuv", 180, 32, 0.05},
                                           SensorCase{"vlp16", 1800, 16, 0.1},
                                           SensorCase{"hdl64", 1024, 64, 0.1},
                                           SensorCase{"os64", 1024, 64, 0.1},
                                           SensorCase{"pushbroom", 5, 361, 1.0 / 7.5}),
                         [](const auto& sensor) { return std::string(sensor.param.name); });

TEST(SimulateLadar, PushbroomLooksWhereItIsTold) {
  const ScratchFolder folder;
  const auto sides = [&](const std::string& look) {
    const std::string path = folder.file(look + ".bag");
    expectSuccess(runProgram("simulate_ladar", {"--scene", "campus", "--sensor", "pushbroom",
                                                "--look", look, "--duration", "1", "--out", path}));
    std::array<std::size_t, 2> counts{};  // left, right
    for (const auto& scan : readClouds(path, "/points")) {
      for (const Eigen::Vector3d& p : positionsOf(scan.cloud)) {
        if (std::abs(p.y()) > 0.01) ++counts[p.y() > 0.0 ? 0 : 1];
      }
    }
    return counts;
  };
  const auto left = sides("left");
  const auto right = sides("right");
  const auto both = sides("both");
  EXPECT_GT(left[0], 500u);
  EXPECT_EQ(left[1], 0u);
  EXPECT_EQ(right[0], 0u);
  EXPECT_GT(right[1], 500u);
  EXPECT_NEAR(static_cast<double>(both[0]), static_cast<double>(left[0]), 0.1 * left[0]);
  EXPECT_NEAR(static_cast<double>(both[1]), static_cast<double>(right[1]), 0.1 * right[1]);
}

TEST(SimulateLadar, SameArgumentsSameBytes) {
  const ScratchFolder folder;
  const auto simulate = [&](const std::string& name, const std::string& seed) {
    expectSuccess(runProgram("simulate_ladar", {"--scene", "flat_ground", "--duration", "1",
                                                "--seed", seed, "--out", folder.file(name)}));
  };
  simulate("a.bag", "3");
  simulate("b.bag", "3");
  simulate("c.bag", "4");
  EXPECT_EQ(digestOf(folder.file("a.bag")), digestOf(folder.file("b.bag")));
  const auto points = [&](const std::string& name) {
    return readClouds(folder.file(name), "/points").front().cloud.data;
  };
  EXPECT_NE(points("a.bag"), points("c.bag"));
}

TEST(SimulateLadar, ReplacesAnOlderBag) {
  const ScratchFolder folder;
  const std::string path = folder.write("old.bag", "old");
  expectSuccess(
      runProgram("simulate_ladar", {"--scene", "flat_ground", "--duration", "0.1", "--out", path}));
  EXPECT_EQ(readClouds(path, "/points").size(), 2u);
}

TEST(SimulateLadar, StandsStillAtSpeedZero) {
  const ScratchFolder folder;
  const std::string path = folder.file("still.bag");
  expectSuccess(runProgram("simulate_ladar", {"--scene", "flat_ground", "--duration", "0.5",
                                              "--speed", "0", "--out", path}));
  const Poses poses = readTransforms(path, "/tf");
  const auto& track = poses.at({"odom", "base_link"});
  for (const auto& [stamp, pose] : track) {
    EXPECT_TRUE(pose.isApprox(track.begin()->second, 1e-12)) << stamp;
  }
}

TEST(SimulateLadar, RefusesBadArguments) {
  const ScratchFolder folder;
  const std::string path = folder.file("bad.bag");
  const auto simulate = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--out", path});
    return runProgram("simulate_ladar", arguments);
  };
  expectFailure(simulate({"--scene", "moon"}), {"--scene", "moon", "forest"});
  expectFailure(simulate({"--sensor", "sonar"}), {"--sensor", "sonar", "vlp16"});
  expectFailure(simulate({"--sensor-height", "0.1"}), {"--sensor-height", "0.1"});
  expectFailure(simulate({"--sensor-height", "nan"}), {"--sensor-height", "nan"});
  expectFailure(simulate({"--look", "up"}), {"--look", "up", "both"});
  expectFailure(simulate({"--look", "left"}), {"--look", "pushbroom"});
  expectFailure(simulate({"--duration", "0"}), {"--duration", "0"});
  expectFailure(simulate({"--duration", "-3"}), {"--duration", "-3"});
  expectFailure(simulate({"--duration", "long"}), {"--duration", "long"});
  expectFailure(simulate({"--duration", "nan"}), {"--duration", "nan"});
  expectFailure(simulate({"--speed", "1e9"}), {"--speed"});
  expectFailure(simulate({"--duration", "0.1", "--seed", "-1"}), {"--seed", "-1"});
  expectFailure(simulate({"--sped", "1"}), {"--sped"});
  expectFailure(runProgram("simulate_ladar", {}), {"--out"});
  EXPECT_EQ(folder.list(), "");
}

TEST(SimulateLadar, RefusesAPathItCannotWrite) {
  const ScratchFolder folder;
  const std::string path = folder.file("no_such_folder/a.bag");
  expectFailure(runProgram("simulate_ladar", {"--scene", "forest", "--out", path}), {path});
  EXPECT_EQ(folder.list(), "");
  // A folder stands where the bag should go: known only when all is done, still no rest left.
  std::filesystem::create_directories(folder.file("taken.bag"));
  const std::string taken = folder.file("taken.bag");
  expectFailure(
      runProgram("simulate_ladar", {"--scene", "flat_ground", "--duration", "0.1", "--out", taken}),
      {taken});
  EXPECT_EQ(folder.list(), "taken.bag");
}

TEST(SimulateLadar, Helps) {
  expectHelp("simulate_ladar",
             {"--scene", "flat_ground", "forest", "tall_grass", "campus", "street", "scrubland",
              "--sensor", "vlp16", "pushbroom", "--sensor-height", "--look", "--duration",
              "--speed", "--seed", "--out"});
}

/// Poses of a PoseStamped topic by their stamps.
std::map<ros::Time, Eigen::Isometry3d> readPoses(const std::string& path,
                                                 const std::string& topic) {
  std::map<ros::Time, Eigen::Isometry3d> poses;
  const rosbag::Bag bag(path);
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery(topic))) {
    const auto pose = message.instantiate<geometry_msgs::PoseStamped>();
    EXPECT_EQ(pose->header.frame_id, "truth");
    geometry_msgs::Transform transform;
    transform.translation.x = pose->pose.position.x;
    transform.translation.y = pose->pose.position.y;
    transform.translation.z = pose->pose.position.z;
    transform.rotation = pose->pose.orientation;
    poses[pose->header.stamp] = poseOf(transform);
  }
  return poses;
}

TEST(SimulateLadar, OdometryDriftsInProportionToTheDistance) {
  const ScratchFolder folder;
  const std::vector<std::string> arguments = {
      "--scene", "campus", "--sensor", "pushbroom", "--speed", "10", "--duration", "2", "--out"};
  const auto simulate = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> all = arguments;
    all.push_back(folder.file(name));
    all.insert(all.end(), more.begin(), more.end());
    expectSuccess(runProgram("simulate_ladar", all));
    return folder.file(name);
  };
  const std::string exact = simulate("exact.bag", {});
  const std::string drifted =
      simulate("drifted.bag", {"--odometry-scale-error", "5", "--odometry-heading-drift", "20"});
  const auto truth = readTransforms(exact, "/tf").at({"odom", "base_link"});
  const auto odometry = readTransforms(drifted, "/tf").at({"odom", "base_link"});
  EXPECT_TRUE(readPoses(exact, "/ground_truth").empty());
  const auto recorded = readPoses(drifted, "/ground_truth");
  ASSERT_EQ(recorded.size(), truth.size());
  for (const auto& [stamp, pose] : recorded) {
    EXPECT_TRUE(pose.isApprox(truth.at(stamp), 1e-9)) << "the truth stays what it was";
  }
  // About 20 m: a metre too far along the track, 4 degrees to the left.
  double true_m = 0.0;
  double odometry_m = 0.0;
  for (auto it = truth.begin(); std::next(it) != truth.end(); ++it) {
    const auto& [stamp, next] = *std::next(it);
    true_m += (next.translation() - it->second.translation()).norm();
    odometry_m += (odometry.at(stamp).translation() - odometry.at(it->first).translation()).norm();
  }
  EXPECT_NEAR(odometry_m / true_m, 1.05, 1e-6);
  const Eigen::Matrix3d turned =
      truth.rbegin()->second.linear().transpose() * odometry.rbegin()->second.linear();
  const double degrees = Eigen::AngleAxisd(turned).angle() * 180.0 / M_PI;
  EXPECT_NEAR(degrees, 0.2 * true_m, 0.05);
  EXPECT_GT(turned(1, 0), 0.0) << "to the left";
  // What was measured is the same.
  const auto exact_clouds = readClouds(exact, "/points");
  const auto drifted_clouds = readClouds(drifted, "/points");
  ASSERT_EQ(exact_clouds.size(), drifted_clouds.size());
  for (std::size_t i = 0; i < exact_clouds.size(); ++i) {
    EXPECT_EQ(exact_clouds[i].cloud.data, drifted_clouds[i].cloud.data);
  }
}

}  // namespace
}  // namespace ladar_perception::test
