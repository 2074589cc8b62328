// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ladar_perception/register/surface_points.h"
#include "register_scenes.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;

const Vector3d kSensor(0.0, 0.0, 1.5);

std::vector<Vector3d> roomPoints(std::size_t count, double noise_m) {
  return test::pointsOn(test::roomFaces(), count, noise_m, 1).positions_m;
}

TEST(PlausibleReturns, DropsWhatIsNoMeasurement) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<Vector3d> points = {{1.0, 0.0, 0.0}, {nan, 0.0, 0.0}, {0.0, 0.2, 0.0},
                                        {0.0, inf, 0.0}, {0.0, 0.0, 0.6}, {0.0, 0.0, 0.0}};
  EXPECT_EQ(plausibleReturns(points, Vector3d::Zero()), (std::vector<uint32_t>{0, 4}));
  EXPECT_EQ(plausibleReturns(points, Vector3d(1.0, 0.0, 0.0)), (std::vector<uint32_t>{2, 4, 5}));
  EXPECT_TRUE(plausibleReturns({}, Vector3d::Zero()).empty());
}

TEST(PlausibleReturns, DropsAShellOfMaximumRange) {
  std::vector<Vector3d> points = roomPoints(20000, 0.01);
  const std::size_t room = plausibleReturns(points, kSensor).size();
  test::TestRandom random(2);
  for (int i = 0; i < 300; ++i) {
    points.emplace_back(kSensor + random.real(32.7, 32.8) * random.normal3().normalized());
  }
  EXPECT_EQ(plausibleReturns(points, kSensor).size(), room);
  EXPECT_GT(room, 19900U);
}

TEST(PlausibleReturns, KeepsFarSurfaces) {
  // Part of a cylinder about the sensor: all of it is at the maximum range.
  std::vector<Vector3d> points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(20.0 * std::cos(i), 20.0 * std::sin(i), 0.0);
  EXPECT_EQ(plausibleReturns(points, Vector3d::Zero()).size(), points.size());
  // A few returns from far away.
  std::vector<Vector3d> room = roomPoints(20000, 0.01);
  room.emplace_back(60.0, 0.0, 0.0);
  room.emplace_back(0.0, 59.9, 0.0);
  EXPECT_EQ(plausibleReturns(room, Vector3d(0.0, 0.0, -3.0)).size(), room.size());
}

TEST(SurfaceCentroids, AreAboutAsManyAsWanted) {
  const std::vector<Vector3d> points = roomPoints(60000, 0.01);
  for (const int count : {1000, 5000, 20000}) {
    const auto size = static_cast<double>(surfaceCentroids(points, kSensor, count).size());
    EXPECT_GT(size, 0.9 * count);
    EXPECT_LT(size, 1.1 * count);
  }
  EXPECT_EQ(surfaceCentroids(points, kSensor, 100000).size(), points.size());
}

TEST(SurfaceCentroids, HaveNormalsTowardsTheSensor) {
  const OrientedPoints surface = surfaceCentroids(roomPoints(60000, 0.005), kSensor, 20000);
  std::size_t good = 0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const Eigen::Vector3f& n = surface.normals[i];
    ASSERT_NEAR(n.norm(), 1.0F, 1e-5F);
    ASSERT_GE(n.dot((kSensor - surface.positions_m[i]).cast<float>()), -1e-4F);
    good += n.cwiseAbs().maxCoeff() > 0.97F ? 1 : 0;  // all faces are along the axes
  }
  EXPECT_GT(static_cast<double>(good), 0.9 * static_cast<double>(surface.size()));
}

TEST(SurfaceCentroids, AreTheSameFarFromTheOrigin) {
  std::vector<Vector3d> points = roomPoints(30000, 0.005);
  const OrientedPoints here = surfaceCentroids(points, kSensor, 30000);
  const Vector3d far(1e6, -2e6, 100.0);
  for (Vector3d& p : points) p += far;
  const OrientedPoints there = surfaceCentroids(points, kSensor + far, 30000);
  ASSERT_EQ(there.size(), here.size());
  std::size_t alike = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    alike += (here.normals[i] - there.normals[i]).norm() < 1e-3F ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(alike), 0.999 * static_cast<double>(here.size()));
}

TEST(SurfaceCentroids, HaveNoNormalWhereThereIsNoSurface) {
  for (const std::size_t count : {0U, 1U, 2U, 3U, 20U}) {
    std::vector<Vector3d> line;
    for (std::size_t i = 0; i < count; ++i) line.emplace_back(0.1 * static_cast<double>(i), 1, 1);
    const OrientedPoints surface = surfaceCentroids(line, kSensor);
    ASSERT_EQ(surface.size(), count);
    for (const Eigen::Vector3f& n : surface.normals) EXPECT_EQ(n.norm(), 0.0F) << count;
  }
}

TEST(WithNormalsOf, TakesThoseOfTheNearestPoint) {
  OrientedPoints surface;
  surface.positions_m = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  surface.normals = {Eigen::Vector3f::UnitZ(), Eigen::Vector3f::UnitX()};
  const OrientedPoints points = withNormalsOf(surface, {{0.9, 0.3, 0.0}, {-5.0, 0.0, 0.0}});
  EXPECT_EQ(points.normals[0], Eigen::Vector3f(Eigen::Vector3f::UnitX()));
  EXPECT_EQ(points.normals[1], Eigen::Vector3f(Eigen::Vector3f::UnitZ()));
  EXPECT_EQ(withNormalsOf({}, {{1.0, 2.0, 3.0}}).normals[0].norm(), 0.0F);
}

}  // namespace
}  // namespace ladar_perception
