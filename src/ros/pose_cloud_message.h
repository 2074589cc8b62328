// SPDX-License-Identifier: BSD-3-Clause
// Messages of a re-sampled pose.
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <ladar_perception/PoseCloud.h>
#include <sensor_msgs/PointCloud2.h>

#include <string>

#include "ladar_perception/resample/cloud_resampler.h"
#include "odometry_log.h"
#include "pose_collector.h"

namespace ladar_perception {

geometry_msgs::Pose poseMessage(const Eigen::Isometry3d& T_parent_child);
geometry_msgs::Transform transformMessage(const Eigen::Isometry3d& T_parent_child);

/// The samples in the pose's vehicle frame, with all fields of their nearest originals.
sensor_msgs::PointCloud2 makeSampleCloud(const CollectedPose& pose, const ResampledCloud& samples);

/// The pose in `odom_frame` with its samples.
PoseCloudPtr makePoseCloud(const CollectedPose& pose, const std::string& odom_frame,
                           const OdometryLog::Covariance& covariance,
                           const sensor_msgs::PointCloud2& cloud);

}  // namespace ladar_perception
