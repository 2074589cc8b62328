// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/register/twist.h"

#include <Eigen/SVD>
#include <cmath>

namespace ladar_perception {
namespace {

constexpr double kSmall_rad = 1e-4;

/// The matrix V of exp(rotation, translation) = (R, V translation).
Eigen::Matrix3d leftJacobian(const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  const Eigen::Matrix3d k = skew(rotation);
  // By series near zero, where the closed form divides two vanishing numbers.
  const double a =
      angle < kSmall_rad ? 0.5 - angle * angle / 24.0 : (1.0 - std::cos(angle)) / (angle * angle);
  const double b = angle < kSmall_rad ? 1.0 / 6.0 - angle * angle / 120.0
                                      : (angle - std::sin(angle)) / (angle * angle * angle);
  return Eigen::Matrix3d::Identity() + a * k + b * k * k;
}

}  // namespace

Eigen::Isometry3d expTwist(const Eigen::Matrix<double, 6, 1>& twist) {
  const Eigen::Vector3d rotation = twist.head<3>();
  const double angle = rotation.norm();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (angle > 0.0) {
    motion.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  }
  motion.translation() = leftJacobian(rotation) * twist.tail<3>();
  return motion;
}

Eigen::Matrix<double, 6, 1> logTwist(const Eigen::Isometry3d& motion) {
  const Eigen::AngleAxisd turn(motion.linear());
  Eigen::Matrix<double, 6, 1> twist;
  twist.head<3>() = turn.angle() * turn.axis();
  twist.tail<3>() = leftJacobian(twist.head<3>()).partialPivLu().solve(motion.translation()).eval();
  return twist;
}

Eigen::Matrix<double, 6, 6> adjoint(const Eigen::Isometry3d& T) {
  Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
  m.topLeftCorner<3, 3>() = T.linear();
  m.bottomRightCorner<3, 3>() = T.linear();
  m.bottomLeftCorner<3, 3>() = skew(T.translation()) * T.linear();
  return m;
}

Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d u = svd.matrixU();
  const Eigen::Matrix3d v = svd.matrixV();
  Eigen::Vector3d signs(1.0, 1.0, (u * v.transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  return u * signs.asDiagonal() * v.transpose();
}

}  // namespace ladar_perception
