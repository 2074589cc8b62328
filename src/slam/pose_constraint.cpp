// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/pose_constraint.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace ladar_perception {
namespace {

constexpr double kRotationTolerance = 1e-6;
// Of the largest entry: what rounding leaves of symmetry and of zero eigenvalues.
constexpr double kSymmetryTolerance = 1e-9;

}  // namespace

const char* constraintKindName(ConstraintKind kind) {
  return kind == ConstraintKind::kOdometry ? "odometry" : "registration";
}

std::string constraintError(const PoseConstraint& constraint) {
  if (constraint.from == constraint.to) return "both ends are the same pose";
  const Eigen::Matrix3d R = constraint.T_from_to.linear();
  if (!constraint.T_from_to.matrix().allFinite()) return "the transform is not finite";
  if (!(R.transpose() * R).isIdentity(kRotationTolerance) || R.determinant() < 0.0) {
    return "the transform has no rotation";
  }
  const Matrix6d& information = constraint.information;
  if (!information.allFinite()) return "the information is not finite";
  const double tolerance = kSymmetryTolerance * information.cwiseAbs().maxCoeff();
  if ((information - information.transpose()).cwiseAbs().maxCoeff() > tolerance) {
    return "the information is not symmetric";
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information, Eigen::EigenvaluesOnly);
  if (solver.eigenvalues()(0) < -tolerance) return "the information has a negative eigenvalue";
  return "";
}

ConstraintResidual constraintResidual(const PoseConstraint& constraint,
                                      const Eigen::Isometry3d& T_map_from,
                                      const Eigen::Isometry3d& T_map_to) {
  const Eigen::Isometry3d T_from_to = T_map_from.inverse(Eigen::Isometry) * T_map_to;
  ConstraintResidual residual;
  residual.error = minus(T_from_to, constraint.T_from_to);
  const Eigen::Matrix3d R_measured_to =
      constraint.T_from_to.linear().transpose() * T_from_to.linear();
  // A perturbation of `to` in its frame, seen as one of the error, which lives in the measured
  // frame; one of `from` first moves `to` along, and the other way.
  residual.by_to.topLeftCorner<3, 3>() = R_measured_to;
  residual.by_to.bottomRightCorner<3, 3>() = inverseRightJacobian(residual.error.tail<3>());
  residual.by_from = -residual.by_to * transportMatrix(T_from_to);
  return residual;
}

double constraintChi2(const PoseConstraint& constraint, const Eigen::Isometry3d& T_map_from,
                      const Eigen::Isometry3d& T_map_to) {
  const Vector6d error =
      minus(T_map_from.inverse(Eigen::Isometry) * T_map_to, constraint.T_from_to);
  return error.dot(constraint.information * error);
}

double innovationChi2(const Eigen::Isometry3d& T_measured, const Matrix6d& measured_covariance,
                      const Eigen::Isometry3d& T_estimated, const Matrix6d& estimated_covariance) {
  const Vector6d error = minus(T_estimated, T_measured);
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = T_measured.linear().transpose() * T_estimated.linear();
  J.bottomRightCorner<3, 3>() = inverseRightJacobian(error.tail<3>());
  const Matrix6d S = J * estimated_covariance * J.transpose() + measured_covariance;
  return error.dot(S.ldlt().solve(error));
}

}  // namespace ladar_perception
