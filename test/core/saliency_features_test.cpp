// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "ladar_perception/saliency/features.h"
#include "support_volumes.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::TestRandom;

constexpr double kPi = 3.14159265358979323846;
constexpr double kVoxel_m = 0.1;
constexpr double kStep_m = kVoxel_m / static_cast<double>(kStepsPerVoxel);
constexpr int kSize = kSaliencyBlock;

/// Points around the middle of a voxel, in metres from it.
using Points = std::vector<Vector3d>;

/// What is measured of points, in double precision.
struct Shape {
  double count = 0.0;
  Vector3d mean = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();
};

/// A support volume that holds the points, and its shape after they were quantised.
struct Volume {
  explicit Volume(const Points& points, const VoxelIndex& at = {-7, 12, 3}) : voxel(at) {
    const FixedPoint center = centerOf(voxel);
    Points quantised;
    for (const Vector3d& p : points) {
      const auto step = [&](double m) { return static_cast<int64_t>(std::floor(m / kStep_m)); };
      const FixedPoint q = {step(p.x()), step(p.y()), step(p.z())};
      sum.add({center.x + q.x, center.y + q.y, center.z + q.z});
      quantised.push_back(kStep_m * Vector3d(static_cast<double>(q.x), static_cast<double>(q.y),
                                             static_cast<double>(q.z)));
    }
    shape.count = static_cast<double>(points.size());
    for (const Vector3d& p : quantised) shape.mean += p / shape.count;
    for (const Vector3d& p : quantised) {
      shape.covariance += (p - shape.mean) * (p - shape.mean).transpose() / shape.count;
    }
  }

  VoxelIndex voxel;
  Moments sum;
  Shape shape;
};

/// Value of a quantity by its meaning.
double expectedValue(Quantity quantity, const Shape& shape) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(shape.covariance);
  const Vector3d l = solver.eigenvalues().cwiseMax(0.0);
  const Vector3d normal = solver.eigenvectors().col(0);
  const Vector3d tangent = solver.eigenvectors().col(2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> level(
      shape.covariance.topLeftCorner<2, 2>().eval());
  const Eigen::Vector2d sh = level.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const double sz = std::sqrt(shape.covariance(2, 2));
  const double surface = l[1] - l[0];
  const double linear = l[2] - l[1];
  const double most = std::max({l[0], surface, linear});
  switch (quantity) {
    case Quantity::kScatter:
      return l[0];
    case Quantity::kSurface:
      return surface;
    case Quantity::kLinear:
      return linear;
    case Quantity::kCbrtScatter:
      return std::cbrt(l[0]);
    case Quantity::kCbrtSurface:
      return std::cbrt(surface);
    case Quantity::kCbrtLinear:
      return std::cbrt(linear);
    case Quantity::kNormalAngle:
      return std::acos(std::min(std::abs(normal.z()), 1.0));
    case Quantity::kTangentAngle:
      return std::acos(std::min(std::abs(tangent.z()), 1.0));
    case Quantity::kSpreadAngle:
      return std::atan2(sz, sh[1]);
    case Quantity::kHorizontalRatio:
      return sh[0] / sh[1];
    case Quantity::kScatterRatio:
      return std::sqrt(l[0] / l[2]);
    case Quantity::kThicknessRatio:
      return std::sqrt(l[0] / l[1]);
    case Quantity::kLevelSurface:
      return std::abs(normal.z()) * surface / most;
    case Quantity::kUprightSurface:
      return std::hypot(normal.x(), normal.y()) * surface / most;
    case Quantity::kLevelLinear:
      return std::hypot(tangent.x(), tangent.y()) * linear / most;
    case Quantity::kUprightLinear:
      return std::abs(tangent.z()) * linear / most;
    case Quantity::kHorizontalMinor:
      return sh[0];
    case Quantity::kHorizontalMajor:
      return sh[1];
    case Quantity::kVerticalDeviation:
      return sz;
    case Quantity::kMeanOffset:
      return shape.mean.norm();
    case Quantity::kLogPoints:
      return std::log(shape.count);
    default:
      ADD_FAILURE() << "no quantity of a support volume";
      return 0.0;
  }
}

/// How far a value may be off: as far as scatter matrices do whose entries are off by what float32
/// leaves of them.
double tolerance(Quantity quantity, const Shape& shape) {
  constexpr double kFloat = 4e-7;
  TestRandom random(1);
  const double value = expectedValue(quantity, shape);
  double most = 2e-6 * std::max(std::abs(value), 1.0);
  for (int i = 0; i < 50; ++i) {
    Shape off = shape;
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col <= row; ++col) {
        off.covariance(row, col) += kFloat * shape.covariance.trace() * random.real(-1.0, 1.0);
        off.covariance(col, row) = off.covariance(row, col);
      }
    }
    off.covariance.diagonal() = off.covariance.diagonal().cwiseMax(0.0);
    most = std::max(most, 2.0 * std::abs(expectedValue(quantity, off) - value));
  }
  return most;
}

SaliencyBlock blockOf(const Volume& volume) {
  SaliencyBlock block;
  saliencyOfBlock(&volume.sum, &volume.voxel, 1, kStep_m, &block);
  return block;
}

double valueOf(Quantity quantity, const Volume& volume) {
  float values[kSize];
  featureValues(quantity, blockOf(volume), values);
  return values[0];
}

std::vector<Quantity> quantitiesOfVolumes() {
  std::vector<Quantity> quantities;
  for (const QuantityInfo& info : allQuantities()) {
    if (!isOfColumns(info.quantity)) quantities.push_back(info.quantity);
  }
  return quantities;
}

const char* nameOf(Quantity quantity) {
  for (const QuantityInfo& info : allQuantities()) {
    if (info.quantity == quantity) return info.name;
  }
  return "";
}

/// Points evenly at random in a box with these half sides, turned and moved.
Points boxOf(const Vector3d& half, const Matrix3d& turn = Matrix3d::Identity(),
             const Vector3d& middle = Vector3d::Zero(), int count = 400) {
  TestRandom random(7);
  Points points;
  for (int i = 0; i < count; ++i) {
    const double x = random.real(-half.x(), half.x());
    const double y = random.real(-half.y(), half.y());
    points.push_back(middle + turn * Vector3d(x, y, random.real(-half.z(), half.z())));
  }
  return points;
}

Matrix3d turned(double angle_deg, const Vector3d& axis) {
  return Eigen::AngleAxisd(angle_deg * kPi / 180.0, axis.normalized()).toRotationMatrix();
}

std::map<std::string, Points> namedShapes() {
  const Vector3d plane(0.4, 0.35, 0.01);
  const Vector3d wire(0.004, 0.005, 0.42);
  const Vector3d x = Vector3d::UnitX();
  return {{"level plane", boxOf(plane)},
          {"plane at 30 degrees", boxOf(plane, turned(30, x))},
          {"plane at 77 degrees", boxOf(plane, turned(77, Vector3d(1, 2, 0)))},
          {"wall", boxOf(plane, turned(90, x), {0.03, 0.11, -0.02})},
          {"pole", boxOf(wire)},
          {"line at 40 degrees", boxOf(wire, turned(40, Vector3d(1, -1, 0)), {0, 0.1, 0.1})},
          {"level wire", boxOf(wire, turned(90, x))},
          {"blob", boxOf({0.3, 0.25, 0.2}, turned(20, Vector3d(1, 1, 1)), {0.05, 0, -0.3})},
          {"cube", boxOf({0.45, 0.45, 0.45})},
          {"tall box", boxOf({0.3, 0.2, 1.5}, turned(35, Vector3d::UnitZ()))},
          {"three points", {{0.1, 0, 0}, {0.31, 0.07, 0.02}, {-0.2, 0.4, 0.33}}},
          {"few points", boxOf(plane, turned(10, x), {0, 0, 0.2}, 5)}};
}

TEST(FeatureValues, OfKnownShapesAreWhatEigenFinds) {
  for (const auto& [name, points] : namedShapes()) {
    for (const VoxelIndex& voxel : {VoxelIndex{0, 0, 0}, VoxelIndex{9876543, -9123456, 4321}}) {
      const Volume volume(points, voxel);
      for (const Quantity quantity : quantitiesOfVolumes()) {
        const double margin = tolerance(quantity, volume.shape);
        ASSERT_NEAR(valueOf(quantity, volume), expectedValue(quantity, volume.shape), margin)
            << nameOf(quantity) << " of a " << name;
      }
    }
  }
}

TEST(FeatureValues, MarginsOfTheComparisonAreNarrow) {
  // Where they were wide, the comparison above would say nothing.
  const Volume blob(namedShapes()["blob"]);
  for (const Quantity quantity : quantitiesOfVolumes()) {
    EXPECT_LT(tolerance(quantity, blob.shape), 2e-5) << nameOf(quantity);
  }
}

TEST(FeatureValues, MeanWhatTheirNamesSay) {
  const auto shapes = namedShapes();
  const auto value = [&](Quantity quantity, const char* name) {
    return valueOf(quantity, Volume(shapes.at(name)));
  };
  const double degree = kPi / 180.0;
  EXPECT_NEAR(value(Quantity::kNormalAngle, "level plane"), 0.0, degree);
  EXPECT_NEAR(value(Quantity::kNormalAngle, "plane at 30 degrees"), 30 * degree, degree);
  EXPECT_NEAR(value(Quantity::kNormalAngle, "wall"), 90 * degree, degree);
  EXPECT_NEAR(value(Quantity::kTangentAngle, "pole"), 0.0, degree);
  EXPECT_NEAR(value(Quantity::kTangentAngle, "line at 40 degrees"), 40 * degree, degree);
  EXPECT_NEAR(value(Quantity::kTangentAngle, "level wire"), 90 * degree, degree);
  EXPECT_NEAR(value(Quantity::kSpreadAngle, "level plane"), 0.0, 2 * degree);
  EXPECT_NEAR(value(Quantity::kSpreadAngle, "pole"), 90 * degree, 2 * degree);
  EXPECT_NEAR(value(Quantity::kSpreadAngle, "cube"), 45 * degree, 2 * degree);
  EXPECT_LT(value(Quantity::kHorizontalRatio, "wall"), 0.05);
  EXPECT_GT(value(Quantity::kHorizontalRatio, "cube"), 0.9);
  EXPECT_LT(value(Quantity::kScatterRatio, "level wire"), 0.02);
  EXPECT_GT(value(Quantity::kScatterRatio, "cube"), 0.9);
  EXPECT_LT(value(Quantity::kThicknessRatio, "plane at 30 degrees"), 0.05);
  EXPECT_GT(value(Quantity::kThicknessRatio, "pole"), 0.7);
  EXPECT_GT(value(Quantity::kLevelSurface, "level plane"), 0.99);
  EXPECT_LT(value(Quantity::kLevelSurface, "wall"), 0.05);
  EXPECT_GT(value(Quantity::kUprightSurface, "wall"), 0.99);
  EXPECT_GT(value(Quantity::kLevelLinear, "level wire"), 0.99);
  EXPECT_GT(value(Quantity::kUprightLinear, "pole"), 0.99);
  EXPECT_LT(value(Quantity::kUprightLinear, "level wire"), 0.01);
  // Evenly spread over a length of 2 a, the standard deviation is a / sqrt(3).
  EXPECT_NEAR(value(Quantity::kVerticalDeviation, "pole"), 0.42 / std::sqrt(3.0), 0.02);
  EXPECT_NEAR(value(Quantity::kHorizontalMajor, "tall box"), 0.3 / std::sqrt(3.0), 0.02);
  EXPECT_NEAR(value(Quantity::kHorizontalMinor, "tall box"), 0.2 / std::sqrt(3.0), 0.02);
  EXPECT_NEAR(value(Quantity::kScatter, "tall box"), 0.2 * 0.2 / 3.0, 0.002);
  EXPECT_NEAR(value(Quantity::kMeanOffset, "blob"), std::hypot(0.05, 0.3), 0.02);
  EXPECT_NEAR(value(Quantity::kLogPoints, "cube"), std::log(400.0), 1e-6);
}

TEST(FeatureValues, AreFiniteWhateverIsInTheVolume) {
  TestRandom random(3);
  test::VolumeMaker maker(&random);
  for (int kind = 0; kind < test::kVolumeKinds; ++kind) {
    for (int round = 0; round < 20; ++round) {
      std::vector<Moments> sums;
      std::vector<VoxelIndex> voxels;
      const auto count = static_cast<int>(random.integer(0, kSize));
      for (int i = 0; i < count; ++i) {
        const test::SupportVolume volume = maker.make(static_cast<test::VolumeKind>(kind));
        sums.push_back(volume.sum);
        voxels.push_back(volume.voxel);
      }
      SaliencyBlock block;
      saliencyOfBlock(sums.data(), voxels.data(), count, kStep_m, &block);
      for (const Quantity quantity : quantitiesOfVolumes()) {
        float values[kSize];
        std::fill_n(values, kSize, std::nanf(""));
        featureValues(quantity, block, values);
        for (const float value : values) {
          ASSERT_TRUE(std::isfinite(value)) << nameOf(quantity) << " of kind " << kind;
        }
      }
    }
  }
}

TEST(FeatureValues, DoNotDependOnTheSignOfADirection) {
  SaliencyBlock block = blockOf(Volume(namedShapes()["line at 40 degrees"]));
  for (const Quantity quantity : quantitiesOfVolumes()) {
    float before[kSize];
    float after[kSize];
    featureValues(quantity, block, before);
    SaliencyBlock opposite = block;
    for (int axis = 0; axis < 3; ++axis) {
      opposite.normal[axis][0] = -block.normal[axis][0];
      opposite.tangent[axis][0] = -block.tangent[axis][0];
    }
    featureValues(quantity, opposite, after);
    EXPECT_EQ(before[0], after[0]) << nameOf(quantity);
  }
}

TEST(FeatureValues, AVerticalUnitVectorLongerByRoundingHasAngleZero) {
  SaliencyBlock block = blockOf(Volume(namedShapes()["blob"]));
  for (int axis = 0; axis < 3; ++axis) {
    block.normal[axis][0] = axis == 2 ? 1.0F + 2e-7F : 0.0F;
    block.tangent[axis][0] = axis == 2 ? -1.0F - 2e-7F : 0.0F;
  }
  for (const Quantity quantity : {Quantity::kNormalAngle, Quantity::kTangentAngle}) {
    float values[kSize];
    featureValues(quantity, block, values);
    EXPECT_EQ(values[0], 0.0F);
  }
}

/// A quantity of columns from one number.
double valueOf(Quantity quantity, int32_t number, double voxel_size_m) {
  int32_t numbers[kSize] = {};
  numbers[kSize - 1] = number;
  float values[kSize];
  columnFeatureValues(quantity, numbers, voxel_size_m, values);
  return values[kSize - 1];
}

TEST(ColumnFeatureValues, FollowHeightsInMetres) {
  for (const double voxel_m : {0.01, 0.1, 0.25, 2.0}) {
    for (const int32_t voxels : {0, 1, 2, 7, 30, 64, 1000, 5000}) {
      const double height_m = voxel_m * voxels;
      for (const Quantity quantity : {Quantity::kLogHeight, Quantity::kLogGroundHeight}) {
        EXPECT_NEAR(valueOf(quantity, voxels, voxel_m), std::log(height_m + 0.1), 2e-6);
      }
      EXPECT_NEAR(valueOf(Quantity::kSqrtHeight, voxels, voxel_m), std::sqrt(height_m + 0.01),
                  1e-6 * std::sqrt(height_m + 1.0));
    }
  }
}

TEST(ColumnFeatureValues, BelowTheGroundIsOnIt) {
  // A voxel can lie below the ground that an opening finds.
  for (const Quantity quantity :
       {Quantity::kLogHeight, Quantity::kSqrtHeight, Quantity::kLogGroundHeight}) {
    EXPECT_EQ(valueOf(quantity, -1, 0.1), valueOf(quantity, 0, 0.1));
    EXPECT_EQ(valueOf(quantity, -1000000, 0.1), valueOf(quantity, 0, 0.1));
  }
}

TEST(ColumnFeatureValues, FillIsVoxelsPerColumn) {
  for (const int32_t units : {kFillUnit, kFillUnit + 1, 3 * kFillUnit / 2, 64 * kFillUnit}) {
    EXPECT_NEAR(valueOf(Quantity::kLogFill, units, 0.1),
                std::log(static_cast<double>(units) / kFillUnit), 1e-6);
  }
}

TEST(ColumnFeatureValues, AreFiniteForAnyNumber) {
  for (const int32_t number : {INT32_MIN, -1, 0, 1, 1 << 20, INT32_MAX}) {
    for (const QuantityInfo& info : allQuantities()) {
      if (!isOfColumns(info.quantity)) continue;
      EXPECT_TRUE(std::isfinite(valueOf(info.quantity, number, 2.0))) << info.name << " " << number;
    }
  }
}

}  // namespace
}  // namespace ladar_perception
