// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <tf2_ros/transform_broadcaster.h>

#include <Eigen/Geometry>
#include <mutex>
#include <string>

namespace ladar_perception {

/// Publishes where the odometry's frame is in the map. Thread-safe.
class MapFrameBroadcaster {
 public:
  /// Stamps lie `ahead_s` in the future, until when the transform is meant to hold: nobody who
  /// looks something up waits for the next one.
  MapFrameBroadcaster(std::string map_frame, std::string odom_frame, double ahead_s);

  /// Changes the transform and publishes it.
  void set(const Eigen::Isometry3d& T_map_odom);
  /// Publishes it once more.
  void repeat();

 private:
  void send();

  const std::string map_frame_;
  const std::string odom_frame_;
  const ros::Duration ahead_;
  std::mutex mutex_;  // guards the three below
  Eigen::Isometry3d T_map_odom_ = Eigen::Isometry3d::Identity();
  ros::Time last_stamp_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace ladar_perception
