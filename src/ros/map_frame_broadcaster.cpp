// SPDX-License-Identifier: BSD-3-Clause
#include "map_frame_broadcaster.h"

#include <utility>

#include "pose_cloud_message.h"

namespace ladar_perception {
namespace {

// A clock that goes back by more was set back: tf's buffers are empty again.
const ros::Duration kSetBack(1.0);
const ros::Duration kTick(0, 1000);

}  // namespace

MapFrameBroadcaster::MapFrameBroadcaster(std::string map_frame, std::string odom_frame,
                                         double ahead_s)
    : map_frame_(std::move(map_frame)), odom_frame_(std::move(odom_frame)), ahead_(ahead_s) {}

void MapFrameBroadcaster::set(const Eigen::Isometry3d& T_map_odom) {
  const std::lock_guard<std::mutex> lock(mutex_);
  T_map_odom_ = T_map_odom;
  send();
}

void MapFrameBroadcaster::repeat() {
  const std::lock_guard<std::mutex> lock(mutex_);
  send();
}

void MapFrameBroadcaster::send() {
  const ros::Time now = ros::Time::now();
  if (now.isZero()) return;  // simulated time has not begun
  ros::Time stamp = now + ahead_;
  const bool set_back = stamp + kSetBack < last_stamp_;
  // The clock stands, as at the end of a bag: tf takes no second transform of the same stamp, but
  // the estimate may still change, and listeners may come.
  if (stamp <= last_stamp_ && !set_back) stamp = last_stamp_ + kTick;
  last_stamp_ = stamp;
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = map_frame_;
  message.child_frame_id = odom_frame_;
  message.transform = transformMessage(T_map_odom_);
  broadcaster_.sendTransform(message);
}

}  // namespace ladar_perception
