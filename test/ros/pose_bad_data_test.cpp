// SPDX-License-Identifier: BSD-3-Clause
// Clouds no pose can be made of: each is counted under its reason and told of once in a while, and
// the next good one makes a pose.
#include <limits>

#include "ros_pose_client.h"

namespace ladar_perception::test {
namespace {

constexpr double kDensity = 0.2;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class PoseBadData : public testing::Test {
 protected:
  /// Loads a re-sampler that makes a pose of every scan.
  void load(const std::string& policies) {
    poses_ = std::make_unique<LoadedPoses>("/bad", ParamMap{{"join", std::string("every_scan")},
                                                            {"count", 200},
                                                            {"tf_timeout_s", 1.0},
                                                            {"policies", policies}});
    ASSERT_TRUE(poses_->ready());
    client().sendMount();
    client().send(drive_.vehicleTransforms(0, 100));
  }
  void TearDown() override {
    if (!poses_) return;
    // Alive, and as good as before.
    ASSERT_TRUE(client().process(good()));
    expectAccounted(client().statistics);
    EXPECT_EQ(client().statistics.poses_published, ++published_);
  }
  PoseClient& client() { return **poses_; }
  sensor_msgs::PointCloud2 next() { return drive_.scan(scan_++, kDensity); }
  /// A scan that makes a pose whatever the policies need.
  sensor_msgs::PointCloud2 good() {
    CloudBuilder cloud = drive_.cloud(scan_, kDensity);
    std::vector<double> truth;
    readScalars(cloud.view(), *cloud.layout.find("truth"), &truth);
    for (auto& field : cloud.layout.fields) {
      if (field.name == "truth") field.name = "label";
      if (field.name == "intensity") field.name = "rgb";
    }
    return toMessage(cloud, drive_.scanStamp(scan_++), kSensorFrame);
  }

  /// Expects that a scan is dropped for `reason`, all its points with it, and makes no pose.
  void expectScanDropped(const sensor_msgs::PointCloud2& scan, const std::string& reason) {
    SCOPED_TRACE(reason);
    const PoseResamplerStatistics before = client().statistics;
    ASSERT_TRUE(client().process(scan));
    const PoseResamplerStatistics& after = client().statistics;
    EXPECT_EQ(after.scans, before.scans);
    EXPECT_EQ(after.poses, before.poses);
    EXPECT_EQ(countOf(after.scans_dropped, reason), countOf(before.scans_dropped, reason) + 1);
    EXPECT_EQ(after.points_in, after.points_kept + sumOf(after.points_dropped));
  }
  /// Expects that the scan's pose is dropped for `reason`, and told of with all of `parts`; without
  /// any it may have been told of just before.
  void expectPoseDropped(const sensor_msgs::PointCloud2& scan, const std::string& reason,
                         const std::vector<std::string>& parts) {
    SCOPED_TRACE(reason);
    LogListener log;
    ASSERT_TRUE(log.hears("/manager"));
    const PoseResamplerStatistics before = client().statistics;
    ASSERT_TRUE(client().process(scan));
    const PoseResamplerStatistics& after = client().statistics;
    EXPECT_EQ(after.poses, before.poses + 1);
    EXPECT_EQ(after.poses_published, before.poses_published);
    EXPECT_EQ(countOf(after.poses_dropped, reason), countOf(before.poses_dropped, reason) + 1);
    if (parts.empty()) return;
    ASSERT_TRUE(waitFor([&] { return log.count(reason) > 0; }));
    const std::string warning = log.find(reason);
    for (const std::string& part : parts) {
      EXPECT_NE(warning.find(part), std::string::npos) << part << " in: " << warning;
    }
  }

  Drive drive_;
  int scan_ = 0;
  uint64_t published_ = 0;
  std::unique_ptr<LoadedPoses> poses_;
};

TEST_F(PoseBadData, CloudsThatCannotBeRead) {
  load("range:min=3");
  sensor_msgs::PointCloud2 empty = next();
  empty.width = 0;
  empty.row_step = 0;
  empty.data.clear();
  expectScanDropped(empty, "empty");
  sensor_msgs::PointCloud2 no_z = next();
  no_z.fields[2].name = "depth";
  expectScanDropped(no_z, "bad_cloud");
  sensor_msgs::PointCloud2 truncated = next();
  truncated.data.resize(truncated.data.size() / 2);
  expectScanDropped(truncated, "bad_cloud");
  sensor_msgs::PointCloud2 wide = next();
  wide.width = 0xffffffff;
  wide.height = 1;
  expectScanDropped(wide, "bad_cloud");
}

TEST_F(PoseBadData, NeitherTimeNorPlace) {
  load("range:min=3");
  sensor_msgs::PointCloud2 no_stamp = next();
  no_stamp.header.stamp = ros::Time();
  expectScanDropped(no_stamp, "no_stamp");
  sensor_msgs::PointCloud2 elsewhere = next();
  elsewhere.header.frame_id = "elsewhere";
  LogListener log;
  ASSERT_TRUE(log.hears("/manager"));
  expectScanDropped(elsewhere, "no_transform");
  geometry_msgs::TransformStamped far = drive_.vehicleTransform(drive_.scanStamp(0));
  far.child_frame_id = "lost";
  far.header.frame_id = kVehicleFrame;
  far.transform.translation.x = 1e12;
  sensor_msgs::PointCloud2 scan = next();
  far.header.stamp = scan.header.stamp - ros::Duration(0.05);
  client().send({far});
  far.header.stamp = scan.header.stamp + ros::Duration(0.05);
  client().send({far});
  scan.header.frame_id = "lost";
  expectScanDropped(scan, "bad_pose");
}

TEST_F(PoseBadData, PointsThatAreNotFiniteAreLeftOut) {
  load("range:min=3");
  CloudBuilder cloud = drive_.cloud(scan_, kDensity);
  const ros::Time stamp = drive_.scanStamp(scan_++);
  uint64_t bad = 0;
  for (std::size_t i = 0; i < cloud.layout.pointCount(); i += 3) {
    cloud.set(i / cloud.layout.width, i % cloud.layout.width, i % 2 == 0 ? "x" : "z", kNaN);
    ++bad;
  }
  ASSERT_TRUE(client().process(toMessage(cloud, stamp, kSensorFrame)));
  ++published_;
  EXPECT_EQ(countOf(client().statistics.points_dropped, "not_finite"), bad);
  ASSERT_EQ(client().poses.size(), 1U);
  EXPECT_EQ(client().poses[0]->points_in, cloud.layout.pointCount() - bad);
  const std::vector<double> x = fieldValues(client().poses[0]->cloud, "x");
  EXPECT_EQ(x.size(), 200U);
  for (const double value : x) ASSERT_TRUE(std::isfinite(value));

  for (std::size_t i = 0; i < cloud.layout.pointCount(); ++i) {
    cloud.set(i / cloud.layout.width, i % cloud.layout.width, "y", kNaN);
  }
  expectScanDropped(toMessage(cloud, drive_.scanStamp(scan_++), kSensorFrame), "bad_cloud");
}

TEST_F(PoseBadData, TinyClouds) {
  load("range:min=3");
  // One point is no surface; whatever becomes of it, it is accounted for.
  for (const int points : {4, 8, 40}) {
    std::vector<Eigen::Vector3d> p_sensor;
    for (int i = 0; i < points; ++i) p_sensor.emplace_back(5.0 + 0.05 * i, 0.3 * (i % 2), -0.9);
    ASSERT_TRUE(client().process(
        toMessage(scanCloud(p_sensor, std::vector<uint8_t>(p_sensor.size(), 1), false),
                  drive_.scanStamp(scan_++), kSensorFrame)));
    expectAccounted(client().statistics);
  }
  published_ = client().statistics.poses_published;
  EXPECT_EQ(client().statistics.poses, 3U);
}

TEST_F(PoseBadData, ALabelPolicyWantsLabels) {
  load("label:linear=5,scatter=0.2");
  expectPoseDropped(next(), "missing_field", {"/bad/points", "label", "1000.000"});
}

TEST_F(PoseBadData, AColorPolicyDoesNotTakeTheColorsOfClasses) {
  load("color:target=#ff0000");
  expectPoseDropped(next(), "missing_field", {"/bad/points", "color", "rgb"});
  // Labelled, but without a camera's colours: red would be the surface.
  const CloudBuilder raw = drive_.cloud(scan_, kDensity);
  CloudLayout layout = labeledLayout(raw.layout);
  std::vector<uint8_t> bytes;
  const std::vector<PointLabel> labels(raw.layout.pointCount(), {1, 0.9F, 0xff0000U});
  writeLabeledCloud(raw.view(), labels, layout, &bytes);
  sensor_msgs::PointCloud2 labeled = next();
  setLayout(layout, &labeled);
  labeled.data = bytes;
  expectPoseDropped(labeled, "missing_field", {});
}

TEST_F(PoseBadData, OthersGoOn) {
  load("label:linear=5");
  LoadedPoses other("/other", {{"join", std::string("every_scan")}});
  ASSERT_TRUE(other.ready());
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(client().process(next()));
  other->send(drive_.vehicleTransforms(100, 110));
  for (int i = 100; i < 103; ++i) EXPECT_TRUE(other->keep(drive_.scan(i, kDensity)));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_bad_data_test");
}
