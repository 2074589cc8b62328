// SPDX-License-Identifier: BSD-3-Clause
// Configuration of the delayed-state nodelet and of slam_bag.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/params/param_table.h"
#include "ladar_perception/register/registration_config.h"
#include "ladar_perception/slam/delayed_state_config.h"
#include "param_reader.h"

namespace ladar_perception {

struct DelayedStateNodeConfig {
  DelayedStateConfig state;
  RegistrationConfig registration;
  std::string map_frame = "map";
  std::string odom_frame = "odom";
  std::string time_jump = "new_state";
  int queue_size = 500;
  bool publish_tf = true;
  double tf_rate_hz = 20.0;
  double graph_rate_hz = 1.0;
  double map_rate_hz = 0.2;
  int map_samples_per_pose = 1000;
  double statistics_rate_hz = 1.0;

  /// Poses start where odometry puts them: little overlap is then the way that was driven, and
  /// restarts find nothing better.
  DelayedStateNodeConfig() { registration.good_overlap = 0.0; }

  /// The table that feeds the strict readers, config/delayed_state.yaml and the documentation.
  ParamTable table();
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;
};

}  // namespace ladar_perception
