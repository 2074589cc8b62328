// SPDX-License-Identifier: BSD-3-Clause
// Configuration of the pose re-sampler's nodelet and node, and the strict readers of it.
#pragma once

#include <ros/node_handle.h>

#include <string>

#include "ladar_perception/params/param_table.h"
#include "ladar_perception/resample/policy.h"
#include "ladar_perception/resample/pose_keeper.h"
#include "ladar_perception/resample/resample_config.h"

namespace ladar_perception {

struct PoseResamplerNodeConfig {
  PoseKeeperConfig keeper;
  ResampleConfig resampler = defaultResampling();
  std::string policies = "range:min=3";
  std::string class_names = "surface scatter linear";
  std::string model;
  std::string odom_frame = "odom";
  std::string vehicle_frame = "base_link";
  bool motion_compensation = true;
  double tf_timeout_s = 0.2;
  double odometry_tolerance_s = 0.1;
  double gather_timeout_s = 5.0;
  int queue_size = 20;
  int pose_queue_size = 8;
  double statistics_rate_hz = 1.0;

  /// The table that feeds the strict readers, config/pose_resampler.yaml and the documentation.
  ParamTable table();

 private:
  static ResampleConfig defaultResampling();
};

/// Configuration from a map of values. Throws std::runtime_error with every violation, one a line,
/// under a first line that names `source` (a file or a namespace).
PoseResamplerNodeConfig readPoseResamplerNodeConfig(const ParamMap& values,
                                                    const std::string& source);
/// From a YAML file; "" gives the defaults.
PoseResamplerNodeConfig readPoseResamplerNodeConfigFile(const std::string& path);
/// From the parameters in the handle's namespace.
PoseResamplerNodeConfig readPoseResamplerNodeConfig(const ros::NodeHandle& private_handle);

/// The policies that `config.policies` specifies, several of them separated by spaces or ';'. Class
/// names are those of `config.model` or else of `config.class_names`. Throws std::runtime_error
/// that names the parameter and what is wrong with it.
Policies loadPolicies(const PoseResamplerNodeConfig& config);

}  // namespace ladar_perception
