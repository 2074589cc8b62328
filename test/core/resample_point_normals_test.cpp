// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "crust_clouds.h"
#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/point_normals.h"
#include "ladar_perception/resample/surface_fit.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::GriddedCloud;
using test::TestRandom;

PointNormals normalsOf(const GriddedCloud& gridded, const Vector3f& sensor, int threads = 1) {
  ThreadPool pool(threads);
  return pointNormals(gridded.points, gridded.pyramid, sensor, &pool);
}

/// Points of the voxel of a level that holds `key` and of the 26 around it.
Cloud around(const GridPoints& points, uint64_t key, int level) {
  const auto near = [](uint32_t a, uint32_t b) { return a - b + 1 <= 2; };
  const uint64_t own = key >> 3 * level;
  Cloud cloud;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const uint64_t other = points.keys[i] >> 3 * level;
    if (near(morton::x(own), morton::x(other)) && near(morton::y(own), morton::y(other)) &&
        near(morton::z(own), morton::z(other))) {
      cloud.push_back(points.positions[i].cast<double>());
    }
  }
  return cloud;
}

struct DirectNormal {
  Vector3d normal = Vector3d::Zero();
  double certainty = 0;  ///< how much less the plane's thickness is than its width, 0 to 1
};

DirectNormal directNormal(const GridPoints& points, std::size_t point, const Vector3d& sensor) {
  DirectNormal result;
  for (int level = 0; level <= kBridgeLevels; ++level) {
    const Cloud near = around(points, points.keys[point], level);
    if (static_cast<float>(near.size()) < kPlanePoints) continue;
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : near) mean += p / static_cast<double>(near.size());
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Vector3d& p : near) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
    result.normal = solver.eigenvectors().col(0);
    if (result.normal.dot(sensor - mean) < 0.0) result.normal = -result.normal;
    result.certainty =
        (solver.eigenvalues()[1] - solver.eigenvalues()[0]) / solver.eigenvalues()[2];
    return result;
  }
  return result;
}

TEST(PointNormals, AreThoseOfTheFirstVoxelsThatHoldEnough) {
  TestRandom random(1);
  // From dense to points that no level holds enough of.
  Cloud cloud = test::patch({{0, 0, 0}, {0, 1, 2}}, 12, 12, 700, 0.1, &random);
  cloud = test::joined(cloud, test::ball({0, 0, 30}, 20, 300, &random));
  cloud = test::joined(cloud, {{300, 0, 0}, {330, 0, 0}, {330.5, 0, 0}});
  const GriddedCloud gridded(cloud);
  const Vector3f sensor(5, -40, 60);
  const PointNormals result = normalsOf(gridded, sensor);
  ASSERT_EQ(result.normals.size(), cloud.size());
  std::size_t none = 0;
  std::size_t compared = 0;
  for (std::size_t i = 0; i < gridded.points.size(); ++i) {
    const Vector3d normal = result.normals[gridded.points.sources[i]].cast<double>();
    const DirectNormal direct = directNormal(gridded.points, i, sensor.cast<double>());
    if (direct.normal.isZero()) {
      ASSERT_TRUE(normal.isZero());
      ++none;
      continue;
    }
    ASSERT_NEAR(normal.norm(), 1.0, 1e-4);
    if (direct.certainty < 0.01) continue;
    ++compared;
    ASSERT_LT(normal.cross(direct.normal).norm(), 2e-4 / direct.certainty) << i;
  }
  EXPECT_GE(none, 3u);
  EXPECT_GT(compared, 900u);
}

TEST(PointNormals, OfAPlanePointTowardsTheSensorOnEitherSide) {
  TestRandom random(2);
  for (const double tilt : {0.0, 37.0, 54.7, 90.0}) {
    const test::PlaneFrame plane({4, 5, 6}, test::tilted(tilt, 70.0));
    const Cloud cloud = test::patch(plane, 30, 30, 8000, 0.01, &random);
    for (const double side : {1.0, -1.0}) {
      const Vector3d sensor = plane.center + side * 40.0 * plane.normal;
      const PointNormals result = normalsOf(GriddedCloud(cloud), sensor.cast<float>());
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        ASSERT_GT(side * result.normals[i].cast<double>().dot(plane.normal), 0.999);
        ASSERT_LT(result.variation[i], 1e-3F);
      }
    }
  }
}

TEST(PointNormals, OfASphereAreItsRadii) {
  TestRandom random(3);
  const Cloud cloud = test::sphere({1, 2, 3}, 20, 30000, 0.0, &random);
  const PointNormals result = normalsOf(GriddedCloud(cloud), {1, 2, 3});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d inwards = (Vector3d(1, 2, 3) - cloud[i]).normalized();
    ASSERT_GT(result.normals[i].cast<double>().dot(inwards), 0.98);
  }
}

TEST(PointNormals, VaryAtAnEdgeAndNotBesideIt) {
  TestRandom random(4);
  const Cloud floor = test::patch({{0, 0, 0.5}, {0, 0, 1}}, 40, 40, 12000, 0.0, &random);
  const Cloud wall = test::patch({{20.5, 0, 20}, {1, 0, 0}}, 40, 40, 12000, 0.0, &random);
  const Cloud cloud = test::joined(floor, wall);
  const PointNormals result = normalsOf(GriddedCloud(cloud), {-50, 0, 80});
  double at_edge = 0.0;
  int at_edge_count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double from_edge = std::max(20.5 - cloud[i].x(), cloud[i].z() - 0.5);
    if (from_edge > 4.0) {
      ASSERT_LT(result.variation[i], 1e-3F);
    }
    if (from_edge > 2.0) continue;
    at_edge += result.variation[i];
    ++at_edge_count;
  }
  ASSERT_GT(at_edge_count, 100);
  // Neighbours on the other side are turned by up to 90 degrees, 2.5 rad^2.
  EXPECT_GT(at_edge / at_edge_count, 0.1);
  EXPECT_LT(at_edge / at_edge_count, 2.5);
}

TEST(PointNormals, VariationGrowsWithCurvature) {
  TestRandom random(5);
  const auto meanVariation = [&](double radius) {
    const auto count = static_cast<std::size_t>(40.0 * radius * radius);
    const PointNormals result =
        normalsOf(GriddedCloud(test::sphere({0, 0, 0}, radius, count, 0.0, &random)), {0, 0, 0});
    double sum = 0.0;
    for (const float variation : result.variation) sum += variation;
    return sum / static_cast<double>(count);
  };
  const double tight = meanVariation(6.0);
  const double wide = meanVariation(18.0);
  EXPECT_GT(tight, 4.0 * wide);
  // Neighbours are 1 to 1.7 cells away, on the sphere as many radii of an angle.
  EXPECT_NEAR(std::sqrt(wide) * 18.0, 1.35, 0.35);
}

TEST(PointNormals, AreZeroWhereThereAreTooFewPoints) {
  EXPECT_TRUE(normalsOf(GriddedCloud(Cloud()), {0, 0, 0}).normals.empty());
  for (std::size_t count = 1; count < static_cast<std::size_t>(kPlanePoints); ++count) {
    const PointNormals result = normalsOf(GriddedCloud(Cloud(count, Vector3d(1, 1, 1))), {0, 0, 9});
    ASSERT_EQ(result.normals.size(), count);
    ASSERT_EQ(result.variation.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(result.normals[i].isZero());
      EXPECT_EQ(result.variation[i], 0.0F);
    }
  }
}

TEST(PointNormals, OfLinesAndEqualPointsAreUnitVectors) {
  TestRandom random(6);
  const Vector3d along = Vector3d(2, -1, 2).normalized();
  const Cloud line = test::segment(-10 * along, 10 * along, 400, 0.0, &random);
  const PointNormals of_line = normalsOf(GriddedCloud(line), {0, 0, 50});
  for (const Vector3f& normal : of_line.normals) {
    ASSERT_NEAR(normal.norm(), 1.0F, 1e-4F);
    ASSERT_NEAR(normal.cast<double>().dot(along), 0.0, 0.02);
  }
  const PointNormals of_copies = normalsOf(GriddedCloud(Cloud(20, Vector3d(1, 1, 1))), {0, 0, 50});
  for (const Vector3f& normal : of_copies.normals) ASSERT_NEAR(normal.norm(), 1.0F, 1e-4F);
}

TEST(PointNormals, AreTheSameForAnyNumberOfThreads) {
  TestRandom random(7);
  const Cloud cloud = test::joined(test::patch({{0, 0, 0}, {1, 2, 3}}, 90, 90, 20000, 0.2, &random),
                                   test::ball({0, 0, 30}, 30, 5000, &random));
  const GriddedCloud gridded(cloud);
  const PointNormals one = normalsOf(gridded, {0, 0, 100});
  const PointNormals three = normalsOf(gridded, {0, 0, 100}, 3);
  EXPECT_TRUE(one.normals == three.normals);
  EXPECT_EQ(one.variation, three.variation);
}

}  // namespace
}  // namespace ladar_perception
