// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "ladar_perception/slam/se3.h"
#include "slam_cases.h"

namespace ladar_perception {
namespace {

using test::normal6;
using test::randomCovariance;
using test::randomPose;
using test::TestRandom;

TEST(SlamSe3, RotationOfAQuarterTurn) {
  const Eigen::Matrix3d R = expRotation({0, 0, M_PI_2}).toRotationMatrix();
  EXPECT_TRUE((R * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-15));
}

TEST(SlamSe3, LogIsTheInverseOfExpAtEveryAngle) {
  TestRandom random(1);
  for (const double angle : {0.0, 1e-12, 1e-8, 0.99e-4, 1.01e-4, 1e-2, 1.0, 3.0, M_PI - 1e-9}) {
    const Eigen::Vector3d axis = random.normal3().normalized();
    const Eigen::Quaterniond q = expRotation(angle * axis);
    EXPECT_LT((logRotation(q) - angle * axis).norm(), 1e-15 + 1e-13 * angle) << angle;
    const Eigen::Quaterniond other(-q.w(), -q.x(), -q.y(), -q.z());
    EXPECT_LT((logRotation(other) - angle * axis).norm(), 1e-15 + 1e-13 * angle) << angle;
  }
}

TEST(SlamSe3, InverseRightJacobianIsTheDerivativeOfLog) {
  TestRandom random(2);
  for (const double angle : {0.0, 1e-6, 0.9e-4, 1.1e-4, 0.1, 1.0, 2.5}) {
    const Eigen::Vector3d r = angle * random.normal3().normalized();
    const Eigen::Matrix3d J = inverseRightJacobian(r);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d slope = (logRotation(expRotation(r) * expRotation(d)) -
                                     logRotation(expRotation(r) * expRotation(-d))) /
                                    (2.0 * h);
      EXPECT_LT((slope - J.col(k)).norm(), 2e-9) << angle;
    }
  }
}

TEST(SlamSe3, MinusFindsWhatPlusAdded) {
  TestRandom random(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Isometry3d T = randomPose(&random, 100.0, 1.0);
    const Vector6d d = normal6(&random, 1.0, 0.5);
    EXPECT_LT((minus(plus(T, d), T) - d).norm(), 1e-12);
  }
}

TEST(SlamSe3, TransportFollowsARigidBody) {
  TestRandom random(4);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d T_map_a = randomPose(&random, 10.0, 1.0);
    const Eigen::Isometry3d T_a_b = randomPose(&random, 10.0, 1.0);
    const Vector6d d_a = normal6(&random, 1e-6, 1e-6);
    const Vector6d d_b = minus(plus(T_map_a, d_a) * T_a_b, T_map_a * T_a_b);
    EXPECT_LT((transportMatrix(T_a_b) * d_a - d_b).norm(), 1e-5 * d_b.norm());
  }
}

/// Covariance of `count` perturbations.
template <typename Draw>
Matrix6d sampledCovariance(int count, Draw draw) {
  Matrix6d sum = Matrix6d::Zero();
  for (int i = 0; i < count; ++i) {
    const Vector6d d = draw();
    sum += d * d.transpose();
  }
  return sum / count;
}

/// Largest difference, each entry measured by the standard deviations that belong to it.
double relativeDifference(const Matrix6d& a, const Matrix6d& b) {
  const Vector6d sigma = b.diagonal().cwiseSqrt();
  return ((a - b).array() / (sigma * sigma.transpose()).array()).abs().maxCoeff();
}

TEST(SlamSe3, CovarianceOfTheInverseAgreesWithSamples) {
  TestRandom random(5);
  const Eigen::Isometry3d T = randomPose(&random, 3.0, 1.0);
  const Matrix6d covariance = randomCovariance(&random, 0.01);
  const Matrix6d root = covariance.llt().matrixL();
  const Matrix6d sampled = sampledCovariance(20000, [&] {
    const Vector6d d = root * normal6(&random, 1.0, 1.0);
    return minus(plus(T, d).inverse(Eigen::Isometry), T.inverse(Eigen::Isometry));
  });
  EXPECT_LT(relativeDifference(invertedCovariance(T, covariance), sampled), 0.04);
}

TEST(SlamSe3, CovarianceOfAProductAgreesWithSamples) {
  TestRandom random(6);
  const Eigen::Isometry3d T_ab = randomPose(&random, 3.0, 1.0);
  const Eigen::Isometry3d T_bc = randomPose(&random, 3.0, 1.0);
  const Matrix6d first = randomCovariance(&random, 0.01);
  const Matrix6d second = randomCovariance(&random, 0.01);
  const Matrix6d first_root = first.llt().matrixL();
  const Matrix6d second_root = second.llt().matrixL();
  const Matrix6d sampled = sampledCovariance(20000, [&] {
    const Vector6d d_ab = first_root * normal6(&random, 1.0, 1.0);
    const Vector6d d_bc = second_root * normal6(&random, 1.0, 1.0);
    return minus(plus(T_ab, d_ab) * plus(T_bc, d_bc), T_ab * T_bc);
  });
  EXPECT_LT(relativeDifference(composedCovariance(first, T_bc, second), sampled), 0.04);
}

TEST(SlamSe3, InverseOfSingularIsVeryUncertainNotInfinite) {
  Matrix6d information = Matrix6d::Identity() * 4.0;
  information(2, 2) = 0.0;
  const Matrix6d covariance = invertSymmetric(information);
  EXPECT_NEAR(covariance(0, 0), 0.25, 1e-12);
  EXPECT_NEAR(covariance(2, 2), 1e9, 1.0);
  TestRandom random(7);
  const Matrix6d regular = randomCovariance(&random, 1.0);
  EXPECT_TRUE((invertSymmetric(regular) * regular).isIdentity(1e-9));
}

TEST(SlamSe3, PositionSigmaIsThatOfTheWorstDirection) {
  Matrix6d covariance = diagonalCovariance(0.1, 0.2);
  covariance(0, 0) = covariance(1, 1) = 5.0;
  covariance(0, 1) = covariance(1, 0) = 4.0;  // 9 along the diagonal
  EXPECT_NEAR(positionSigma(covariance), 3.0, 1e-12);
  EXPECT_EQ(positionSigma(Matrix6d::Zero()), 0.0);
}

}  // namespace
}  // namespace ladar_perception
