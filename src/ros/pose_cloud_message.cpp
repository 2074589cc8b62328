// SPDX-License-Identifier: BSD-3-Clause
#include "pose_cloud_message.h"

#include <boost/make_shared.hpp>
#include <cmath>

#include "cloud_message.h"
#include "ladar_perception/resample/sample_cloud.h"

namespace ladar_perception {
namespace {

ros::Time timeOf(uint64_t stamp_ns) {
  ros::Time time;
  time.fromNSec(stamp_ns);
  return time;
}

geometry_msgs::Point pointMessage(const Eigen::Vector3d& p) {
  geometry_msgs::Point message;
  message.x = p.x();
  message.y = p.y();
  message.z = p.z();
  return message;
}

}  // namespace

geometry_msgs::Pose poseMessage(const Eigen::Isometry3d& T_parent_child) {
  geometry_msgs::Pose message;
  message.position = pointMessage(T_parent_child.translation());
  const Eigen::Quaterniond q(T_parent_child.linear());
  message.orientation.x = q.x();
  message.orientation.y = q.y();
  message.orientation.z = q.z();
  message.orientation.w = q.w();
  return message;
}

geometry_msgs::Transform transformMessage(const Eigen::Isometry3d& T_parent_child) {
  const geometry_msgs::Pose pose = poseMessage(T_parent_child);
  geometry_msgs::Transform message;
  message.translation.x = pose.position.x;
  message.translation.y = pose.position.y;
  message.translation.z = pose.position.z;
  message.rotation = pose.orientation;
  return message;
}

sensor_msgs::PointCloud2 makeSampleCloud(const CollectedPose& pose, const ResampledCloud& samples) {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = timeOf(pose.pose.stamp_ns);
  message.header.frame_id = pose.vehicle_frame;
  CloudLayout layout = sampleLayout(pose.pose.layout);
  writeSampleCloud(pose.pose.view(), samples, &layout, &message.data);
  setLayout(layout, &message);
  message.is_dense = true;
  return message;
}

PoseCloudPtr makePoseCloud(const CollectedPose& pose, const std::string& odom_frame,
                           const OdometryLog::Covariance& covariance,
                           const sensor_msgs::PointCloud2& cloud) {
  auto message = boost::make_shared<PoseCloud>();
  message->header.stamp = timeOf(pose.pose.stamp_ns);
  message->header.frame_id = odom_frame;
  message->id = pose.pose.id;
  message->vehicle_frame = pose.vehicle_frame;
  message->pose.pose = poseMessage(pose.pose.T_map_vehicle);
  message->pose.covariance = covariance;
  message->sensor = pointMessage(pose.pose.points.sensor_m);
  message->scans = pose.pose.scans;
  message->last_scan = timeOf(pose.pose.last_stamp_ns);
  message->points_in = pose.pose.points.positions_m.size();
  message->cloud = cloud;
  return message;
}

}  // namespace ladar_perception
