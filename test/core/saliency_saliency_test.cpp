// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/saliency.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <functional>
#include <vector>

#include "support_volumes.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::SupportVolume;
using test::TestRandom;
using test::VolumeKind;
using test::VolumeMaker;

constexpr double kVoxelSize_m = 0.1;
constexpr double kStep_m = kVoxelSize_m / static_cast<double>(kStepsPerVoxel);
constexpr double kPi = 3.14159265358979323846;

Moments momentsOf(const std::vector<Vector3d>& points_m) {
  Moments moments;
  for (const Vector3d& p : points_m) moments.add(toFixedPoint(p, 1.0 / kStep_m));
  return moments;
}

Saliency saliencyOfPoints(const std::vector<Vector3d>& points_m) {
  return saliencyOf(momentsOf(points_m).about({128, 128, 128}), kStep_m);
}

std::vector<Vector3d> sample(int count, const std::function<Vector3d(TestRandom*)>& point) {
  TestRandom random(1);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) points.push_back(point(&random));
  return points;
}

/// Covariance in long double, divided by N.
Eigen::Matrix3d covariance(const std::vector<FixedPoint>& points) {
  using Vector3l = Eigen::Matrix<long double, 3, 1>;
  Vector3l mean = Vector3l::Zero();
  const auto position = [](const FixedPoint& q) {
    return Vector3l(static_cast<long double>(q.x), static_cast<long double>(q.y),
                    static_cast<long double>(q.z));
  };
  for (const FixedPoint& q : points) mean += position(q);
  mean /= static_cast<long double>(points.size());
  Eigen::Matrix<long double, 3, 3> sum = Eigen::Matrix<long double, 3, 3>::Zero();
  for (const FixedPoint& q : points) {
    sum += (position(q) - mean) * (position(q) - mean).transpose();
  }
  return (sum / static_cast<long double>(points.size())).cast<double>();
}

TEST(ScatterMatrix, EqualsTheCovarianceNearAndFar) {
  TestRandom random(2);
  for (const int64_t away : {int64_t{0}, int64_t{2560000000}, int64_t{-25600000000}}) {
    for (const int count : {1, 2, 3, 50, 1000}) {
      std::vector<FixedPoint> points;
      Moments moments;
      for (int i = 0; i < count; ++i) {
        const int64_t x = away + random.integer(-1000, 1000);
        const int64_t y = -away + random.integer(-300, 1200);
        points.push_back({x, y, away + random.integer(0, 10)});
        moments.add(points.back());
      }
      const SymmetricMatrix3 c = scatterMatrix(moments.about({away, -away, away}), 0.5);
      const Eigen::Matrix3d expected = 0.25 * covariance(points);
      const double tolerance = 1e-14 * (1.0 + expected.cwiseAbs().maxCoeff());
      EXPECT_NEAR(c.xx, expected(0, 0), tolerance);
      EXPECT_NEAR(c.xy, expected(0, 1), tolerance);
      EXPECT_NEAR(c.xz, expected(0, 2), tolerance);
      EXPECT_NEAR(c.yy, expected(1, 1), tolerance);
      EXPECT_NEAR(c.yz, expected(1, 2), tolerance);
      EXPECT_NEAR(c.zz, expected(2, 2), tolerance);
    }
  }
}

TEST(ScatterMatrix, DoesNotDependOnTheReference) {
  const Moments moments = momentsOf({{0.1, 0.2, 0.3}, {0.5, 0.1, 0.2}, {0.3, 0.4, 0.9}});
  const SymmetricMatrix3 a = scatterMatrix(moments.about({0, 0, 0}), kStep_m);
  const SymmetricMatrix3 b = scatterMatrix(moments.about({-1000, 777, 128}), kStep_m);
  EXPECT_EQ(a.xx, b.xx);
  EXPECT_EQ(a.xy, b.xy);
  EXPECT_EQ(a.xz, b.xz);
  EXPECT_EQ(a.yy, b.yy);
  EXPECT_EQ(a.yz, b.yz);
  EXPECT_EQ(a.zz, b.zz);
}

TEST(Saliency, TooFewPointsOrAllInOnePlaceHaveNone) {
  EXPECT_FALSE(saliencyOf(Moments().about({0, 0, 0}), kStep_m).defined);
  const std::vector<Vector3d> two = {{0, 0, 0}, {0.3, 0, 0}};
  EXPECT_FALSE(saliencyOfPoints(two).defined);
  EXPECT_EQ(saliencyOfPoints(two).points, 2U);
  const std::vector<Vector3d> same(100, Vector3d(0.12, 0.34, 0.56));
  EXPECT_FALSE(saliencyOfPoints(same).defined);
  EXPECT_EQ(saliencyOfPoints(same).points, 100U);
}

TEST(Saliency, ThreePointsOnALineAreLinear) {
  const Saliency s = saliencyOfPoints({{0, 0, 0.001}, {0.1, 0, 0.001}, {0.2, 0, 0.001}});
  ASSERT_TRUE(s.defined);
  EXPECT_EQ(s.scatter, 0.0);
  EXPECT_EQ(s.surface, 0.0);
  EXPECT_NEAR(s.linear, 0.02 / 3, 1e-12);
  EXPECT_NEAR(std::abs(s.tangent.x()), 1.0, 1e-15);
  EXPECT_NEAR(s.normal.dot(s.tangent), 0.0, 1e-15);
}

TEST(Saliency, ADuplicatedSetKeepsItsShape) {
  const std::vector<Vector3d> once = {{0, 0, 0}, {0.5, 0.1, 0.2}, {0.3, 0.4, 0.1}, {0.2, 0.2, 0.7}};
  std::vector<Vector3d> often;
  for (int i = 0; i < 500; ++i) often.insert(often.end(), once.begin(), once.end());
  const Saliency a = saliencyOfPoints(once);
  const Saliency b = saliencyOfPoints(often);
  EXPECT_NEAR(a.scatter, b.scatter, 1e-16);
  EXPECT_NEAR(a.surface, b.surface, 1e-16);
  EXPECT_NEAR(a.linear, b.linear, 1e-16);
}

class Tilted : public testing::TestWithParam<double> {
 protected:
  /// Turns about the axis (1, 2, 0): the vertical tilts by the angle.
  Eigen::AngleAxisd tilt() const {
    return Eigen::AngleAxisd(GetParam() * kPi / 180.0, Vector3d(1, 2, 0).normalized());
  }
  double angleToVertical(const Vector3d& direction) const {
    return std::acos(std::min(1.0, direction.z())) * 180.0 / kPi;
  }
};

TEST_P(Tilted, ASquareIsASurfaceWithItsNormal) {
  // Side 0.9 m: variance a^2 / 12 along both sides.
  const auto points = sample(200000, [&](TestRandom* random) {
    const double x = random->real(-0.45, 0.45);
    return Vector3d(tilt() * Vector3d(x, random->real(-0.45, 0.45), 0.0));
  });
  const Saliency s = saliencyOfPoints(points);
  const double variance = 0.9 * 0.9 / 12;
  ASSERT_TRUE(s.defined);
  EXPECT_LT(s.scatter, kStep_m * kStep_m);
  EXPECT_NEAR(s.surface, variance, 0.01 * variance);
  EXPECT_NEAR(s.linear, 0.0, 0.01 * variance);
  EXPECT_GE(s.normal.z(), 0.0);
  EXPECT_NEAR(angleToVertical(s.normal), GetParam(), 0.02);
}

TEST_P(Tilted, ARodIsLinearWithItsTangent) {
  const auto points = sample(20000, [&](TestRandom* random) {
    return Vector3d(tilt() * Vector3d(0.0, 0.0, random->real(-0.45, 0.45)));
  });
  const Saliency s = saliencyOfPoints(points);
  const double variance = 0.9 * 0.9 / 12;
  ASSERT_TRUE(s.defined);
  EXPECT_LT(s.scatter, kStep_m * kStep_m);
  EXPECT_LT(s.surface, kStep_m * kStep_m);
  EXPECT_NEAR(s.linear, variance, 0.02 * variance);
  EXPECT_GE(s.tangent.z(), 0.0);
  EXPECT_NEAR(angleToVertical(s.tangent), GetParam(), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Degrees, Tilted, testing::Values(0.0, 10.0, 45.0, 80.0, 89.0));

TEST(Saliency, ABallScatters) {
  const auto points = sample(200000, [](TestRandom* random) {
    Vector3d p;
    do {
      const double x = random->real(-0.4, 0.4);
      const double y = random->real(-0.4, 0.4);
      p = Vector3d(x, y, random->real(-0.4, 0.4));
    } while (p.norm() > 0.4);
    return p;
  });
  const Saliency s = saliencyOfPoints(points);
  const double variance = 0.4 * 0.4 / 5;  // of a coordinate in a full ball
  EXPECT_NEAR(s.scatter, variance, 0.01 * variance);
  EXPECT_NEAR(s.surface, 0.0, 0.01 * variance);
  EXPECT_NEAR(s.linear, 0.0, 0.01 * variance);
  EXPECT_EQ(s.points, 200000U);
}

TEST(Saliency, QuantisingCostsLessThanAFortiethOfAMillimetre) {
  // The error of sqrt(l0) is 0.024 mm at worst, for a noisy plane.
  for (const double noise_m : {0.001, 0.005, 0.02}) {
    TestRandom random(3);
    std::vector<Vector3d> points;
    Eigen::Matrix3Xd exact(3, 400);
    for (int i = 0; i < 400; ++i) {
      const Vector3d p(random.real(-0.4, 0.4), random.real(-0.4, 0.4), noise_m * random.normal());
      points.push_back(Eigen::AngleAxisd(0.5, Vector3d::UnitX()) * p);
      exact.col(i) = points.back();
    }
    const Eigen::Matrix3Xd centered = exact.colwise() - exact.rowwise().mean();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(centered * centered.transpose() /
                                                                400.0);
    EXPECT_NEAR(std::sqrt(saliencyOfPoints(points).scatter), std::sqrt(solver.eigenvalues()[0]),
                2.4e-5);
  }
}

TEST(Saliency, AMillionMetresAwayEverythingIsTheSameBitByBit) {
  TestRandom random(4);
  for (int round = 0; round < 200; ++round) {
    Moments near;
    Moments far;
    const VoxelIndex shift = {10000000, -10000000, 1000000};
    const Vector3d normal = random.normal3().normalized();
    for (int i = 0; i < 60; ++i) {
      Vector3d p = 0.2 * random.normal3();
      p -= p.dot(normal) * normal;
      const FixedPoint q = toFixedPoint(p, 1.0 / kStep_m);
      near.add(q);
      far.add({q.x + shift.x * kStepsPerVoxel, q.y + shift.y * kStepsPerVoxel,
               q.z + shift.z * kStepsPerVoxel});
    }
    const Saliency a = saliencyOf(near.about(centerOf({0, 0, 0})), kStep_m);
    const Saliency b = saliencyOf(far.about(centerOf(shift)), kStep_m);
    EXPECT_EQ(a.scatter, b.scatter);
    EXPECT_EQ(a.surface, b.surface);
    EXPECT_EQ(a.linear, b.linear);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.tangent, b.tangent);
  }
}

TEST(Saliency, IsNeverNegativeOnTheFlattestThings) {
  TestRandom random(5);
  for (int round = 0; round < 20000; ++round) {
    const Vector3d u = random.normal3() * 300.0;
    const Vector3d v = round % 2 == 0 ? Vector3d::Zero() : Vector3d(random.normal3() * 300.0);
    Moments moments;
    for (int i = 0; i < 3 + round % 20; ++i) {
      const double a = random.real(-1, 1);
      const Vector3d p = a * u + random.real(-1, 1) * v;
      moments.add({floorToInt(p.x()), floorToInt(p.y()), floorToInt(p.z())});
    }
    const Saliency s = saliencyOf(moments.about({0, 0, 0}), kStep_m);
    ASSERT_TRUE(s.defined);
    ASSERT_GE(s.scatter, 0.0);
    ASSERT_GE(s.surface, 0.0);
    ASSERT_GE(s.linear, 0.0);
    ASSERT_NEAR(s.normal.norm(), 1.0, 1e-14);
    ASSERT_NEAR(s.tangent.norm(), 1.0, 1e-14);
    ASSERT_GE(s.normal.z(), 0.0);
    ASSERT_GE(s.tangent.z(), 0.0);
  }
}

/// Of one volume alone.
SaliencyF saliencyInBlock(const SupportVolume& volume) {
  SaliencyBlock block;
  saliencyOfBlock(&volume.sum, &volume.voxel, 1, kStep_m, &block);
  return block.at(0);
}

Saliency saliencyOfVolume(const SupportVolume& volume) {
  return saliencyOf(volume.sum.about(centerOf(volume.voxel)), kStep_m);
}

void expectNothing(const SaliencyF& saliency) {
  ASSERT_FALSE(saliency.defined);
  ASSERT_EQ(saliency.scatter, 0.0F);
  ASSERT_EQ(saliency.surface, 0.0F);
  ASSERT_EQ(saliency.linear, 0.0F);
  ASSERT_EQ(saliency.normal, Eigen::Vector3f(0, 0, 0));
  ASSERT_EQ(saliency.tangent, Eigen::Vector3f(0, 0, 0));
}

/// Angle between the lines along two vectors.
double angleBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

constexpr int kRounds = 200;  // of every kind of volume

class SaliencyOfBlock : public testing::TestWithParam<int> {
 protected:
  std::vector<SupportVolume> volumes() const {
    TestRandom random(static_cast<uint64_t>(GetParam()) + 1);
    VolumeMaker maker(&random);
    std::vector<SupportVolume> volumes;
    for (int i = 0; i < kRounds; ++i) {
      volumes.push_back(maker.make(static_cast<VolumeKind>(GetParam())));
    }
    return volumes;
  }
};

TEST_P(SaliencyOfBlock, HasTheEigenvaluesOfTheDoubleOneToAMillionth) {
  for (const SupportVolume& volume : volumes()) {
    const SaliencyF found = saliencyInBlock(volume);
    const Saliency exact = saliencyOfVolume(volume);
    ASSERT_EQ(found.points, exact.points);
    ASSERT_EQ(found.defined, exact.defined);
    const double l1 = exact.scatter + exact.surface;
    const double l2 = l1 + exact.linear;
    const double found_l1 = double{found.scatter} + double{found.surface};
    ASSERT_NEAR(found.scatter, exact.scatter, 1e-6 * l2);
    ASSERT_NEAR(found_l1, l1, 1e-6 * l2);
    ASSERT_NEAR(found_l1 + double{found.linear}, l2, 1e-6 * l2);
    ASSERT_GE(found.scatter, 0.0F);
    ASSERT_GE(found.surface, 0.0F);
    ASSERT_GE(found.linear, 0.0F);
  }
}

TEST_P(SaliencyOfBlock, HasUnitDirectionsThatPointUp) {
  for (const SupportVolume& volume : volumes()) {
    const SaliencyF found = saliencyInBlock(volume);
    if (!found.defined) continue;
    ASSERT_NEAR(found.normal.cast<double>().norm(), 1.0, 1e-6);
    ASSERT_NEAR(found.tangent.cast<double>().norm(), 1.0, 1e-6);
    ASSERT_NEAR(found.normal.cast<double>().dot(found.tangent.cast<double>()), 0.0, 2e-6);
    ASSERT_GE(found.normal.z(), 0.0F);
    ASSERT_GE(found.tangent.z(), 0.0F);
  }
}

TEST_P(SaliencyOfBlock, HasTheDirectionsOfTheDoubleOneWhereTheEigenvaluesTellThemApart) {
  // The matrix is rounded by up to 1e-7 of l2; that turns an eigenvector by as much over the gap
  // to the next eigenvalue, in l2.
  constexpr double kError = 5e-7;
  constexpr double kLeastGap = 1e-3;
  for (const SupportVolume& volume : volumes()) {
    const SaliencyF found = saliencyInBlock(volume);
    if (!found.defined) continue;
    const Saliency exact = saliencyOfVolume(volume);
    const double l2 = exact.scatter + exact.surface + exact.linear;
    const double normal_gap = exact.surface / l2;
    const double tangent_gap = exact.linear / l2;
    if (normal_gap > kLeastGap) {
      ASSERT_LT(angleBetween(found.normal.cast<double>(), exact.normal), kError / normal_gap)
          << "gap " << normal_gap;
    }
    if (tangent_gap > kLeastGap) {
      ASSERT_LT(angleBetween(found.tangent.cast<double>(), exact.tangent), kError / tangent_gap)
          << "gap " << tangent_gap;
    }
  }
}

TEST_P(SaliencyOfBlock, IsDefinedWherePointsSpanSomething) {
  const auto kind = static_cast<VolumeKind>(GetParam());
  const bool none = kind == VolumeKind::kEmpty || kind == VolumeKind::kOnePoint ||
                    kind == VolumeKind::kTwoPoints || kind == VolumeKind::kAllEqual;
  int defined = 0;
  for (const SupportVolume& volume : volumes()) {
    const SaliencyF found = saliencyInBlock(volume);
    defined += found.defined ? 1 : 0;
    if (found.defined) continue;
    ASSERT_NO_FATAL_FAILURE(expectNothing(found));
  }
  if (none) {
    EXPECT_EQ(defined, 0);
  } else {
    EXPECT_GT(defined, kRounds * 9 / 10);  // lines along (0, 0, 0) are points
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, SaliencyOfBlock, testing::Range(0, test::kVolumeKinds));

/// The bits of one volume's results.
bool sameBits(const SaliencyF& a, const SaliencyF& b) {
  const auto same = [](const auto& x, const auto& y) {
    return std::memcmp(&x, &y, sizeof(x)) == 0;
  };
  return a.points == b.points && a.defined == b.defined && same(a.scatter, b.scatter) &&
         same(a.surface, b.surface) && same(a.linear, b.linear) && same(a.normal, b.normal) &&
         same(a.tangent, b.tangent);
}

TEST(SaliencyBlock, PlaceAndCountDoNotMatter) {
  TestRandom random(31);
  VolumeMaker maker(&random);
  for (const int count : {1, 2, 3, 15, 16, 17, 63, 64}) {
    const std::vector<SupportVolume> volumes = maker.makeMany(count);
    for (const int turn : {0, 1, 7}) {
      std::vector<Moments> sums;
      std::vector<VoxelIndex> voxels;
      for (int i = 0; i < count; ++i) {
        sums.push_back(volumes[(i + turn) % count].sum);
        voxels.push_back(volumes[(i + turn) % count].voxel);
      }
      SaliencyBlock block;
      std::memset(&block, 0xA5, sizeof(block));
      saliencyOfBlock(sums.data(), voxels.data(), count, kStep_m, &block);
      for (int i = 0; i < count; ++i) {
        ASSERT_TRUE(sameBits(block.at(i), saliencyInBlock(volumes[(i + turn) % count])))
            << "volume " << i << " of " << count << ", turned by " << turn;
      }
      for (int i = count; i < kSaliencyBlock; ++i) {
        ASSERT_NO_FATAL_FAILURE(expectNothing(block.at(i))) << i << " of " << count;
      }
    }
  }
}

}  // namespace
}  // namespace ladar_perception
