// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace ladar_perception::sim {

/// What odometry makes of the true poses: a wheel that measures too far and a gyroscope that drifts
/// to the left, both in proportion to the distance driven.
class DriftingOdometry {
 public:
  DriftingOdometry(double scale_error_percent, double heading_drift_deg_per_100_m)
      : scale_(1.0 + scale_error_percent / 100.0),
        drift_rad_per_m_(heading_drift_deg_per_100_m * EIGEN_PI / 180.0 / 100.0) {}

  /// The pose that odometry has at the next true pose. The first is the true one.
  Eigen::Isometry3d next(const Eigen::Isometry3d& T_truth_base) {
    if (is_first_) {
      T_odom_base_ = T_truth_base;
    } else {
      Eigen::Isometry3d step = T_truth_last_.inverse(Eigen::Isometry) * T_truth_base;
      const double distance_m = step.translation().norm();
      step.translation() *= scale_;
      T_odom_base_ = T_odom_base_ * step *
                     Eigen::AngleAxisd(drift_rad_per_m_ * distance_m, Eigen::Vector3d::UnitZ());
    }
    is_first_ = false;
    T_truth_last_ = T_truth_base;
    return T_odom_base_;
  }

 private:
  double scale_;
  double drift_rad_per_m_;
  bool is_first_ = true;
  Eigen::Isometry3d T_truth_last_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_odom_base_ = Eigen::Isometry3d::Identity();
};

}  // namespace ladar_perception::sim
