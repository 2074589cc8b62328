// SPDX-License-Identifier: BSD-3-Clause
#include "pose_problem.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace ladar_perception {
namespace {

using PlusMatrix = Eigen::Matrix<double, 7, 6, Eigen::RowMajor>;
using MinusMatrix = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;

/// d (q * Exp(d)) / d d at 0 is half of this; rows are x y z w.
Eigen::Matrix<double, 4, 3> quaternionRates(const double* q) {
  Eigen::Matrix<double, 4, 3> rates;
  rates << q[3], -q[2], q[1],  //
      q[2], q[3], -q[0],       //
      -q[1], q[0], q[3],       //
      -q[0], -q[1], -q[2];
  return rates;
}

Eigen::Matrix3d rotationOf(const double* block) {
  return Eigen::Map<const Eigen::Quaterniond>(block + 3).toRotationMatrix();
}

MinusMatrix minusJacobian(const double* x) {
  MinusMatrix J = MinusMatrix::Zero();
  J.topLeftCorner<3, 3>() = rotationOf(x).transpose();
  J.bottomRightCorner<3, 4>() = 2.0 * quaternionRates(x + 3).transpose();
  return J;
}

}  // namespace

PoseBlock toBlock(const Eigen::Isometry3d& T) {
  PoseBlock block;
  Eigen::Map<Eigen::Vector3d> position(block.data());
  Eigen::Map<Eigen::Quaterniond> orientation(block.data() + 3);
  position = T.translation();
  orientation = Eigen::Quaterniond(T.linear()).normalized();
  return block;
}

Eigen::Isometry3d fromBlock(const double* block) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Map<const Eigen::Quaterniond>(block + 3).normalized().toRotationMatrix();
  T.translation() = Eigen::Map<const Eigen::Vector3d>(block);
  return T;
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Eigen::Map<const Vector6d> d(delta);
  Eigen::Map<Eigen::Vector3d> position(x_plus_delta);
  Eigen::Map<Eigen::Quaterniond> orientation(x_plus_delta + 3);
  position = Eigen::Map<const Eigen::Vector3d>(x) + rotationOf(x) * d.head<3>();
  orientation =
      (Eigen::Map<const Eigen::Quaterniond>(x + 3) * expRotation(d.tail<3>())).normalized();
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<PlusMatrix> J(jacobian);
  J.setZero();
  J.topLeftCorner<3, 3>() = rotationOf(x);
  J.bottomRightCorner<4, 3>() = 0.5 * quaternionRates(x + 3);
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Vector6d> d(y_minus_x);
  d.head<3>() = rotationOf(x).transpose() *
                (Eigen::Map<const Eigen::Vector3d>(y) - Eigen::Map<const Eigen::Vector3d>(x));
  d.tail<3>() = logRotation(Eigen::Map<const Eigen::Quaterniond>(x + 3).conjugate() *
                            Eigen::Map<const Eigen::Quaterniond>(y + 3));
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<MinusMatrix> J(jacobian);
  J = minusJacobian(x);
  return true;
}

ConstraintCost::ConstraintCost(const PoseConstraint& constraint) : constraint_(constraint) {
  const Eigen::LLT<Matrix6d> cholesky(constraint.information);
  if (cholesky.info() == Eigen::Success) {
    root_ = cholesky.matrixU();
    return;
  }
  // Singular: by eigenvalues, which take ten times as long.
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(constraint.information);
  root_ = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
          solver.eigenvectors().transpose();
}

bool ConstraintCost::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  const ConstraintResidual residual =
      constraintResidual(constraint_, fromBlock(parameters[0]), fromBlock(parameters[1]));
  Eigen::Map<Vector6d> whitened(residuals);
  whitened = root_ * residual.error;
  if (jacobians == nullptr) return true;
  // Ceres multiplies by the manifold's PlusJacobian, of which MinusJacobian is the left inverse.
  for (int i = 0; i < 2; ++i) {
    if (jacobians[i] == nullptr) continue;
    Eigen::Map<MinusMatrix> J(jacobians[i]);
    J = root_ * (i == 0 ? residual.by_from : residual.by_to) * minusJacobian(parameters[i]);
  }
  return true;
}

}  // namespace ladar_perception
