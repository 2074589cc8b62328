// SPDX-License-Identifier: BSD-3-Clause
// What stands around a pose re-sampler in a test: a source of scans, transforms and odometry, and a
// reader of all it publishes.
#pragma once

#include <ladar_perception/PoseCloud.h>
#include <ladar_perception/PoseResamplerStatistics.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>

#include <string>
#include <vector>

#include "ros_terrain_client.h"

namespace ladar_perception::test {

const std::string kTestPoseConfig =
    std::string(LADAR_SOURCE_DIR) + "/test/data/ros_pose_resampler.yaml";

/// Feeds the pose re-sampler whose topics lie in namespace `ns` and collects what it publishes.
class PoseClient {
 public:
  static constexpr const char* kNodelet = "ladar_perception/PoseResamplerNodelet";
  static constexpr const char* kName = "poses";
  static ParamMap testParameters() { return loadParamFile(kTestPoseConfig); }

  explicit PoseClient(const std::string& node_name, const std::string& ns = "/")
      : node_name_(node_name), handle_(ns) {
    points_ = handle_.advertise<sensor_msgs::PointCloud2>("points", 1000);
    odometry_ = handle_.advertise<nav_msgs::Odometry>("odom", 1000);
    // One latched message holds all static transforms.
    tf_static_ = handle_.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
    tf_ = handle_.advertise<tf2_msgs::TFMessage>("/tf", 1000);
    // Another nodelet of the same manager may listen already; they share a connection.
    tf_others_ = tf_.getNumSubscribers();
    poses_sub_ = handle_.subscribe<PoseCloud>(
        "pose_cloud", 1000, [this](const PoseCloudConstPtr& pose) { poses.push_back(pose); });
    clouds_sub_ = handle_.subscribe<sensor_msgs::PointCloud2>(
        "resampled_points", 1000,
        [this](const sensor_msgs::PointCloud2ConstPtr& cloud) { clouds.push_back(cloud); });
    path_sub_ = handle_.subscribe<nav_msgs::Path>("path", 1000,
                                                  [this](const nav_msgs::PathConstPtr& message) {
                                                    path = *message;
                                                    ++paths;
                                                  });
    statistics_sub_ = handle_.subscribe<PoseResamplerStatistics>(
        "pose_statistics", 1000,
        [this](const PoseResamplerStatisticsConstPtr& message) { statistics = *message; });
  }

  /// Waits until every connection of what it reads stands.
  bool hears() {
    return waitFor([this] {
      return poses_sub_.getNumPublishers() > 0 && clouds_sub_.getNumPublishers() > 0 &&
             path_sub_.getNumPublishers() > 0 && statistics_sub_.getNumPublishers() > 0;
    });
  }
  /// The same in both directions.
  bool connected() {
    return hears() && waitFor([this] {
             return points_.getNumSubscribers() > 0 && odometry_.getNumSubscribers() > 0 &&
                    tf_.getNumSubscribers() > 0 && tf_static_.getNumSubscribers() > 0;
           });
  }
  /// Waits until the node and its connections are gone.
  bool disconnected() {
    return waitFor([this] {
      return points_.getNumSubscribers() == 0 && tf_.getNumSubscribers() <= tf_others_ &&
             poses_sub_.getNumPublishers() == 0;
    });
  }

  void sendMount() {
    tf2_msgs::TFMessage message;
    message.transforms = {
        transformMessage(ros::Time(1), kVehicleFrame, kSensorFrame, sensorMount())};
    tf_static_.publish(message);
  }
  void send(const std::vector<geometry_msgs::TransformStamped>& transforms) {
    tf2_msgs::TFMessage message;
    message.transforms = transforms;
    tf_.publish(message);
  }
  void send(const sensor_msgs::PointCloud2& scan) { points_.publish(scan); }
  /// Odometry whose variance of x is `variance`.
  void sendOdometry(const ros::Time& stamp, double variance, const std::string& frame = kMapFrame,
                    const std::string& vehicle_frame = kVehicleFrame) {
    nav_msgs::Odometry odometry;
    odometry.header.stamp = stamp;
    odometry.header.frame_id = frame;
    odometry.child_frame_id = vehicle_frame;
    odometry.pose.covariance[0] = variance;
    odometry.pose.covariance[35] = 0.5 * variance;
    odometry_.publish(odometry);
  }

  bool waitForStatistics(const std::function<bool(const PoseResamplerStatistics&)>& condition,
                         double timeout_s = kPatience_s) {
    return waitFor([&] { return condition(statistics); }, timeout_s);
  }
  /// Scans the node has done with, in whatever way.
  uint64_t scansDone() const { return statistics.scans + sumOf(statistics.scans_dropped); }
  /// Sends a scan and waits until the node has done with it and nothing waits.
  bool process(const sensor_msgs::PointCloud2& scan) {
    const uint64_t done = scansDone();
    send(scan);
    return waitFor([&] { return scansDone() > done && statistics.poses_waiting == 0; });
  }
  /// Sends a scan and waits for its pose; nullptr if it makes none.
  PoseCloudConstPtr keep(const sensor_msgs::PointCloud2& scan, double timeout_s = kPatience_s) {
    const std::size_t before = poses.size();
    send(scan);
    waitFor([&] { return poses.size() > before; }, timeout_s);
    const bool came = poses.size() > before && poses.back()->header.stamp == scan.header.stamp;
    return came ? poses.back() : nullptr;
  }

  bool addPose() { return trigger("/add_pose"); }
  bool reset() { return trigger("/reset"); }

  std::vector<PoseCloudConstPtr> poses;
  std::vector<sensor_msgs::PointCloud2ConstPtr> clouds;
  nav_msgs::Path path;                 ///< the last
  int paths = 0;                       ///< how many came
  PoseResamplerStatistics statistics;  ///< the last

 private:
  bool trigger(const std::string& service) {
    std_srvs::Trigger trigger;
    return callService(node_name_ + service, &trigger) && trigger.response.success;
  }

  std::string node_name_;
  ros::NodeHandle handle_;
  ros::Publisher points_;
  ros::Publisher odometry_;
  ros::Publisher tf_;
  ros::Publisher tf_static_;
  uint32_t tf_others_ = 0;
  ros::Subscriber poses_sub_;
  ros::Subscriber clouds_sub_;
  ros::Subscriber path_sub_;
  ros::Subscriber statistics_sub_;
};

using LoadedPoses = LoadedNodelet<PoseClient>;

/// Every scan, point and pose is accounted for, and no pose waits any more.
inline void expectAccounted(const PoseResamplerStatistics& s) {
  EXPECT_EQ(s.points_in, s.points_kept + sumOf(s.points_dropped));
  EXPECT_EQ(s.poses, s.poses_published + sumOf(s.poses_dropped));
  EXPECT_EQ(s.poses_waiting, 0U);
  EXPECT_EQ(s.backlog_s, 0.0F);
}

}  // namespace ladar_perception::test
