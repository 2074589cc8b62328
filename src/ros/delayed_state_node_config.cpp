// SPDX-License-Identifier: BSD-3-Clause
#include "delayed_state_node_config.h"

namespace ladar_perception {

ParamTable DelayedStateNodeConfig::table() {
  ParamTable table;
  state.addTo(&table);
  registration.addTo(&table);
  table.add("map_frame", &map_frame, "frame of the estimate; the odometry's is corrected in it");
  table.add("odom_frame", &odom_frame, "frame of the poses that come; others are refused");
  table.add("time_jump", &time_jump,
            "what a stamp that jumps back does: new_state begins one, refuse drops the pose");
  table.add("queue_size", &queue_size, 1, 10000, "poses",
            "poses that may wait; the oldest is dropped when one more comes");
  table.add("publish_tf", &publish_tf, "publish map_frame -> odom_frame on tf");
  table.add("tf_rate_hz", &tf_rate_hz, 1.0, 100.0, "Hz", "how often, by the wall");
  table.add("graph_rate_hz", &graph_rate_hz, 0.1, 100.0, "Hz",
            "at most so often path, pose_graph and pose_graph_markers are published, when they "
            "changed");
  table.add("map_rate_hz", &map_rate_hz, 0.0, 10.0, "Hz", "the same of map_cloud; 0 for never");
  table.add("map_samples_per_pose", &map_samples_per_pose, 0, 10000000, "samples",
            "of every pose in map_cloud, farthest first; 0 for all");
  table.add("statistics_rate_hz", &statistics_rate_hz, 0.1, 100.0, "Hz",
            "how often statistics are published");
  return table;
}

std::vector<std::string> DelayedStateNodeConfig::validate() const {
  std::vector<std::string> violations = state.validate();
  append(registration.validate(), &violations);
  checkFrame("map_frame", map_frame, false, &violations);
  checkFrame("odom_frame", odom_frame, false, &violations);
  if (map_frame == odom_frame) {
    violations.push_back("map_frame: '" + map_frame + "' is odom_frame, too");
  }
  if (time_jump != "new_state" && time_jump != "refuse") {
    violations.push_back("time_jump: '" + time_jump + "', expected new_state or refuse");
  }
  return violations;
}

}  // namespace ladar_perception
