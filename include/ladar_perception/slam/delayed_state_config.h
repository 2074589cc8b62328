// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/params/param_table.h"
#include "ladar_perception/slam/se3.h"

namespace ladar_perception {

/// Configuration of a DelayedState.
struct DelayedStateConfig {
  double drift_m_per_100_m = 0.6;
  double drift_deg_per_100_m = 0.6;
  double odometry_floor_m = 0.01;
  double odometry_floor_deg = 0.1;
  double registration_floor_m = 0.02;
  double registration_floor_deg = 0.1;
  double overlap_distance_m = 15.0;
  double search_sigmas = 2.0;
  int max_candidates = 3;
  double accept_overlap = 0.3;
  double gate_chi2 = 22.46;
  double confirm_sigma_m = 0.5;
  int confirm_poses = 20;
  double robust_width = 3.0;
  int window_poses = 40;
  int loop_hops = 15;
  double full_update_m = 0.2;
  int threads = 1;

  /// Names, ranges, units and meanings of the fields above.
  void addTo(ParamTable* table);
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;
  /// Of an odometry step: variances grow with the distance, so that the drift after 100 m has the
  /// standard deviations above.
  Matrix6d odometryCovariance(const Eigen::Isometry3d& T_step) const;
  /// Added to what a registration says of itself: it does not know of moving things, of the motion
  /// within a scan, or of samples that fall elsewhere on the same surface.
  Matrix6d registrationFloor() const;
};

}  // namespace ladar_perception
