// SPDX-License-Identifier: BSD-3-Clause
// The pose re-sampler: the shell around PoseCollector and CloudResampler that the nodelet and the
// program share.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "ladar_perception/util/work_queue.h"
#include "odometry_log.h"
#include "pose_collector.h"
#include "pose_statistics.h"
#include "warning_gate.h"

namespace ladar_perception {

/// Subscribes to `points` and `odom`, publishes `pose_cloud`, `resampled_points`, `path`,
/// `pose_statistics` and diagnostics, offers `~add_pose` and `~reset`.
///
/// Scans wait in a short queue, whose oldest is dropped and counted when it is full, for the thread
/// that waits for tf and gathers clouds. Complete poses wait in another for the thread that
/// re-samples. When that one is full, the first thread waits: a pose that joined is never dropped
/// for want of time; later poses are farther apart instead, and the scans between them counted.
class PoseResamplerNode {
 public:
  /// Throws std::runtime_error with a readable report if the parameters are unfit.
  PoseResamplerNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~PoseResamplerNode();
  PoseResamplerNode(const PoseResamplerNode&) = delete;
  PoseResamplerNode& operator=(const PoseResamplerNode&) = delete;

 private:
  struct Arrival {
    sensor_msgs::PointCloud2ConstPtr scan;
    ros::WallTime time;
  };

  void advertise();
  void onScan(const sensor_msgs::PointCloud2ConstPtr& scan);
  bool onAddPose(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void onTimer(const ros::WallTimerEvent& event);

  // On the thread that gathers.
  void gather();
  void heedRequests();
  void collect(const Arrival& arrival);
  void completeAfterPause(const ros::WallTime& last_arrival);
  void passOn(std::optional<CollectedPose> pose, const ros::WallTime& arrival);
  void startPath(uint64_t journey);
  void reportScanDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason,
                      const std::string& detail);

  // On the thread that re-samples.
  void resample();
  void resamplePose(const CollectedPose& pose);
  void publish(const CollectedPose& pose, const ResampledCloud& samples);
  void extendPath(const CollectedPose& pose);
  void reportPoseDrop(const CollectedPose& pose, PoseDrop reason, const std::string& detail);

  PoseResamplerStatistics statisticsMessage();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  PoseResamplerNodeConfig config_;
  Policies policies_;
  tf2_ros::Buffer tf_buffer_;
  tf2_ros::TransformListener tf_listener_;
  OdometryLog odometry_;
  PoseCollector collector_;  // of the thread that gathers, as is the next
  WarningGate<1> backlog_warnings_;
  CloudResampler resampler_;  // of the thread that re-samples
  std::atomic<bool> add_pose_requested_{false};
  std::atomic<bool> reset_requested_{false};

  std::mutex statistics_mutex_;  // guards the six below
  PoseStatisticsLog statistics_;
  WarningGate<kScanDrops> scan_warnings_;
  WarningGate<kPoseDrops> pose_warnings_;
  uint64_t diagnosed_scans_ = 0;
  uint64_t diagnosed_scan_drops_ = 0;
  uint64_t diagnosed_pose_drops_ = 0;

  std::mutex path_mutex_;  // guards the two below
  nav_msgs::Path path_;
  uint64_t path_journey_ = 0;

  WorkQueue<Arrival> scans_;
  WorkQueue<CollectedPose> poses_;

  ros::Publisher pose_publisher_;
  ros::Publisher points_publisher_;
  ros::Publisher path_publisher_;
  ros::Publisher statistics_publisher_;
  ros::ServiceServer add_pose_service_;
  ros::ServiceServer reset_service_;
  diagnostic_updater::Updater diagnostics_;
  ros::WallTimer timer_;
  std::thread gatherer_;
  std::thread resampling_;
  ros::Subscriber odometry_subscriber_;
  ros::Subscriber subscriber_;  // last: callbacks may come before the constructor returns
};

}  // namespace ladar_perception
