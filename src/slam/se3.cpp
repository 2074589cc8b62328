// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/se3.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace ladar_perception {
namespace {

// Below, the series is more accurate than the closed forms.
constexpr double kSmallAngle = 1e-4;

}  // namespace

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

Eigen::Quaterniond expRotation(const Eigen::Vector3d& rotation_rad) {
  const double angle = rotation_rad.norm();
  // sin(angle / 2) / angle
  const double scale =
      angle < kSmallAngle ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = scale * rotation_rad;
  return q.normalized();
}

Eigen::Vector3d logRotation(const Eigen::Quaterniond& q) {
  // q and -q are one rotation; the one with w >= 0 turns by at most pi.
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double sine = q.vec().norm();
  const double w = sign * q.w();
  if (sine < kSmallAngle) return sign * (2.0 / w) * (1.0 - sine * sine / (3.0 * w * w)) * q.vec();
  return sign * (2.0 * std::atan2(sine, w) / sine) * q.vec();
}

Eigen::Matrix3d inverseRightJacobian(const Eigen::Vector3d& rotation_rad) {
  const double angle = rotation_rad.norm();
  const Eigen::Matrix3d cross = crossMatrix(rotation_rad);
  // (1 - angle / 2 * cot(angle / 2)) / angle^2
  const double second = angle < kSmallAngle
                            ? 1.0 / 12.0
                            : (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
  return Eigen::Matrix3d::Identity() + 0.5 * cross + second * cross * cross;
}

Eigen::Isometry3d plus(const Eigen::Isometry3d& T, const Vector6d& d) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond q(T.linear());
  result.linear() = (q * expRotation(d.tail<3>())).normalized().toRotationMatrix();
  result.translation() = T.translation() + T.linear() * d.head<3>();
  return result;
}

Vector6d minus(const Eigen::Isometry3d& T_to, const Eigen::Isometry3d& T_from) {
  const Eigen::Matrix3d R = T_from.linear().transpose() * T_to.linear();
  Vector6d d;
  d << T_from.linear().transpose() * (T_to.translation() - T_from.translation()),
      logRotation(Eigen::Quaterniond(R));
  return d;
}

Matrix6d transportMatrix(const Eigen::Isometry3d& T_a_b) {
  const Eigen::Matrix3d R_b_a = T_a_b.linear().transpose();
  Matrix6d F = Matrix6d::Zero();
  F.topLeftCorner<3, 3>() = R_b_a;
  F.topRightCorner<3, 3>() = -R_b_a * crossMatrix(T_a_b.translation());
  F.bottomRightCorner<3, 3>() = R_b_a;
  return F;
}

Matrix6d invertedCovariance(const Eigen::Isometry3d& T_a_b, const Matrix6d& covariance) {
  const Matrix6d F = transportMatrix(T_a_b.inverse(Eigen::Isometry));
  return F * covariance * F.transpose();
}

Matrix6d composedCovariance(const Matrix6d& covariance_a_b, const Eigen::Isometry3d& T_b_c,
                            const Matrix6d& covariance_b_c) {
  const Matrix6d F = transportMatrix(T_b_c);
  return F * covariance_a_b * F.transpose() + covariance_b_c;
}

Matrix6d diagonalCovariance(double sigma_m, double sigma_rad) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(sigma_m * sigma_m),
      Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return diagonal.asDiagonal();
}

double positionSigma(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance.topLeftCorner<3, 3>(),
                                                              Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(solver.eigenvalues()(2), 0.0));
}

Matrix6d invertSymmetric(const Matrix6d& matrix, double least) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(0.5 * (matrix + matrix.transpose()));
  const Vector6d inverses = solver.eigenvalues().cwiseMax(least).cwiseInverse();
  return solver.eigenvectors() * inverses.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace ladar_perception
