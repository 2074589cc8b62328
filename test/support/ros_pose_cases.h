// SPDX-License-Identifier: BSD-3-Clause
// What the pose re-sampler's nodelet and stand-alone node must both do; launched as
// pose_resampler.launch does.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "ros_pose_client.h"

namespace ladar_perception::test {

constexpr int kPoseCaseScans = 10;  // every third of which makes a pose
constexpr int kPoseCasePoses = 4;
constexpr std::size_t kPoseCaseSamples = 800;

/// A node that stays for all cases of the program.
class PoseCases : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new PoseClient("/pose_resampler");
    diagnostics_ = new DiagnosticsListener("pose_resampler");
    ASSERT_TRUE(client_->connected());
    client_->sendMount();
  }
  static void TearDownTestSuite() {
    delete diagnostics_;
    delete client_;
  }

  static PoseClient* client_;
  static DiagnosticsListener* diagnostics_;
};

PoseClient* PoseCases::client_ = nullptr;
DiagnosticsListener* PoseCases::diagnostics_ = nullptr;

inline std::vector<Eigen::Vector3d> positionsIn(const sensor_msgs::PointCloud2& cloud) {
  const CloudLayout layout = layoutOf(cloud);
  const CloudView view{layout, cloud.data.data(), cloud.data.size()};
  std::string error;
  const auto fields = findPointFields(view, &error);
  std::vector<Eigen::Vector3d> positions;
  if (fields) readPositions(view, *fields, &positions);
  return positions;
}

/// Poses as they were driven, in the frames they were asked for.
inline void expectPose(const PoseCloud& pose, const Drive& drive) {
  EXPECT_EQ(pose.header.frame_id, kMapFrame);
  EXPECT_EQ(pose.vehicle_frame, kVehicleFrame);
  EXPECT_EQ(pose.cloud.header.frame_id, kVehicleFrame);
  EXPECT_EQ(pose.cloud.header.stamp, pose.header.stamp);
  const Eigen::Isometry3d T_odom_vehicle = vehiclePose(drive.secondsInto(pose.header.stamp));
  const auto& p = pose.pose.pose.position;
  const auto& q = pose.pose.pose.orientation;
  // tf interpolates between poses 20 ms apart.
  EXPECT_LT((Eigen::Vector3d(p.x, p.y, p.z) - T_odom_vehicle.translation()).norm(), 1e-6);
  const Eigen::Quaterniond expected(T_odom_vehicle.linear());
  EXPECT_LT(expected.angularDistance(Eigen::Quaterniond(q.w, q.x, q.y, q.z)), 1e-6);
  const Eigen::Vector3d sensor = sensorMount().translation();
  EXPECT_NEAR(pose.sensor.x, sensor.x(), 1e-6);
  EXPECT_NEAR(pose.sensor.y, sensor.y(), 1e-6);
  EXPECT_NEAR(pose.sensor.z, sensor.z(), 1e-6);
}

/// Samples lie where the scan has points, carry the fields of the nearest, and come farthest first.
inline void expectSamples(const sensor_msgs::PointCloud2& cloud,
                          const sensor_msgs::PointCloud2& scan) {
  ASSERT_EQ(std::size_t{cloud.width} * cloud.height, kPoseCaseSamples);
  EXPECT_EQ(cloud.data.size(), std::size_t{cloud.row_step} * cloud.height);
  EXPECT_TRUE(cloud.is_dense);
  const std::vector<Eigen::Vector3d> p_vehicle = positionsIn(cloud);
  std::vector<Eigen::Vector3d> originals = positionsIn(scan);
  for (Eigen::Vector3d& p : originals) p = sensorMount() * p;
  const std::vector<double> intensity_in = fieldValues(scan, "intensity");
  const std::vector<double> intensity = fieldValues(cloud, "intensity");
  const std::vector<double> truth = fieldValues(cloud, "truth");
  const std::vector<double> radius = fieldValues(cloud, "covering_radius");
  const std::vector<double> nx = fieldValues(cloud, "normal_x");
  const std::vector<double> ny = fieldValues(cloud, "normal_y");
  const std::vector<double> nz = fieldValues(cloud, "normal_z");
  ASSERT_EQ(truth.size(), kPoseCaseSamples);
  ASSERT_EQ(fieldValues(cloud, "ring").size(), kPoseCaseSamples);
  ASSERT_EQ(radius.size(), kPoseCaseSamples);
  ASSERT_EQ(nz.size(), kPoseCaseSamples);
  int right = 0, near = 0, unit = 0;
  for (std::size_t i = 0; i < kPoseCaseSamples; ++i) {
    const auto nearest =
        std::min_element(originals.begin(), originals.end(), [&](const auto& a, const auto& b) {
          return (a - p_vehicle[i]).squaredNorm() < (b - p_vehicle[i]).squaredNorm();
        });
    near += (*nearest - p_vehicle[i]).norm() < 0.25 ? 1 : 0;
    right += intensity_in[static_cast<std::size_t>(nearest - originals.begin())] == intensity[i];
    unit += std::abs(Eigen::Vector3d(nx[i], ny[i], nz[i]).norm() - 1.0) < 1e-3 ? 1 : 0;
  }
  EXPECT_GT(radius.front(), 3.0 * radius.back()) << "farthest first";
  // Float32 positions move a few across the middle between two points.
  EXPECT_GE(right, static_cast<int>(kPoseCaseSamples) - 8);
  // Far from the sensor samples lie in gaps between scan lines, too, and in cells of half a metre.
  EXPECT_GE(near, static_cast<int>(0.8 * kPoseCaseSamples));
  EXPECT_GE(unit, static_cast<int>(0.95 * kPoseCaseSamples));
}

TEST_F(PoseCases, EveryThirdScanMakesAPose) {
  const Drive drive;
  client_->send(drive.vehicleTransforms(0, kPoseCaseScans));
  for (int i = 0; i < kPoseCaseScans; ++i) {
    client_->sendOdometry(drive.scanStamp(i) + ros::Duration(0.01), 0.01 * (i + 1));
  }
  client_->sendOdometry(drive.scanStamp(0), 99.0, "map");
  client_->sendOdometry(drive.scanStamp(0), 99.0, kMapFrame, "trailer");
  ASSERT_TRUE(client_->waitForStatistics(
      [](const auto& s) { return s.odometry == kPoseCaseScans && s.odometry_ignored == 2; }));
  for (int i = 0; i < kPoseCaseScans; ++i) ASSERT_TRUE(client_->process(drive.scan(i)));
  ASSERT_TRUE(waitFor([] { return client_->poses.size() >= kPoseCasePoses; }));
  ASSERT_EQ(client_->poses.size(), static_cast<std::size_t>(kPoseCasePoses));
  for (int i = 0; i < kPoseCasePoses; ++i) {
    SCOPED_TRACE("pose " + std::to_string(i));
    const PoseCloud& pose = *client_->poses[i];
    const sensor_msgs::PointCloud2 scan = drive.scan(3 * i);
    EXPECT_EQ(pose.id, static_cast<uint64_t>(i));
    EXPECT_EQ(pose.header.stamp, scan.header.stamp);
    EXPECT_EQ(pose.last_scan, scan.header.stamp);
    EXPECT_EQ(pose.scans, 1U);
    EXPECT_EQ(pose.points_in, uint64_t{scan.width} * scan.height);
    EXPECT_DOUBLE_EQ(pose.pose.covariance[0], 0.01 * (3 * i + 1));
    EXPECT_DOUBLE_EQ(pose.pose.covariance[35], 0.005 * (3 * i + 1));
    expectPose(pose, drive);
    expectSamples(pose.cloud, scan);
  }
}

TEST_F(PoseCases, ThePlainCloudIsThePosesCloud) {
  ASSERT_TRUE(waitFor([] { return client_->clouds.size() >= kPoseCasePoses; }));
  ASSERT_EQ(client_->clouds.size(), client_->poses.size());
  for (std::size_t i = 0; i < client_->clouds.size(); ++i) {
    const sensor_msgs::PointCloud2& cloud = *client_->clouds[i];
    const sensor_msgs::PointCloud2& of_pose = client_->poses[i]->cloud;
    EXPECT_EQ(cloud.header.stamp, of_pose.header.stamp);
    EXPECT_EQ(cloud.header.frame_id, of_pose.header.frame_id);
    EXPECT_EQ(layoutOf(cloud).describeFields(), layoutOf(of_pose).describeFields());
    EXPECT_TRUE(cloud.data == of_pose.data);
  }
}

TEST_F(PoseCases, ThePathHasEveryPose) {
  ASSERT_TRUE(waitFor([] { return client_->path.poses.size() >= kPoseCasePoses; }));
  EXPECT_EQ(client_->path.header.frame_id, kMapFrame);
  ASSERT_EQ(client_->path.poses.size(), client_->poses.size());
  for (std::size_t i = 0; i < client_->poses.size(); ++i) {
    const geometry_msgs::PoseStamped& at = client_->path.poses[i];
    EXPECT_EQ(at.header.stamp, client_->poses[i]->header.stamp);
    EXPECT_EQ(at.pose.position.x, client_->poses[i]->pose.pose.position.x);
    EXPECT_EQ(at.pose.orientation.z, client_->poses[i]->pose.pose.orientation.z);
  }
}

TEST_F(PoseCases, StatisticsAddUp) {
  const uint64_t points = Drive().cloud(0).layout.pointCount();
  ASSERT_TRUE(client_->waitForStatistics([](const auto& s) {
    return s.scans == kPoseCaseScans && s.poses_published == kPoseCasePoses;
  }));
  const PoseResamplerStatistics& s = client_->statistics;
  expectAccounted(s);
  EXPECT_EQ(s.points_in, kPoseCaseScans * points);
  EXPECT_EQ(s.points_kept, kPoseCasePoses * points);
  EXPECT_EQ(countOf(s.points_dropped, "between"), (kPoseCaseScans - kPoseCasePoses) * points);
  EXPECT_EQ(s.scans_between, static_cast<uint64_t>(kPoseCaseScans - kPoseCasePoses));
  EXPECT_EQ(sumOf(s.scans_dropped), 0U);
  EXPECT_EQ(sumOf(s.poses_dropped), 0U);
  EXPECT_EQ(s.poses, static_cast<uint64_t>(kPoseCasePoses));
  EXPECT_EQ(s.samples, kPoseCasePoses * kPoseCaseSamples);
  EXPECT_EQ(s.header.stamp, Drive().scanStamp(9));
  EXPECT_EQ(s.header.frame_id, kMapFrame);
  EXPECT_EQ(s.policies, "range:min=12 normal_variation:mode=attract");
  EXPECT_EQ(s.scans_waiting, 0U);
  EXPECT_EQ(s.resets, 0U);
  EXPECT_GT(s.lag_p50_ms, 0.0F);
  EXPECT_LE(s.lag_p50_ms, s.lag_p99_ms);
  EXPECT_LE(s.lag_p99_ms, s.lag_max_ms);
  ASSERT_EQ(s.stages.size(), 6U);
  EXPECT_EQ(s.stages.back().stage, "total");
  EXPECT_GT(s.stages.back().p50_ms, 0.0F);
  EXPECT_LE(s.stages.back().p50_ms, s.lag_max_ms);
}

TEST_F(PoseCases, DiagnosticsTellHowItGoes) {
  std::map<std::string, std::string>& values = diagnostics_->values;
  ASSERT_TRUE(waitFor([&] { return values["poses published"] == std::to_string(kPoseCasePoses); }))
      << "poses published: " << values["poses published"];
  for (const char* key :
       {"scans", "scans between poses", "scans waiting", "scans dropped: no_transform",
        "scans dropped: queue_full", "points dropped: too_near", "poses", "poses waiting",
        "backlog (s)", "poses dropped: missing_field", "lag p50 (ms)", "lag p99 (ms)",
        "re-sampling: total p50 (ms)", "samples", "resets", "policies"}) {
    EXPECT_EQ(values.count(key), 1U) << key;
  }
}

TEST_F(PoseCases, AServiceMakesThePoseThatTheRulesWouldNot) {
  const Drive drive;
  const std::size_t poses = client_->poses.size();
  const sensor_msgs::PointCloud2 same = drive.scan(kPoseCaseScans - 1);
  ASSERT_TRUE(client_->process(same));
  ASSERT_EQ(client_->poses.size(), poses) << "the vehicle has not moved";
  ASSERT_TRUE(client_->addPose());
  const auto pose = client_->keep(same);
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->id, poses);
  ASSERT_TRUE(client_->process(same));
  EXPECT_EQ(client_->poses.size(), poses + 1) << "one only";
}

TEST_F(PoseCases, ResetBeginsAPathAndLosesNoPose) {
  const std::size_t poses = client_->poses.size();
  ASSERT_TRUE(client_->reset());
  ASSERT_TRUE(waitFor([] { return client_->path.poses.empty(); }));
  ASSERT_TRUE(client_->waitForStatistics([](const auto& s) { return s.resets == 1; }));
  const auto pose = client_->keep(Drive().scan(kPoseCaseScans - 1));
  ASSERT_TRUE(pose) << "the first scan of a path makes a pose";
  EXPECT_EQ(pose->id, poses) << "ids are not used again";
  ASSERT_TRUE(waitFor([] { return client_->path.poses.size() == 1; }));
  EXPECT_EQ(client_->path.poses[0].header.stamp, pose->header.stamp);
  ASSERT_TRUE(
      client_->waitForStatistics([&](const auto& s) { return s.poses_published == poses + 1; }));
  expectAccounted(client_->statistics);
}

}  // namespace ladar_perception::test
