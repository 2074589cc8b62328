// SPDX-License-Identifier: BSD-3-Clause
// Small motions as twists: rotation vector (rad), then translation (m).
#pragma once

#include <Eigen/Geometry>

namespace ladar_perception {

inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// The rigid motion exp(twist) of SE(3).
Eigen::Isometry3d expTwist(const Eigen::Matrix<double, 6, 1>& twist);
/// The inverse of expTwist, for rotations below a half turn.
Eigen::Matrix<double, 6, 1> logTwist(const Eigen::Isometry3d& motion);
/// T exp(twist) = exp(adjoint(T) twist) T
Eigen::Matrix<double, 6, 6> adjoint(const Eigen::Isometry3d& T);
/// The nearest rotation to a matrix that is nearly one.
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& matrix);

}  // namespace ladar_perception
