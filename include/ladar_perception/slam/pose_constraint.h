// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "ladar_perception/slam/se3.h"

namespace ladar_perception {

enum class ConstraintKind : uint8_t { kOdometry = 0, kRegistration = 1 };

/// "odometry" or "registration".
const char* constraintKindName(ConstraintKind kind);

/// A measured relative pose of two poses.
struct PoseConstraint {
  int from = 0;
  int to = 0;
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
  /// Inverse covariance of `T_from_to`; may be singular where nothing was measured.
  Matrix6d information = Matrix6d::Identity();
  ConstraintKind kind = ConstraintKind::kOdometry;
  /// False if the graph found that it contradicts all others; then it has no effect.
  bool enabled = true;
};

/// What is wrong with a constraint by itself, "" if nothing is: equal ends, a transform that is not
/// finite or no rotation, an information that is not finite, symmetric and positive semi-definite.
std::string constraintError(const PoseConstraint& constraint);

/// How far the relative pose of two poses is from the measured one, as a perturbation in the frame
/// of `to`, with its derivatives by the perturbations of both poses.
struct ConstraintResidual {
  Vector6d error = Vector6d::Zero();
  Matrix6d by_from = Matrix6d::Zero();
  Matrix6d by_to = Matrix6d::Zero();
};
ConstraintResidual constraintResidual(const PoseConstraint& constraint,
                                      const Eigen::Isometry3d& T_map_from,
                                      const Eigen::Isometry3d& T_map_to);

/// Squared Mahalanobis distance error^T information error.
double constraintChi2(const PoseConstraint& constraint, const Eigen::Isometry3d& T_map_from,
                      const Eigen::Isometry3d& T_map_to);

/// Squared Mahalanobis distance of a measured relative pose from the estimated one under both
/// covariances: distributed as chi^2 with 6 degrees of freedom if both are right.
double innovationChi2(const Eigen::Isometry3d& T_measured, const Matrix6d& measured_covariance,
                      const Eigen::Isometry3d& T_estimated, const Matrix6d& estimated_covariance);

}  // namespace ladar_perception
