// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "ladar_perception/slam/pose_constraint.h"
#include "slam_cases.h"

namespace ladar_perception {
namespace {

using test::makeConstraint;
using test::normal6;
using test::randomCovariance;
using test::randomPose;
using test::TestRandom;

TEST(SlamPoseConstraint, DerivativesAgreeWithDifferences) {
  TestRandom random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Isometry3d T_a = randomPose(&random, 20.0, 1.0);
    const Eigen::Isometry3d T_b = randomPose(&random, 20.0, 1.0);
    // Errors up to large ones: a wrong constraint is far from zero.
    const Eigen::Isometry3d measured =
        plus(T_a.inverse(Eigen::Isometry) * T_b, normal6(&random, 2.0, 0.5));
    const PoseConstraint constraint =
        makeConstraint(0, 1, measured, Matrix6d::Identity(), ConstraintKind::kOdometry);
    const ConstraintResidual residual = constraintResidual(constraint, T_a, T_b);
    const double h = 1e-6;
    for (int k = 0; k < 6; ++k) {
      const Vector6d d = h * Vector6d::Unit(k);
      const auto error = [&](const Vector6d& d_a, const Vector6d& d_b) {
        return constraintResidual(constraint, plus(T_a, d_a), plus(T_b, d_b)).error;
      };
      const Vector6d zero = Vector6d::Zero();
      const Vector6d by_from = (error(d, zero) - error(-d, zero)) / (2.0 * h);
      const Vector6d by_to = (error(zero, d) - error(zero, -d)) / (2.0 * h);
      EXPECT_LT((by_from - residual.by_from.col(k)).norm(), 1e-7);
      EXPECT_LT((by_to - residual.by_to.col(k)).norm(), 1e-7);
    }
  }
}

TEST(SlamPoseConstraint, NoErrorWhereTheMeasurementIsMet) {
  TestRandom random(2);
  const Eigen::Isometry3d T_a = randomPose(&random, 1000.0, 1.0);
  const Eigen::Isometry3d T_ab = randomPose(&random, 20.0, 1.0);
  const PoseConstraint constraint =
      makeConstraint(0, 1, T_ab, Matrix6d::Identity(), ConstraintKind::kOdometry);
  EXPECT_LT(constraintResidual(constraint, T_a, T_a * T_ab).error.norm(), 1e-11);
  EXPECT_LT(constraintChi2(constraint, T_a, T_a * T_ab), 1e-20);
}

TEST(SlamPoseConstraint, Chi2CountsStandardDeviations) {
  const PoseConstraint constraint =
      makeConstraint(0, 1, Eigen::Isometry3d::Identity(), diagonalCovariance(0.1, 0.02),
                     ConstraintKind::kRegistration);
  Vector6d d = Vector6d::Zero();
  d(1) = 0.3;
  d(5) = 0.04;
  const Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
  EXPECT_NEAR(constraintChi2(constraint, origin, plus(origin, d)), 9.0 + 4.0, 1e-9);
}

TEST(SlamPoseConstraint, InnovationOfRightOnesIsChi2Distributed) {
  TestRandom random(3);
  const Eigen::Isometry3d truth = randomPose(&random, 5.0, 1.0);
  const Matrix6d measured_covariance = randomCovariance(&random, 0.02);
  const Matrix6d estimated_covariance = randomCovariance(&random, 0.05);
  const Matrix6d measured_root = measured_covariance.llt().matrixL();
  const Matrix6d estimated_root = estimated_covariance.llt().matrixL();
  const int count = 20000;
  double sum = 0.0;
  int beyond = 0;
  for (int i = 0; i < count; ++i) {
    const double chi2 = innovationChi2(
        plus(truth, measured_root * normal6(&random, 1.0, 1.0)), measured_covariance,
        plus(truth, estimated_root * normal6(&random, 1.0, 1.0)), estimated_covariance);
    sum += chi2;
    beyond += chi2 > 12.592 ? 1 : 0;  // 5 % at 6 degrees of freedom
  }
  EXPECT_NEAR(sum / count, 6.0, 0.15);
  EXPECT_NEAR(static_cast<double>(beyond) / count, 0.05, 0.008);
}

TEST(SlamPoseConstraint, NamesWhatIsWrong) {
  const auto errorOf = [](const std::function<void(PoseConstraint*)>& spoil) {
    PoseConstraint constraint = makeConstraint(0, 1, Eigen::Isometry3d::Identity(),
                                               Matrix6d::Identity(), ConstraintKind::kOdometry);
    spoil(&constraint);
    return constraintError(constraint);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(errorOf([](PoseConstraint*) {}), "");
  EXPECT_EQ(errorOf([](PoseConstraint* c) { c->information(0, 1) = 0.5; }),
            "the information is not symmetric");
  EXPECT_EQ(errorOf([](PoseConstraint* c) { c->information.setZero(); }), "") << "knows nothing";
  EXPECT_EQ(errorOf([](PoseConstraint* c) { c->to = 0; }), "both ends are the same pose");
  EXPECT_EQ(errorOf([&](PoseConstraint* c) { c->T_from_to.translation().x() = nan; }),
            "the transform is not finite");
  EXPECT_EQ(errorOf([](PoseConstraint* c) { c->T_from_to.linear() *= 2.0; }),
            "the transform has no rotation");
  EXPECT_EQ(errorOf([](PoseConstraint* c) { c->T_from_to.linear()(0, 0) = -1.0; }),
            "the transform has no rotation");
  EXPECT_EQ(errorOf([&](PoseConstraint* c) { c->information(0, 0) = nan; }),
            "the information is not finite");
  EXPECT_EQ(errorOf([](PoseConstraint* c) { c->information(0, 0) = -1.0; }),
            "the information has a negative eigenvalue");
}

}  // namespace
}  // namespace ladar_perception
