// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <unsupported/Eigen/MatrixFunctions>

#include "ladar_perception/register/twist.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Twist = Eigen::Matrix<double, 6, 1>;

Twist randomTwist(test::TestRandom* random, double size) {
  Twist twist;
  twist << random->normal3(), random->normal3();
  return size * twist;
}

TEST(Twist, ExpIsThatOfTheMatrix) {
  test::TestRandom random(1);
  for (const double size : {1.0, 0.1, 1e-3, 1e-5, 1e-9}) {
    const Twist twist = randomTwist(&random, size);
    Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
    generator.topLeftCorner<3, 3>() = skew(twist.head<3>());
    generator.topRightCorner<3, 1>() = twist.tail<3>();
    const Eigen::Matrix4d expected = generator.exp();
    EXPECT_LT((expTwist(twist).matrix() - expected).cwiseAbs().maxCoeff(), 1e-14) << size;
  }
  EXPECT_EQ(expTwist(Twist::Zero()).matrix(), Eigen::Matrix4d::Identity());
}

TEST(Twist, LogUndoesExp) {
  test::TestRandom random(2);
  for (const double size : {0.8, 0.1, 1e-3, 1e-6}) {
    const Twist twist = randomTwist(&random, size);
    EXPECT_LT((logTwist(expTwist(twist)) - twist).norm(), 1e-9 * size + 1e-15) << size;
  }
}

TEST(Twist, AdjointCarriesTwistsThroughATransform) {
  test::TestRandom random(3);
  const Eigen::Isometry3d T = expTwist(randomTwist(&random, 1.0));
  const Twist twist = randomTwist(&random, 0.3);
  const Eigen::Isometry3d left = expTwist(adjoint(T) * twist) * T;
  EXPECT_LT(((T * expTwist(twist)).matrix() - left.matrix()).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Twist, NearestRotationIsOne) {
  test::TestRandom random(4);
  const Eigen::Isometry3d T = expTwist(randomTwist(&random, 1.0));
  Eigen::Matrix3d near = T.linear();
  for (int i = 0; i < 9; ++i) near(i) += random.real(-1e-4, 1e-4);
  const Eigen::Matrix3d rotation = nearestRotation(near);
  EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_GT(rotation.determinant(), 0.0);
  EXPECT_LT((rotation - T.linear()).norm(), 5e-4);
  const Eigen::Matrix3d mirror = Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal();
  EXPECT_GT(nearestRotation(mirror).determinant(), 0.0);
}

}  // namespace
}  // namespace ladar_perception
