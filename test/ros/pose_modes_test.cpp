// SPDX-License-Identifier: BSD-3-Clause
// Ways to choose poses and to gather their clouds.
#include "ros_pose_client.h"

namespace ladar_perception::test {
namespace {

constexpr double kDensity = 0.25;

class PoseModes : public testing::Test {
 protected:
  /// Scans [0, scans) of the drive with their transforms, one after the other.
  void drive(PoseClient* client, int scans, bool with_time = false) {
    client->sendMount();
    client->send(drive_.vehicleTransforms(0, scans + 1));
    for (int i = 0; i < scans; ++i) {
      ASSERT_TRUE(waitForScan(client, drive_.scan(i, kDensity, with_time)));
    }
  }
  /// A scan that may leave a pose waiting that is being gathered.
  static bool waitForScan(PoseClient* client, const sensor_msgs::PointCloud2& scan) {
    const uint64_t done = client->scansDone();
    client->send(scan);
    return waitFor([&] { return client->scansDone() > done; });
  }

  Drive drive_;
  const uint64_t points_ = drive_.cloud(0, kDensity).layout.pointCount();
};

TEST_F(PoseModes, EveryScan) {
  LoadedPoses poses("/every", {{"join", std::string("every_scan")}});
  ASSERT_TRUE(poses.ready());
  drive(&*poses, 4);
  ASSERT_TRUE(waitFor([&] { return poses->poses.size() == 4; }));
  EXPECT_EQ(poses->poses[3]->id, 3U);
  // Nobody sends odometry: an unknown covariance is not invented.
  for (const double value : poses->poses[3]->pose.covariance) EXPECT_EQ(value, 0.0);
}

TEST_F(PoseModes, OnRequestOnly) {
  LoadedPoses poses("/asked", {{"join", std::string("on_request")}});
  ASSERT_TRUE(poses.ready());
  drive(&*poses, 5);
  EXPECT_TRUE(poses->poses.empty());
  EXPECT_EQ(poses->statistics.scans_between, 5U);
  poses->send(drive_.vehicleTransforms(6, 9));
  ASSERT_TRUE(poses->addPose());
  // A scan that cannot be used does not use the request up.
  sensor_msgs::PointCloud2 empty = drive_.scan(6, kDensity);
  empty.width = 0;
  ASSERT_TRUE(waitForScan(&*poses, empty));
  const auto pose = poses->keep(drive_.scan(6, kDensity));
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->id, 0U);
  ASSERT_TRUE(poses->process(drive_.scan(7, kDensity)));
  EXPECT_EQ(poses->poses.size(), 1U);
}

TEST_F(PoseModes, CloudsAreGatheredUntilTheNextPose) {
  LoadedPoses poses("/gather", {{"gather", std::string("until_next")},
                                {"gather_timeout_s", 0.5},
                                {"count", 3000},
                                {"policies", std::string()}});
  ASSERT_TRUE(poses.ready());
  drive(&*poses, 8);  // poses join with scans 0, 3 and 6
  EXPECT_EQ(poses->statistics.poses, 3U);
  // The last has no next; it is complete when no more scans come.
  ASSERT_TRUE(waitFor([&] { return poses->poses.size() == 3; }));
  for (int i = 0; i < 3; ++i) {
    const PoseCloud& pose = *poses->poses[i];
    EXPECT_EQ(pose.header.stamp, drive_.scanStamp(3 * i));
    EXPECT_EQ(pose.scans, i < 2 ? 3U : 2U);
    EXPECT_EQ(pose.points_in, pose.scans * points_);
    EXPECT_EQ(pose.last_scan, drive_.scanStamp(i < 2 ? 3 * i + 2 : 7));
  }
  ASSERT_TRUE(poses->waitForStatistics([](const auto& s) { return s.poses_published == 3; }));
  expectAccounted(poses->statistics);
  EXPECT_EQ(poses->statistics.scans_between, 0U);

  // The scene stands still: every scan's floor and wall lie where the first one's do. Unmoved, the
  // wall of the third scan would be 8 cm off at its ends.
  const PoseCloud& pose = *poses->poses[0];
  const std::vector<double> truth = fieldValues(pose.cloud, "truth");
  const std::vector<double> x = fieldValues(pose.cloud, "x"), y = fieldValues(pose.cloud, "y"),
                            z = fieldValues(pose.cloud, "z");
  int surface = 0, near = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] != kSurfaceLabel) continue;
    ++surface;
    near += std::abs(z[i] - 0.02) < 0.05 || std::abs(y[i] - 6.5) < 0.05 ? 1 : 0;
  }
  EXPECT_GT(surface, 1000);
  EXPECT_GT(near, 0.97 * surface);
}

TEST_F(PoseModes, AServiceCompletesWhatIsGathered) {
  LoadedPoses poses("/close", {{"gather", std::string("until_next")},
                               {"join", std::string("on_request")},
                               {"gather_timeout_s", 1000.0}});
  ASSERT_TRUE(poses.ready());
  ASSERT_TRUE(poses->addPose());
  drive(&*poses, 3);
  EXPECT_EQ(poses->statistics.poses_waiting, 1U);
  EXPECT_TRUE(poses->poses.empty());
  ASSERT_TRUE(poses->addPose());
  ASSERT_TRUE(waitForScan(&*poses, drive_.scan(2, kDensity)));
  ASSERT_TRUE(waitFor([&] { return poses->poses.size() == 1; }));
  EXPECT_EQ(poses->poses[0]->scans, 3U);
  // A reset completes what is gathered as well.
  ASSERT_TRUE(poses->reset());
  ASSERT_TRUE(waitFor([&] { return poses->poses.size() == 2; }));
  EXPECT_EQ(poses->poses[1]->scans, 1U);
  EXPECT_TRUE(poses->path.poses.empty());
}

TEST_F(PoseModes, PointsArePlacedByTheirTimes) {
  // The points' times say that they were measured after the stamp, up to 40 ms, while the vehicle
  // turned; the scene was made for the stamp. With compensation they are off, as they should be.
  const auto meanX = [&](const std::string& ns, bool compensation) {
    LoadedPoses poses(ns, {{"join", std::string("every_scan")},
                           {"motion_compensation", compensation},
                           {"nearest_original", true},
                           {"policies", std::string()},
                           {"count", 4000}});
    EXPECT_TRUE(poses.ready());
    drive(&*poses, 1, true);
    EXPECT_TRUE(waitFor([&] { return poses->poses.size() == 1; }));
    double sum = 0.0;
    if (poses->poses.empty()) return sum;
    // What the points' own times moved them by: 1 m/s times the time.
    const sensor_msgs::PointCloud2& cloud = poses->poses[0]->cloud;
    const std::vector<double> x = fieldValues(cloud, "x"), time = fieldValues(cloud, "time"),
                              intensity = fieldValues(cloud, "intensity");
    const sensor_msgs::PointCloud2 scan = drive_.scan(0, kDensity, true);
    const std::vector<double> time_in = fieldValues(scan, "time");
    std::map<double, Eigen::Vector3d> by_time;
    const CloudLayout layout = layoutOf(scan);
    std::string error;
    const CloudView view{layout, scan.data.data(), scan.data.size()};
    std::vector<Eigen::Vector3d> p_sensor;
    readPositions(view, *findPointFields(view, &error), &p_sensor);
    for (std::size_t i = 0; i < time_in.size(); ++i) by_time[time_in[i]] = p_sensor[i];
    double most_time = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Eigen::Isometry3d T = compensation ? vehiclePose(time[i]) : vehiclePose(0.0);
      const double expected = (T * sensorMount() * by_time[time[i]]).x();
      sum = std::max(sum, std::abs(x[i] - expected));
      most_time = std::max(most_time, time[i]);
    }
    EXPECT_GT(most_time, 0.03);
    return sum;
  };
  // Float32, and a step of the table of poses.
  EXPECT_LT(meanX("/moved", true), 1e-4);
  EXPECT_LT(meanX("/unmoved", false), 1e-5);
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_modes_test");
}
