// SPDX-License-Identifier: BSD-3-Clause
// The derivatives that registrations go by, against finite differences.
#include <gtest/gtest.h>

#include <cmath>

#include "../../src/register/pair_sums.h"
#include "ladar_perception/register/twist.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;

struct Pair {
  Vector3d q, n, p, m;
};

Pair randomPair(test::TestRandom* random) {
  Pair pair;
  pair.q = 3.0 * random->normal3();
  pair.p = pair.q + 0.1 * random->normal3();
  pair.m = random->normal3().normalized();
  pair.n = (pair.m + 0.2 * random->normal3()).normalized();
  return pair;
}

PairSums sumsOf(const Matching& matching, const Pair& pair) {
  PairSums sums;
  addPair(matching, pair.q, pair.n, pair.p, pair.m, &sums);
  return sums;
}

Pair movedBy(const Vector6d& twist, Pair pair) {
  const Eigen::Isometry3d T = expTwist(twist);
  pair.q = T * pair.q;
  return pair;
}

/// Half the squared cost whose gradient addPair adds.
double cost(const Matching& matching, const Pair& pair) {
  const Vector3d error = pair.q - pair.p;
  double squared = std::pow(pair.m.dot(error), 2);
  if (matching.generalized) {
    constexpr double kFlat = 1e-3;
    const Eigen::Matrix3d a =
        Eigen::Matrix3d::Identity() - (1.0 - kFlat) * pair.m * pair.m.transpose();
    const Eigen::Matrix3d b =
        Eigen::Matrix3d::Identity() - (1.0 - kFlat) * pair.n * pair.n.transpose();
    squared = 2.0 * kFlat * error.dot((a + b).inverse() * error);
  }
  const double c2 = matching.robust_scale_m * matching.robust_scale_m;
  return 0.5 * (std::isinf(c2) ? squared : c2 * squared / (c2 + squared));
}

/// Normals of generalised pairs turn, too, but only with the next iteration.
void expectGradientOfCost(const Matching& matching) {
  test::TestRandom random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Pair pair = randomPair(&random);
    const PairSums sums = sumsOf(matching, pair);
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 6; ++axis) {
      const Vector6d twist = kStep * Vector6d::Unit(axis);
      const double slope =
          (cost(matching, movedBy(twist, pair)) - cost(matching, movedBy(-twist, pair))) /
          (2.0 * kStep);
      EXPECT_NEAR(sums.gradient[axis], slope, 1e-7) << axis;
    }
  }
}

TEST(PairSums, GradientIsThatOfTheDistanceFromThePlane) { expectGradientOfCost(Matching()); }

TEST(PairSums, GradientIsThatOfTheRobustCost) {
  Matching matching;
  matching.robust_scale_m = 0.1;
  expectGradientOfCost(matching);
}

TEST(PairSums, GradientIsThatOfTheGeneralizedCost) {
  Matching matching;
  matching.generalized = true;
  expectGradientOfCost(matching);
  matching.robust_scale_m = 0.1;
  expectGradientOfCost(matching);
}

TEST(PairSums, InformationIsTheDerivativeOfTheGradient) {
  for (const bool generalized : {false, true}) {
    Matching matching;
    matching.generalized = generalized;
    test::TestRandom random(2);
    Pair pair = randomPair(&random);
    pair.p = pair.q;  // where Gauss and Newton agree
    const PairSums sums = sumsOf(matching, pair);
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 6; ++axis) {
      const Vector6d twist = kStep * Vector6d::Unit(axis);
      const Vector6d change = (sumsOf(matching, movedBy(twist, pair)).gradient -
                               sumsOf(matching, movedBy(-twist, pair)).gradient) /
                              (2.0 * kStep);
      EXPECT_LT((sums.information.col(axis) - change).norm(), 1e-5) << axis;
    }
  }
}

TEST(PairSums, GeneralizedIsPointToPlaneWhereNormalsAgree) {
  test::TestRandom random(3);
  Pair pair = randomPair(&random);
  pair.n = pair.m;
  pair.p = pair.q - 0.1 * pair.m;
  Matching matching;
  const PairSums plane = sumsOf(matching, pair);
  matching.generalized = true;
  const PairSums generalized = sumsOf(matching, pair);
  EXPECT_LT((plane.gradient - generalized.gradient).norm(), 1e-9);
  EXPECT_EQ(plane.squared_residuals, generalized.squared_residuals);
}

}  // namespace
}  // namespace ladar_perception
