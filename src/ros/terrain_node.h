// SPDX-License-Identifier: BSD-3-Clause
// The terrain node: the shell around TerrainProcessor that the nodelet and the program share.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <memory>
#include <mutex>
#include <thread>

#include "ladar_perception/util/work_queue.h"
#include "terrain_processor.h"
#include "terrain_statistics.h"

namespace ladar_perception {

/// Subscribes to `points`, publishes `labeled_points`, `labeled_map`, `statistics` and diagnostics,
/// offers `~reset`. Scans wait in a short queue for a worker thread, so that no thread of a nodelet
/// manager ever waits for tf.
class TerrainNode {
 public:
  /// Throws std::runtime_error with a readable report if the parameters or the model are unfit.
  TerrainNode(const ros::NodeHandle& handle, const ros::NodeHandle& private_handle);
  ~TerrainNode();
  TerrainNode(const TerrainNode&) = delete;
  TerrainNode& operator=(const TerrainNode&) = delete;

 private:
  struct Arrival {
    sensor_msgs::PointCloud2ConstPtr scan;
    ros::WallTime time;
  };

  void onScan(const sensor_msgs::PointCloud2ConstPtr& scan);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void onTimer(const ros::WallTimerEvent& event);
  void work();
  void processArrival(const Arrival& arrival);
  void reportDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason, const std::string& detail);
  void publishScan(const sensor_msgs::PointCloud2& scan);
  void publishMap(const sensor_msgs::PointCloud2& scan, const Eigen::Vector3d& p_map_vehicle);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_;
  TerrainNodeConfig config_;
  ClassifierModel model_;
  tf2_ros::Buffer tf_buffer_;
  tf2_ros::TransformListener tf_listener_;

  std::mutex processor_mutex_;  // guards processor_ and last_map_stamp_
  TerrainProcessor processor_;
  ros::Time last_map_stamp_;

  std::mutex statistics_mutex_;  // guards the four below
  TerrainStatisticsLog statistics_;
  uint64_t diagnosed_scans_ = 0;
  uint64_t diagnosed_drops_ = 0;

  WorkQueue<Arrival> queue_;

  ros::Publisher points_publisher_;
  ros::Publisher map_publisher_;
  ros::Publisher statistics_publisher_;
  ros::ServiceServer reset_service_;
  diagnostic_updater::Updater diagnostics_;
  ros::WallTimer timer_;
  std::thread worker_;
  ros::Subscriber subscriber_;  // last: callbacks may come before the constructor returns
};

}  // namespace ladar_perception
