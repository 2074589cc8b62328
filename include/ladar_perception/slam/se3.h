// SPDX-License-Identifier: BSD-3-Clause
// Poses, their perturbations and what becomes of covariances on the way from pose to pose.
//
// A pose T = (R, t) is perturbed by d = (dt, dr), metres then radians, in its own frame:
//   plus(T, d) = (R Exp(dr), t + R dt)
// Every 6x6 covariance of this room is of such a d, in the order x y z, roll pitch yaw of
// geometry_msgs/PoseWithCovariance.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ladar_perception {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The matrix of the cross product: crossMatrix(a) b = a x b.
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& a);
/// Rotation about `rotation_rad`'s direction by its length.
Eigen::Quaterniond expRotation(const Eigen::Vector3d& rotation_rad);
/// Its inverse; the length is at most pi.
Eigen::Vector3d logRotation(const Eigen::Quaterniond& q);
/// d log(R Exp(d)) / d d at d = 0, for log R = `rotation_rad`: the inverse right Jacobian.
Eigen::Matrix3d inverseRightJacobian(const Eigen::Vector3d& rotation_rad);

/// The perturbed pose.
Eigen::Isometry3d plus(const Eigen::Isometry3d& T, const Vector6d& d);
/// The d for which plus(T_from, d) = T_to.
Vector6d minus(const Eigen::Isometry3d& T_to, const Eigen::Isometry3d& T_from);

/// How a perturbation of pose a moves a pose b that is rigidly fixed to it: d_b = F d_a.
Matrix6d transportMatrix(const Eigen::Isometry3d& T_a_b);
/// Covariance of T_b_a from that of T_a_b.
Matrix6d invertedCovariance(const Eigen::Isometry3d& T_a_b, const Matrix6d& covariance);
/// Covariance of T_a_c = T_a_b T_b_c from those of its independent factors.
Matrix6d composedCovariance(const Matrix6d& covariance_a_b, const Eigen::Isometry3d& T_b_c,
                            const Matrix6d& covariance_b_c);

/// The same standard deviation for three coordinates and for three angles.
Matrix6d diagonalCovariance(double sigma_m, double sigma_rad);
/// Standard deviation of the position in its most uncertain direction, m.
double positionSigma(const Matrix6d& covariance);
/// Inverse of a covariance or information. Eigenvalues below `least` count as `least`, so that what
/// is not known at all becomes very uncertain, not an error.
Matrix6d invertSymmetric(const Matrix6d& matrix, double least = 1e-9);

}  // namespace ladar_perception
