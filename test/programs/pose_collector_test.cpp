// SPDX-License-Identifier: BSD-3-Clause
// What the pose re-sampler does between messages and the core; no ROS master needed.
#include "pose_collector.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "odometry_log.h"
#include "ros_scene.h"

namespace ladar_perception::test {
namespace {

constexpr double kDensity = 0.1;

bool atOnce(const std::function<bool()>& ready) { return ready(); }

class PoseCollection : public testing::Test {
 protected:
  PoseCollection() {
    buffer_.setTransform(transformMessage(ros::Time(1), kVehicleFrame, kSensorFrame, sensorMount()),
                         "test", true);
    config_.keeper.pose_distance_m = 0.25;
  }
  void drive(int begin, int end) {
    for (const auto& transform : drive_.vehicleTransforms(begin, end)) {
      buffer_.setTransform(transform, "test");
    }
  }
  sensor_msgs::PointCloud2 scan(int i) const { return drive_.scan(i, kDensity); }

  tf2::BufferCore buffer_{ros::Duration(60.0)};
  PoseResamplerNodeConfig config_;
  Drive drive_;
};

TEST_F(PoseCollection, APoseIsOfTheVehicleOrOfTheSensorItself) {
  drive(0, 1);
  PoseCollector of_vehicle(config_, &buffer_);
  config_.vehicle_frame.clear();
  PoseCollector of_sensor(config_, &buffer_);
  const CollectOutcome vehicle = of_vehicle.process(scan(0), atOnce);
  const CollectOutcome sensor = of_sensor.process(scan(0), atOnce);
  ASSERT_EQ(vehicle.complete.size(), 1U);
  ASSERT_EQ(sensor.complete.size(), 1U);
  EXPECT_EQ(vehicle.complete[0].vehicle_frame, kVehicleFrame);
  EXPECT_EQ(sensor.complete[0].vehicle_frame, kSensorFrame);
  const KeptPose& a = vehicle.complete[0].pose;
  const KeptPose& b = sensor.complete[0].pose;
  EXPECT_LT(b.points.sensor_m.norm(), 1e-9);
  EXPECT_TRUE((a.T_map_vehicle * sensorMount()).isApprox(b.T_map_vehicle, 1e-6));
  ASSERT_EQ(a.points.positions_m.size(), b.points.positions_m.size());
  for (std::size_t i = 0; i < a.points.positions_m.size(); ++i) {
    EXPECT_LT((a.points.positions_m[i] - sensorMount() * b.points.positions_m[i]).norm(), 1e-6);
  }
}

TEST_F(PoseCollection, ADroppedScanChangesNothing) {
  PoseCollector collector(config_, &buffer_);
  const CollectOutcome lost = collector.process(scan(0), atOnce);
  EXPECT_EQ(lost.drop, ScanDrop::kNoTransform);
  EXPECT_NE(lost.detail.find(kMapFrame), std::string::npos) << lost.detail;
  EXPECT_FALSE(lost.use.joined);
  EXPECT_FALSE(collector.gathering());
  drive(0, 2);
  EXPECT_TRUE(collector.process(scan(0), atOnce).use.joined);
}

TEST_F(PoseCollection, TimeThatJumpsBackBeginsAJourney) {
  config_.keeper.gather = "until_next";
  PoseCollector collector(config_, &buffer_);
  drive(0, 9);
  for (int i = 0; i < 8; ++i) EXPECT_FALSE(collector.process(scan(i), atOnce).time_jumped);
  const CollectOutcome jumped = collector.process(scan(0), atOnce);
  EXPECT_TRUE(jumped.time_jumped);
  EXPECT_TRUE(jumped.use.joined);
  ASSERT_EQ(jumped.complete.size(), 1U) << "what was being gathered is complete";
  EXPECT_EQ(jumped.complete[0].pose.id, 2U);
  EXPECT_EQ(jumped.complete[0].pose.scans, 2U);
  EXPECT_EQ(jumped.complete[0].journey, 0U);
  EXPECT_EQ(collector.journey(), 1U);
  EXPECT_FALSE(collector.process(scan(1), atOnce).time_jumped);
  const auto last = collector.reset();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->pose.id, 3U);
  EXPECT_EQ(last->journey, 1U);
  EXPECT_FALSE(collector.process(scan(0), atOnce).time_jumped) << "a reset forgets the time";
}

TEST_F(PoseCollection, AJumpIsNotForgottenWhenPlacingThrows) {
  // A tf buffer that is cleared between the question and the look-up throws.
  PoseCollector collector(config_, &buffer_);
  drive(0, 9);
  collector.process(scan(8), atOnce);
  const auto clearing = [this](const std::function<bool()>& ready) {
    const bool there = ready();
    buffer_.clear();
    return there;
  };
  EXPECT_THROW(collector.process(scan(0), clearing), std::exception);
  drive(0, 9);
  EXPECT_TRUE(collector.process(scan(1), atOnce).time_jumped);
  EXPECT_FALSE(collector.process(scan(2), atOnce).time_jumped) << "once";
}

TEST(OdometryLog, GivesTheNearestCovarianceThatIsNearEnough) {
  OdometryLog log("odom", "base_link", 0.1);
  const auto add = [&](double stamp_s, double variance, const char* frame = "odom",
                       const char* child = "base_link") {
    nav_msgs::Odometry odometry;
    odometry.header.stamp = ros::Time(stamp_s);
    odometry.header.frame_id = frame;
    odometry.child_frame_id = child;
    odometry.pose.covariance[7] = variance;
    log.add(odometry);
  };
  const auto at = [&](double stamp_s) { return log.covarianceAt(ros::Time(stamp_s))[7]; };
  EXPECT_EQ(at(10.0), 0.0);
  add(10.0, 1.0);
  add(10.1, 2.0);
  add(10.5, 3.0);
  add(10.3, 99.0, "map");
  add(10.3, 99.0, "odom", "trailer");
  EXPECT_EQ(log.taken(), 3U);
  EXPECT_EQ(log.ignored(), 2U);
  EXPECT_EQ(at(10.0), 1.0);
  EXPECT_EQ(at(9.95), 1.0);
  EXPECT_EQ(at(10.04), 1.0);
  EXPECT_EQ(at(10.06), 2.0);
  EXPECT_EQ(at(10.3), 0.0) << "neither is near enough";
  EXPECT_EQ(at(10.55), 3.0);
  EXPECT_EQ(at(10.65), 0.0);
  // Time that jumped back: what comes now counts alone.
  add(10.2, 4.0);
  EXPECT_EQ(at(10.0), 0.0);
  EXPECT_EQ(at(10.5), 0.0);
  EXPECT_EQ(at(10.25), 4.0);
  // A vehicle frame that is the cloud's own has no odometry.
  OdometryLog none("odom", "", 0.1);
  nav_msgs::Odometry odometry;
  odometry.header.frame_id = "odom";
  none.add(odometry);
  EXPECT_EQ(none.ignored(), 1U);
}

}  // namespace
}  // namespace ladar_perception::test
