// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ladar_perception/saliency/eigen_symmetric3.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::TestRandom;

// Of the greatest absolute eigenvalue; the header promises errors near 1e-15.
constexpr double kValueTolerance = 2e-15;
constexpr double kVectorTolerance = 1e-14;

SymmetricMatrix3 upperTriangle(const Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

Matrix3d randomRotation(TestRandom* random) {
  Eigen::Quaterniond q(random->normal(), random->normal(), random->normal(), random->normal());
  return q.normalized().toRotationMatrix();
}

/// What must hold for any symmetric matrix, against Eigen's iterative solver.
void expectSolves(const Matrix3d& m) {
  const EigenSymmetric3 e = eigenSymmetric3(upperTriangle(m));
  const double scale = m.cwiseAbs().maxCoeff();
  const Vector3d expected =
      scale > 0.0
          ? Vector3d(Eigen::SelfAdjointEigenSolver<Matrix3d>(m / scale).eigenvalues() * scale)
          : Vector3d::Zero();
  ASSERT_LE(e.l0, e.l1);
  ASSERT_LE(e.l1, e.l2);
  const Vector3d values(e.l0, e.l1, e.l2);
  ASSERT_LE((values - expected).cwiseAbs().maxCoeff(), 2 * kValueTolerance * scale) << m;
  ASSERT_NEAR(e.e0.norm(), 1.0, kVectorTolerance);
  ASSERT_NEAR(e.e2.norm(), 1.0, kVectorTolerance);
  ASSERT_NEAR(e.e0.dot(e.e2), 0.0, kVectorTolerance) << m;
  ASSERT_LE((m * e.e0 - e.l0 * e.e0).norm(), kVectorTolerance * scale) << m;
  ASSERT_LE((m * e.e2 - e.l2 * e.e2).norm(), kVectorTolerance * scale) << m;
}

Matrix3d withEigenvalues(TestRandom* random, const Vector3d& values) {
  const Matrix3d r = randomRotation(random);
  const Matrix3d m = r * values.asDiagonal() * r.transpose();
  return (m + m.transpose()) / 2.0;
}

TEST(EigenSymmetric3, RandomMatricesOfEveryRankAndScale) {
  TestRandom random(1);
  for (int i = 0; i < 100000; ++i) {
    const double scale = std::pow(10.0, random.real(-30.0, 30.0));
    Vector3d values(random.real(0, 1), random.real(0, 1), random.real(0, 1));
    for (int zero = i % 4; zero < 3; ++zero) values[zero] = 0.0;  // rank i % 4
    ASSERT_NO_FATAL_FAILURE(expectSolves(withEigenvalues(&random, values * scale)));
  }
}

TEST(EigenSymmetric3, DoubleAndNearlyDoubleEigenvalues) {
  TestRandom random(2);
  for (int i = 0; i < 30000; ++i) {
    const double gap = i % 10 == 0 ? 0.0 : std::pow(10.0, random.real(-17.0, -1.0));
    const double third = i % 3 == 0 ? 0.0 : std::pow(10.0, random.real(-12.0, 2.0));
    const double scale = std::pow(10.0, random.real(-6.0, 6.0));
    ASSERT_NO_FATAL_FAILURE(
        expectSolves(scale * withEigenvalues(&random, {1.0, 1.0 + gap, third})));
  }
}

TEST(EigenSymmetric3, NearlyTripleEigenvalues) {
  TestRandom random(3);
  for (int i = 0; i < 20000; ++i) {
    const double gap = std::pow(10.0, random.real(-18.0, -1.0));
    const Vector3d values(1.0, 1.0 + gap * random.real(0, 1), 1.0 + gap * random.real(0, 1));
    ASSERT_NO_FATAL_FAILURE(expectSolves(withEigenvalues(&random, values)));
  }
}

TEST(EigenSymmetric3, IndefiniteMatrices) {
  TestRandom random(4);
  for (int i = 0; i < 20000; ++i) {
    const Vector3d values(random.real(-1, 1), random.real(-1, 1), random.real(-1, 1));
    ASSERT_NO_FATAL_FAILURE(expectSolves(withEigenvalues(&random, values)));
  }
}

TEST(EigenSymmetric3, DiagonalMatricesInAnyOrder) {
  for (const double a : {0.0, 1.0, 2.0}) {
    for (const double b : {0.0, 1.0, 2.0}) {
      for (const double c : {0.0, 1.0, 2.0}) {
        ASSERT_NO_FATAL_FAILURE(expectSolves(Vector3d(a, b, c).asDiagonal()));
      }
    }
  }
}

TEST(EigenSymmetric3, RankOneAndTwoFromWholeNumbers) {
  // Exact scatter of lattice directions: rank 1 and 2 without any rounding in the input.
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) {
      for (int z = -3; z <= 3; ++z) {
        const Vector3d u(x, y, z);
        const Vector3d v(y + 1, -x, 2);
        ASSERT_NO_FATAL_FAILURE(expectSolves(u * u.transpose()));
        ASSERT_NO_FATAL_FAILURE(expectSolves(u * u.transpose() + v * v.transpose()));
      }
    }
  }
}

TEST(EigenSymmetric3, ZeroGivesZeroAndUnitVectors) {
  const EigenSymmetric3 e = eigenSymmetric3({});
  EXPECT_EQ(e.l0, 0.0);
  EXPECT_EQ(e.l2, 0.0);
  EXPECT_EQ(e.e0.norm(), 1.0);
  EXPECT_EQ(e.e0.dot(e.e2), 0.0);
}

TEST(EigenSymmetric3, KnownDirectionsOfAPlaneAndALine) {
  TestRandom random(5);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3d r = randomRotation(&random);
    const Matrix3d plane = r * Vector3d(2.0, 1.0, 0.0).asDiagonal() * r.transpose();
    const EigenSymmetric3 p = eigenSymmetric3(upperTriangle(plane));
    EXPECT_NEAR(std::abs(p.e0.dot(r.col(2))), 1.0, 1e-14);
    EXPECT_NEAR(std::abs(p.e2.dot(r.col(0))), 1.0, 1e-14);
    const Matrix3d line = r * Vector3d(3.0, 0.0, 0.0).asDiagonal() * r.transpose();
    const EigenSymmetric3 l = eigenSymmetric3(upperTriangle(line));
    EXPECT_NEAR(std::abs(l.e2.dot(r.col(0))), 1.0, 1e-14);
  }
}

}  // namespace
}  // namespace ladar_perception
