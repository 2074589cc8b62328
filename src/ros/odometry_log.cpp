// SPDX-License-Identifier: BSD-3-Clause
#include "odometry_log.h"

#include <iterator>
#include <utility>

namespace ladar_perception {
namespace {

// Poses are completed long after their stamp where clouds are gathered; 80 s at 50 Hz.
constexpr std::size_t kKept = 4000;

}  // namespace

OdometryLog::OdometryLog(std::string odom_frame, std::string vehicle_frame, double tolerance_s)
    : odom_frame_(std::move(odom_frame)),
      vehicle_frame_(std::move(vehicle_frame)),
      tolerance_(tolerance_s) {}

void OdometryLog::add(const nav_msgs::Odometry& odometry) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool fits = !vehicle_frame_.empty() && odometry.child_frame_id == vehicle_frame_ &&
                    odometry.header.frame_id == odom_frame_;
  ++(fits ? taken_ : ignored_);
  if (!fits) return;
  const ros::Time& stamp = odometry.header.stamp;
  // Time that jumped back: what was is no longer.
  if (!covariances_.empty() && stamp < covariances_.rbegin()->first) covariances_.clear();
  covariances_[stamp] = odometry.pose.covariance;
  if (covariances_.size() > kKept) covariances_.erase(covariances_.begin());
}

OdometryLog::Covariance OdometryLog::covarianceAt(const ros::Time& stamp) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  Covariance nearest;
  nearest.fill(0.0);
  const auto after = covariances_.lower_bound(stamp);
  ros::Duration least = tolerance_;
  if (after != covariances_.end() && after->first - stamp <= least) {
    least = after->first - stamp;
    nearest = after->second;
  }
  if (after != covariances_.begin()) {
    const auto before = std::prev(after);
    if (stamp - before->first <= least) nearest = before->second;
  }
  return nearest;
}

uint64_t OdometryLog::taken() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return taken_;
}

uint64_t OdometryLog::ignored() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return ignored_;
}

}  // namespace ladar_perception
