// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PoseWithCovariance.h>
#include <nav_msgs/Odometry.h>

#include <map>
#include <mutex>
#include <string>

namespace ladar_perception {

/// The last covariances of a vehicle's pose. Thread-safe.
class OdometryLog {
 public:
  using Covariance = geometry_msgs::PoseWithCovariance::_covariance_type;

  /// Of the pose of `vehicle_frame` in `odom_frame`, and no other; an empty frame is none.
  OdometryLog(std::string odom_frame, std::string vehicle_frame, double tolerance_s);

  void add(const nav_msgs::Odometry& odometry);
  /// That of the message nearest in time, zeros if none is within the tolerance.
  Covariance covarianceAt(const ros::Time& stamp) const;
  uint64_t taken() const;
  /// Messages about other frames.
  uint64_t ignored() const;

 private:
  const std::string odom_frame_;
  const std::string vehicle_frame_;
  const ros::Duration tolerance_;
  mutable std::mutex mutex_;  // guards the three below
  std::map<ros::Time, Covariance> covariances_;
  uint64_t taken_ = 0;
  uint64_t ignored_ = 0;
};

}  // namespace ladar_perception
