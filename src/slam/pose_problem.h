// SPDX-License-Identifier: BSD-3-Clause
// Poses and constraints as Ceres sees them.
#pragma once

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <array>

#include "ladar_perception/slam/pose_constraint.h"

namespace ladar_perception {

/// x y z of the position, x y z w of the quaternion.
using PoseBlock = std::array<double, 7>;

PoseBlock toBlock(const Eigen::Isometry3d& T);
Eigen::Isometry3d fromBlock(const double* block);

/// The perturbations of se3.h, so that what Ceres does is what covariances mean.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// The error of a constraint, whitened by the square root of its information.
class ConstraintCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  explicit ConstraintCost(const PoseConstraint& constraint);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  PoseConstraint constraint_;
  Matrix6d root_;  // root^T root = information
};

}  // namespace ladar_perception
