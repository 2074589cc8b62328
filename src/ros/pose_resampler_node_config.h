// SPDX-License-Identifier: BSD-3-Clause
// Configuration of the pose re-sampler's nodelet and node.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/params/param_table.h"
#include "ladar_perception/resample/policy.h"
#include "ladar_perception/resample/pose_keeper.h"
#include "ladar_perception/resample/resample_config.h"
#include "param_reader.h"

namespace ladar_perception {

struct PoseResamplerNodeConfig {
  PoseKeeperConfig keeper;
  ResampleConfig resampler = defaultResampling();
  std::string policies = "range:min=12 normal_variation:mode=attract";
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
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;

 private:
  static ResampleConfig defaultResampling();
};

/// The policies that `config.policies` specifies, several of them separated by spaces or ';'. Class
/// names are those of `config.model` or else of `config.class_names`. Throws std::runtime_error
/// that names the parameter and what is wrong with it.
Policies loadPolicies(const PoseResamplerNodeConfig& config);

}  // namespace ladar_perception
