// SPDX-License-Identifier: BSD-3-Clause
// What the delayed-state node publishes of its estimate.
#pragma once

#include <ladar_perception/StateGraph.h>
#include <nav_msgs/Path.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "ladar_perception/slam/delayed_state.h"

namespace ladar_perception {

/// The estimate as it was at some time; clouds are shared, not copied.
struct StateSnapshot {
  std::vector<StatePose> poses;
  PoseGraph graph;
  std_msgs::Header header;  ///< stamp of the newest pose (now if there is none); the map's frame
  std::string odom_frame;
  std::string vehicle_frame;
};

nav_msgs::PathPtr makePath(const StateSnapshot& state);

/// With exact marginal covariances, which take time in proportion to the poses.
StateGraphPtr makeStateGraph(const StateSnapshot& state);

/// Poses as balls, constraints as lines: odometry grey, registrations green, those that span at
/// least `loop_hops` poses yellow, retired ones red.
visualization_msgs::MarkerArrayPtr makeGraphMarkers(const StateSnapshot& state, int loop_hops);

/// As makeMapCloud().
sensor_msgs::PointCloud2Ptr makeMapCloudMessage(const StateSnapshot& state,
                                                std::size_t samples_per_pose);

}  // namespace ladar_perception
