// SPDX-License-Identifier: BSD-3-Clause
// What the delayed-state nodelet and stand-alone node must both do; launched as
// delayed_state.launch does.
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "ros_process.h"
#include "ros_scene.h"
#include "ros_state_client.h"
#include "ros_yard.h"

namespace ladar_perception::test {

constexpr int kStatePoses = 12;
constexpr std::size_t kMapSamples = 300;  // of a pose, in the map

/// A node that stays for all cases of the program, with a dozen poses in its state.
class StateCases : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new StateClient("/delayed_state", "/", "slam_path");
    diagnostics_ = new DiagnosticsListener("delayed_state");
    ASSERT_TRUE(client_->connected());
    for (int i = 0; i < kStatePoses; ++i) ASSERT_TRUE(client_->add(drive().pose(i))) << i;
    ASSERT_TRUE(waitFor([] { return outputsAreOf(kStatePoses - 1); }));
  }
  static void TearDownTestSuite() {
    delete diagnostics_;
    delete client_;
  }
  static const YardDrive& drive() {
    static const YardDrive drive;
    return drive;
  }
  static bool outputsAreOf(int last_pose) {
    const ros::Time stamp = drive().stamp(last_pose);
    return client_->path().header.stamp == stamp && client_->graph().header.stamp == stamp &&
           client_->map().header.stamp == stamp && client_->statistics().header.stamp == stamp;
  }

  static StateClient* client_;
  static DiagnosticsListener* diagnostics_;
};

StateClient* StateCases::client_ = nullptr;
DiagnosticsListener* StateCases::diagnostics_ = nullptr;

inline double distanceTo(const geometry_msgs::Pose& pose, const Eigen::Isometry3d& T) {
  return (poseOf(pose).translation() - T.translation()).norm();
}

TEST_F(StateCases, ThePathIsWhereTheVehicleWas) {
  const nav_msgs::Path& path = client_->path();
  EXPECT_EQ(path.header.frame_id, "map");
  ASSERT_EQ(path.poses.size(), static_cast<std::size_t>(kStatePoses));
  for (int i = 0; i < kStatePoses; ++i) {
    EXPECT_EQ(path.poses[i].header.frame_id, "map");
    EXPECT_LT(std::abs((path.poses[i].header.stamp - drive().stamp(i)).toSec()), 1e-6);
    EXPECT_LT(distanceTo(path.poses[i].pose, YardDrive::truth(i)), 0.05) << i;
  }
  EXPECT_GT((YardDrive::odometry(kStatePoses - 1).translation() -
             YardDrive::truth(kStatePoses - 1).translation())
                .norm(),
            0.4)
      << "the odometry alone would not have done";
}

TEST_F(StateCases, TheGraphHasPosesWithCovariances) {
  const StateGraph& graph = client_->graph();
  EXPECT_EQ(graph.header.frame_id, "map");
  EXPECT_EQ(graph.odom_frame, "odom");
  EXPECT_EQ(graph.vehicle_frame, "base_link");
  ASSERT_EQ(graph.poses.size(), static_cast<std::size_t>(kStatePoses));
  for (int i = 0; i < kStatePoses; ++i) {
    const GraphPose& pose = graph.poses[i];
    EXPECT_EQ(pose.pose.pose.position.x, client_->path().poses[i].pose.position.x);
    EXPECT_LT(distanceTo(pose.odometry, YardDrive::odometry(i)), 1e-9);
    EXPECT_EQ(pose.samples, kYardSamples);
    const Eigen::Map<const Matrix6d> covariance(pose.pose.covariance.data());
    EXPECT_LT((covariance - covariance.transpose()).norm(), 1e-12);
    const double least = Eigen::SelfAdjointEigenSolver<Matrix6d>(covariance).eigenvalues()(0);
    EXPECT_EQ(covariance.norm() == 0.0, i == 0) << "the first pose is the map";
    EXPECT_EQ(least > 1e-9, i > 0) << least;
    EXPECT_LT(positionSigma(covariance), 0.2);
  }
}

TEST_F(StateCases, TheGraphHasConstraintsThatFit) {
  const StateGraph& graph = client_->graph();
  int odometry = 0;
  int registrations = 0;
  for (const GraphConstraint& constraint : graph.constraints) {
    ASSERT_LT(constraint.from, graph.poses.size());
    ASSERT_LT(constraint.to, graph.poses.size());
    const bool is_odometry = constraint.kind == GraphConstraint::ODOMETRY;
    (is_odometry ? odometry : registrations) += 1;
    const Eigen::Isometry3d T_from = poseOf(is_odometry ? graph.poses[constraint.from].odometry
                                                        : graph.poses[constraint.from].pose.pose);
    const Eigen::Isometry3d T_to = poseOf(is_odometry ? graph.poses[constraint.to].odometry
                                                      : graph.poses[constraint.to].pose.pose);
    const Vector6d error =
        minus(poseOf(constraint.transform), T_from.inverse(Eigen::Isometry) * T_to);
    EXPECT_LT(error.norm(), is_odometry ? 1e-9 : 0.05);
    const Eigen::Map<const Matrix6d> information(constraint.information.data());
    EXPECT_LT((information - information.transpose()).norm(), 1e-6 * information.norm());
    EXPECT_GT(information(0, 0), 0.0);
    EXPECT_TRUE(constraint.enabled);
    EXPECT_GE(constraint.chi2, 0.0);
  }
  EXPECT_EQ(odometry, kStatePoses - 1);
  EXPECT_GE(registrations, 2 * kStatePoses);
}

TEST_F(StateCases, TfCorrectsTheOdometryAndIsRepeated) {
  client_->transforms.clear();
  ASSERT_TRUE(waitFor([] { return client_->transforms.size() >= 4; })) << "no pose came meanwhile";
  const auto& all = client_->transforms;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].header.frame_id, "map");
    EXPECT_EQ(all[i].child_frame_id, "odom");
    EXPECT_TRUE(i == 0 || all[i].header.stamp > all[i - 1].header.stamp);
  }
  EXPECT_GT(all.back().header.stamp, ros::Time::now() - ros::Duration(1.0));
  const Eigen::Isometry3d T_map_pose =
      poseOf(all.back().transform) * YardDrive::odometry(kStatePoses - 1);
  EXPECT_LT(minus(T_map_pose, poseOf(client_->path().poses.back().pose)).norm(), 1e-9);
}

TEST_F(StateCases, TheMapHasTheFirstSamplesOfEveryPoseWhereItIs) {
  const sensor_msgs::PointCloud2& map = client_->map();
  EXPECT_EQ(map.header.frame_id, "map");
  EXPECT_TRUE(map.is_dense);
  ASSERT_EQ(map.width, kStatePoses * kMapSamples);
  ASSERT_EQ(map.data.size(), std::size_t{map.row_step} * map.height);
  const std::vector<double> x = fieldValues(map, "x"), y = fieldValues(map, "y"),
                            z = fieldValues(map, "z"), pose = fieldValues(map, "pose"),
                            nz = fieldValues(map, "normal_z");
  ASSERT_EQ(pose.size(), map.width);
  for (int i = 0; i < kStatePoses; ++i) {
    const PoseCloud sent = drive().pose(i);
    const std::vector<double> sx = fieldValues(sent.cloud, "x"), sy = fieldValues(sent.cloud, "y"),
                              sz = fieldValues(sent.cloud, "z"),
                              snz = fieldValues(sent.cloud, "normal_z");
    const Eigen::Isometry3d T = poseOf(client_->path().poses[i].pose);
    for (std::size_t k = 0; k < kMapSamples; ++k) {
      const std::size_t at = i * kMapSamples + k;
      ASSERT_EQ(pose[at], i);
      const Eigen::Vector3d expected = T * Eigen::Vector3d(sx[k], sy[k], sz[k]);
      ASSERT_LT((Eigen::Vector3d(x[at], y[at], z[at]) - expected).norm(), 1e-5);
      ASSERT_NEAR(nz[at], snz[k], 0.02);
    }
  }
}

TEST_F(StateCases, MarkersDrawTheGraph) {
  ASSERT_TRUE(waitFor([] { return !client_->markers().markers.empty(); }));
  std::map<std::string, std::size_t> points;
  for (const auto& marker : client_->markers().markers) {
    EXPECT_EQ(marker.header.frame_id, "map");
    const auto expected = marker.points.empty() ? visualization_msgs::Marker::DELETE
                                                : visualization_msgs::Marker::ADD;
    EXPECT_EQ(marker.action, expected) << marker.ns;
    points[marker.ns] = marker.points.size();
  }
  EXPECT_EQ(points["poses"], static_cast<std::size_t>(kStatePoses));
  EXPECT_EQ(points["odometry"], 2U * (kStatePoses - 1));
  EXPECT_EQ(points["odometry"] + points["registrations"] + points["loops"] + points["retired"],
            2 * client_->graph().constraints.size());
  EXPECT_GT(points["registrations"], 0U);
}

TEST_F(StateCases, StatisticsAddUp) {
  const DelayedStateStatistics& s = client_->statistics();
  expectAccounted(s);
  EXPECT_EQ(s.header.frame_id, "map");
  EXPECT_EQ(s.poses, static_cast<uint32_t>(kStatePoses));
  EXPECT_EQ(s.poses_added, static_cast<uint64_t>(kStatePoses));
  EXPECT_EQ(sumOf(s.poses_dropped), 0U);
  EXPECT_EQ(s.poses_missing, 0U);
  EXPECT_EQ(s.samples, kStatePoses * kYardSamples);
  EXPECT_EQ(s.cloud_bytes, s.samples * 24) << "positions and normals, and nothing else";
  EXPECT_EQ(s.odometry_constraints, static_cast<uint32_t>(kStatePoses - 1));
  EXPECT_EQ(s.odometry_constraints + s.registrations_accepted, client_->graph().constraints.size());
  EXPECT_GT(s.correction_m, 0.4F);
  EXPECT_NEAR(s.correction_deg, 0.5 * (kStatePoses - 1), 0.5);
  EXPECT_GT(s.lag_p50_ms, 0.0F);
  EXPECT_LE(s.lag_p50_ms, s.lag_p95_ms);
  EXPECT_LE(s.lag_p99_ms, s.lag_max_ms);
  ASSERT_EQ(s.stages.size(), 4U);
  EXPECT_EQ(s.stages.back().stage, "total");
  EXPECT_LE(s.stages.back().p50_ms, s.lag_max_ms);
  EXPECT_EQ(s.resets + s.loads, 0U);
}

TEST_F(StateCases, DiagnosticsTellHowItGoes) {
  std::map<std::string, std::string>& values = diagnostics_->values;
  ASSERT_TRUE(waitFor([&] { return values["poses"] == std::to_string(kStatePoses); }));
  EXPECT_TRUE(waitFor([] { return diagnostics_->summary == "estimating poses"; }))
      << diagnostics_->summary;
  for (const char* key :
       {"poses received", "poses waiting", "backlog (s)", "poses dropped: bad_cloud",
        "poses dropped: queue_full", "poses missing", "lag p99 (ms)", "adding: total p50 (ms)",
        "registrations refused: diverged", "loops closed", "clouds (MB)", "correction (m)"}) {
    EXPECT_EQ(values.count(key), 1U) << key;
  }
}

TEST_F(StateCases, WhoComesLateGetsThePresentState) {
  Heard<StateGraph> graph(ros::NodeHandle(), "pose_graph");
  Heard<sensor_msgs::PointCloud2> map(ros::NodeHandle(), "map_cloud");
  EXPECT_TRUE(waitFor([&] { return graph.count > 0 && map.count > 0; }));
  EXPECT_EQ(graph.last().poses.size(), static_cast<std::size_t>(kStatePoses));
  EXPECT_EQ(map.last().width, kStatePoses * kMapSamples);
}

TEST_F(StateCases, SavedForgottenAndLoadedItIsTheSame) {
  TemporaryFolder folder;
  const std::string file = folder.file("state.bin");
  const std::string again = folder.file("again.bin");
  std::string message;
  ASSERT_TRUE(client_->save(file, &message)) << message;
  EXPECT_NE(message.find(file), std::string::npos);
  const StateGraph before = client_->graph();

  ASSERT_TRUE(client_->reset());
  ASSERT_TRUE(waitFor([] { return client_->path().poses.empty() && client_->map().width == 0; }));
  EXPECT_TRUE(client_->waitForStatistics([](const auto& s) { return s.resets == 1; }));
  EXPECT_EQ(client_->statistics().poses, 0U);
  EXPECT_EQ(client_->statistics().cloud_bytes, 0U);
  EXPECT_TRUE(waitFor([] {
    return minus(poseOf(client_->transforms.back().transform), Eigen::Isometry3d::Identity())
               .norm() == 0.0;
  }));

  ASSERT_TRUE(client_->load(file, &message)) << message;
  ASSERT_TRUE(waitFor([] { return outputsAreOf(kStatePoses - 1); }));
  EXPECT_EQ(client_->graph().poses.size(), before.poses.size());
  EXPECT_EQ(client_->graph().constraints.size(), before.constraints.size());
  for (std::size_t i = 0; i < before.poses.size(); ++i) {
    EXPECT_EQ(client_->graph().poses[i].pose, before.poses[i].pose) << i;
  }
  ASSERT_TRUE(client_->save(again));
  EXPECT_TRUE(textOf(file) == textOf(again)) << "the bytes differ";
  EXPECT_TRUE(client_->waitForStatistics([](const auto& s) { return s.loads == 1; }));

  // The drive goes on.
  ASSERT_TRUE(client_->add(drive().pose(kStatePoses)));
  ASSERT_TRUE(waitFor([] { return outputsAreOf(kStatePoses); }));
  EXPECT_LT(distanceTo(client_->path().poses.back().pose, YardDrive::truth(kStatePoses)), 0.05);
  ASSERT_TRUE(client_->optimize());
  EXPECT_LT(distanceTo(client_->path().poses.back().pose, YardDrive::truth(kStatePoses)), 0.05);
}

TEST_F(StateCases, ServicesSayWhyTheyCannot) {
  std::string message;
  EXPECT_FALSE(client_->save("state.bin", &message));
  EXPECT_NE(message.find("'state.bin' is not absolute"), std::string::npos) << message;
  EXPECT_FALSE(client_->save("/no/such/folder/state.bin", &message));
  EXPECT_NE(message.find("/no/such/folder/state.bin: cannot be written"), std::string::npos)
      << message;
  EXPECT_FALSE(client_->load("/no/such/file", &message));
  EXPECT_NE(message.find("/no/such/file: cannot be opened"), std::string::npos) << message;
  EXPECT_FALSE(client_->load(kTestStateConfig, &message));
  EXPECT_NE(message.find("is no saved delayed state"), std::string::npos) << message;
  EXPECT_EQ(client_->statistics().poses, static_cast<uint32_t>(kStatePoses + 1)) << "as before";
}

}  // namespace ladar_perception::test
