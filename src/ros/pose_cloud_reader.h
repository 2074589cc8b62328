// SPDX-License-Identifier: BSD-3-Clause
// From the pose re-sampler's message to a pose of the delayed state. slam_bag takes this way, too,
// so that both have the same bits.
#pragma once

#include <geometry_msgs/Pose.h>
#include <ladar_perception/PoseCloud.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "ladar_perception/slam/delayed_state.h"
#include "state_drop.h"

namespace ladar_perception {

/// Nothing if a coordinate is not finite or the orientation is no unit quaternion.
std::optional<Eigen::Isometry3d> isometryOf(const geometry_msgs::Pose& pose);

/// Reads stamp, pose, samples and, where there are such fields, camera's colours and labels. Says
/// why if the message cannot be used: `detail` then names the field and what is wrong with it. The
/// message's covariance is not used: it is that of the pose, not of the step from the one before.
std::optional<StateDrop> readPoseCloud(const PoseCloud& message, StatePose* pose,
                                       std::string* detail);

}  // namespace ladar_perception
