// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "crust_clouds.h"
#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/surface_fit.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::GriddedCloud;
using test::TestRandom;

const Vector3f kAbove(0, 0, 1000);

std::vector<SurfaceFit> fitted(const GriddedCloud& gridded, const Vector3f& sensor = kAbove,
                               int threads = 1) {
  ThreadPool pool(threads);
  return fitSurface(gridded.pyramid, 0, {}, sensor, &pool);
}

/// What holds for all pieces of fits from level 0.
void expectSound(const std::vector<SurfaceFit>& pieces, const Vector3f& sensor) {
  for (const SurfaceFit& piece : pieces) {
    ASSERT_TRUE(piece.center.allFinite());
    ASSERT_NEAR(piece.normal.norm(), 1.0F, 1e-4F);
    ASSERT_NEAR(piece.major.norm(), 1.0F, 1e-4F);
    ASSERT_NEAR(piece.normal.dot(piece.major), 0.0F, 1e-3F);
    const Vector3f to_sensor = (sensor - piece.center).normalized();
    ASSERT_GE(piece.normal.dot(to_sensor), -1e-4F);
    ASSERT_GT(piece.semi_minor, 0.0F);
    ASSERT_GE(piece.semi_major, piece.semi_minor);
    ASSERT_GT(piece.weight, 0.0F);
    ASSERT_LE(piece.level, kBridgeLevels);
    ASSERT_GT(piece.trust, 0.0F);
    ASSERT_LE(piece.trust, 64.0F);
    // A piece covers about its voxel, not much more.
    ASSERT_LE(piece.semi_major, 2.0F * static_cast<float>(1 << piece.level));
  }
}

bool same(const SurfaceFit& a, const SurfaceFit& b) {
  return a.center == b.center && a.normal == b.normal && a.major == b.major &&
         a.semi_major == b.semi_major && a.semi_minor == b.semi_minor && a.trust == b.trust &&
         a.weight == b.weight;
}

PointSums sumsOf(const Cloud& cloud) {
  PointSums sums;
  for (const Vector3d& p : cloud) sums.add(p.cast<float>(), 1.0F);
  return sums;
}

TEST(FitPlane, AgreesWithEigensSolver) {
  TestRandom random(1);
  for (int round = 0; round < 500; ++round) {
    // Of all shapes from balls to needles and leaves.
    const Vector3d scales(std::exp(random.real(-4, 1)), std::exp(random.real(-4, 1)),
                          std::exp(random.real(-4, 1)));
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(random.real(0, 3), random.normal3().normalized()));
    const Vector3d shift = random.normal3();
    Cloud cloud;
    for (int i = 0; i < 30; ++i) {
      cloud.push_back(shift + turn * Vector3d(scales.cwiseProduct(random.normal3())));
    }
    const PlaneFit fit = fitPlane(sumsOf(cloud));
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : cloud) mean += p / 30.0;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const Vector3d& p : cloud) covariance += (p - mean) * (p - mean).transpose() / 30.0;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    const Vector3d values = solver.eigenvalues();
    // Squares about another centre lose what their size has over that of the spread.
    const double lost = 1e-6 * (values[2] + shift.squaredNorm());
    ASSERT_LT((fit.mean.cast<double>() - mean).norm(), 1e-5 * (1.0 + mean.norm()));
    ASSERT_NEAR(fit.l0, values[0], lost);
    ASSERT_NEAR(fit.l1, values[1], lost);
    ASSERT_NEAR(fit.l2, values[2], lost);
    const auto sine = [](const Vector3f& a, const Vector3d& b) {
      return a.cast<double>().cross(b).norm();
    };
    ASSERT_LT(sine(fit.normal, solver.eigenvectors().col(0)), 3.0 * lost / (values[1] - values[0]));
    ASSERT_LT(sine(fit.major, solver.eigenvectors().col(2)), 3.0 * lost / (values[2] - values[1]));
  }
}

TEST(FitPlane, OfPointsOnAPointALineAndAPlane) {
  const PlaneFit point = fitPlane(sumsOf({{1, 2, 3}}));
  EXPECT_EQ(point.mean, Vector3f(1, 2, 3));
  EXPECT_NEAR(point.l2, 0.0F, 1e-5F);
  EXPECT_NEAR(point.normal.norm(), 1.0F, 1e-5F);
  EXPECT_NEAR(point.major.norm(), 1.0F, 1e-5F);
  const PlaneFit line = fitPlane(sumsOf({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}));
  EXPECT_NEAR(line.l1, 0.0F, 1e-6F);
  EXPECT_NEAR(std::abs(line.major.dot(Vector3f(1, 1, 0).normalized())), 1.0F, 1e-5F);
  EXPECT_NEAR(line.normal.dot(line.major), 0.0F, 1e-5F);
  const PlaneFit plane = fitPlane(sumsOf({{0, 0, 2}, {1, 0, 2}, {0, 3, 2}}));
  EXPECT_NEAR(plane.l0, 0.0F, 1e-5F);
  EXPECT_NEAR(std::abs(plane.normal.z()), 1.0F, 1e-5F);
  EXPECT_NEAR(plane.mean.z(), 2.0F, 1e-6F);
}

TEST(SumNeighborhoods, AreThoseOfTheTwentySevenVoxels) {
  TestRandom random(2);
  Cloud cloud;
  for (int i = 0; i < 4000; ++i) cloud.push_back(5.0 * random.normal3());
  const GriddedCloud gridded(cloud);
  ThreadPool pool(1);
  for (int number = 0; number <= kBridgeLevels; ++number) {
    const VoxelLevel& level = gridded.pyramid.level(number);
    std::vector<uint8_t> wanted(level.grid.size());
    for (uint8_t& flag : wanted) flag = random.integer(0, 1) != 0 ? 1 : 0;
    const std::vector<PointSums> sums = sumNeighborhoods(level, number, false, &wanted, &pool);
    ASSERT_EQ(sums.size(), level.grid.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (wanted[i] == 0) continue;
      const uint64_t own = level.grid.keys()[i];
      const Vector3f center = brickCenter(own >> 6, number);
      PointSums direct;
      for (std::size_t p = 0; p < gridded.points.size(); ++p) {
        const uint64_t key = gridded.points.keys[p] >> 3 * number;
        const auto near = [](uint32_t a, uint32_t b) { return a - b + 1 <= 2; };
        if (near(morton::x(key), morton::x(own)) && near(morton::y(key), morton::y(own)) &&
            near(morton::z(key), morton::z(own))) {
          direct.add(gridded.points.positions[p] - center, 1.0F);
        }
      }
      const auto edge = static_cast<float>(1 << number);
      const float unit = 1e-4F * direct.count * edge * edge;
      ASSERT_EQ(sums[i].count, direct.count);
      ASSERT_EQ(sums[i].weight, direct.weight);
      ASSERT_NEAR(sums[i].x, direct.x, unit);
      ASSERT_NEAR(sums[i].y, direct.y, unit);
      ASSERT_NEAR(sums[i].z, direct.z, unit);
      ASSERT_NEAR(sums[i].xx, direct.xx, 4 * unit);
      ASSERT_NEAR(sums[i].xy, direct.xy, 4 * unit);
      ASSERT_NEAR(sums[i].xz, direct.xz, 4 * unit);
      ASSERT_NEAR(sums[i].yy, direct.yy, 4 * unit);
      ASSERT_NEAR(sums[i].yz, direct.yz, 4 * unit);
      ASSERT_NEAR(sums[i].zz, direct.zz, 4 * unit);
    }
  }
}

TEST(FitSurface, OfADensePlaneLiesOnIt) {
  TestRandom random(3);
  for (const double tilt : {0.0, 30.0, 54.7, 90.0}) {
    const test::PlaneFrame plane({1, 2, 3}, test::tilted(tilt, 20.0));
    const GriddedCloud gridded(test::patch(plane, 40, 40, 10000, 0.0, &random));
    const Vector3f sensor = (plane.center + 100.0 * plane.normal).cast<float>();
    const std::vector<SurfaceFit> pieces = fitted(gridded, sensor);
    ASSERT_GT(pieces.size(), 400u);
    expectSound(pieces, sensor);
    for (const SurfaceFit& piece : pieces) {
      const Vector3d center = piece.center.cast<double>();
      ASSERT_NEAR(plane.height(center), 0.0, 1e-3);
      // Beyond, a few points at the rim may be a line, which faces the sensor.
      if ((center - plane.center).norm() > 18.0) continue;
      ASSERT_GT(piece.normal.cast<double>().dot(plane.normal), 0.9999);
    }
  }
}

TEST(FitSurface, PiecesOfAPlaneCoverIt) {
  TestRandom random(4);
  const GriddedCloud gridded(test::patch({}, 30, 30, 8000, 0.1, &random));
  const std::vector<SurfaceFit> pieces = fitted(gridded);
  for (int y = -14; y < 14; ++y) {
    for (int x = -14; x < 14; ++x) {
      const Vector3f place(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, 0.0F);
      const bool covered = std::any_of(pieces.begin(), pieces.end(), [&](const SurfaceFit& piece) {
        const Vector3f d = place - piece.center;
        const Vector3f minor = piece.normal.cross(piece.major);
        const float s = d.dot(piece.major) / piece.semi_major;
        const float t = d.dot(minor) / piece.semi_minor;
        return s * s + t * t < 1.0F;
      });
      ASSERT_TRUE(covered) << x << " " << y;
    }
  }
}

TEST(FitSurface, OnlyWantedVoxelsGetPieces) {
  TestRandom random(5);
  const GriddedCloud gridded(test::patch({}, 40, 40, 12000, 0.05, &random));
  const SparseGrid& grid = gridded.pyramid.level(0).grid;
  std::vector<uint8_t> wanted(grid.size(), 0);
  ThreadPool pool(1);
  EXPECT_TRUE(fitSurface(gridded.pyramid, 0, wanted, kAbove, &pool).empty());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i] = cubeCenter(grid.keys()[i], 0).x() < 0.0F ? 1 : 0;
  }
  const std::vector<SurfaceFit> pieces = fitSurface(gridded.pyramid, 0, wanted, kAbove, &pool);
  ASSERT_GT(pieces.size(), 200u);
  // The points of a voxel and its neighbours have their mean within these.
  for (const SurfaceFit& piece : pieces) ASSERT_LT(piece.center.x(), 1.0F);
}

TEST(FitSurface, OfLargerVoxels) {
  TestRandom random(6);
  const GriddedCloud gridded(test::patch({}, 60, 60, 6000, 0.1, &random), test::gridFrame(1.0), {},
                             kBridgeLevels + 3);
  ThreadPool pool(1);
  const std::vector<SurfaceFit> pieces = fitSurface(gridded.pyramid, 2, {}, kAbove, &pool);
  ASSERT_GT(pieces.size(), 50u);
  for (const SurfaceFit& piece : pieces) {
    EXPECT_EQ(piece.level, 2);
    EXPECT_LE(piece.semi_major, 8.0F);
    EXPECT_GT(piece.semi_minor, 2.0F);
    EXPECT_GT(piece.normal.z(), 0.99F);
  }
}

TEST(FitSurface, MorePointsAreTrustedMoreAndLargerVoxelsLess) {
  TestRandom random(12);
  // Nine cells of points around a voxel: 9, 36 and far more than tell more.
  for (const auto& [density, trust] : {std::pair(1.0, 9.0), {4.0, 36.0}, {400.0, 64.0}}) {
    double sum = 0.0;
    double pieces = 0.0;
    const auto count = static_cast<std::size_t>(density * 40 * 40);
    for (const SurfaceFit& piece : fitted(GriddedCloud(test::patch(
             test::PlaneFrame({0, 0, 0.5}, {0, 0, 1}), 40, 40, count, 0.05, &random)))) {
      if (piece.level > 0 || piece.center.head<2>().cwiseAbs().maxCoeff() > 17.0F) continue;
      sum += piece.trust;
      pieces += 1.0;
    }
    EXPECT_NEAR(sum / pieces / trust, 1.0, 0.2) << density;
  }
  // Four columns of 256 cells, 64 points: of a voxel sixteen cells wide.
  const std::vector<SurfaceFit> sparse = fitted(GriddedCloud(
      test::patch(test::PlaneFrame({0, 0, 0.5}, {0, 0, 1}), 200, 200, 1000, 0.0, &random)));
  for (const SurfaceFit& piece : sparse) {
    if (piece.level == kBridgeLevels) {
      ASSERT_LE(piece.trust, 64.0F / 256.0F);
    }
  }
}

TEST(FitSurface, WeightsAreMeansOfPoints) {
  TestRandom random(7);
  Cloud cloud = test::patch({}, 40, 40, 10000, 0.0, &random);
  std::vector<float> weights;
  for (const Vector3d& p : cloud) weights.push_back(p.x() < 0.0 ? 0.25F : 1.0F);
  const std::vector<SurfaceFit> pieces = fitted(GriddedCloud(cloud, test::gridFrame(1.0), weights));
  for (const SurfaceFit& piece : pieces) {
    ASSERT_GE(piece.weight, 0.25F);
    ASSERT_LE(piece.weight, 1.0F);
    if (piece.center.x() < -2.0F) {
      ASSERT_EQ(piece.weight, 0.25F);
    }
    if (piece.center.x() > 2.0F) {
      ASSERT_EQ(piece.weight, 1.0F);
    }
  }
}

TEST(FitSurface, AVoxelLeftAloneFacesTheSensor) {
  const GriddedCloud gridded({{10.2, 20.3, 5.4}});
  const Vector3f sensor(-30, 40, 12);
  const std::vector<SurfaceFit> pieces = fitted(gridded, sensor);
  ASSERT_EQ(pieces.size(), 1u);
  expectSound(pieces, sensor);
  EXPECT_LT((pieces[0].center - Vector3f(10.2F, 20.3F, 5.4F)).norm(), 1e-4F);
  EXPECT_GT(pieces[0].normal.dot((sensor - pieces[0].center).normalized()), 0.9999F);
  EXPECT_EQ(pieces[0].trust, 1.0F);
  EXPECT_EQ(pieces[0].level, 0);
  EXPECT_LE(pieces[0].semi_major, 1.0F);
}

TEST(FitSurface, TheSensorMayBeWhereThePointIs) {
  const std::vector<SurfaceFit> pieces =
      fitted(GriddedCloud({{1.5, 2.5, 3.5}}), {1.5F, 2.5F, 3.5F});
  ASSERT_EQ(pieces.size(), 1u);
  expectSound(pieces, {1.5F, 2.5F, 3.5F});
}

TEST(FitSurface, FewPointsKeepTheirPlaces) {
  EXPECT_TRUE(fitted(GriddedCloud(Cloud())).empty());
  for (std::size_t count = 1; count <= 3; ++count) {
    Cloud cloud;
    for (std::size_t i = 0; i < count; ++i) cloud.emplace_back(3.0 * double(i) + 0.5, 0.5, 0.5);
    const std::vector<SurfaceFit> pieces = fitted(GriddedCloud(cloud));
    ASSERT_EQ(pieces.size(), count);
    expectSound(pieces, kAbove);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(pieces[i].center, Vector3f(3.0F * static_cast<float>(i) + 0.5F, 0.5F, 0.5F));
    }
  }
}

TEST(FitSurface, DuplicatesAreSmallPiecesWhereTheyAre) {
  for (const std::size_t count : {2u, 7u, 8u, 500u}) {
    const Vector3d place(7.5, 8.5, 9.5);
    const std::vector<SurfaceFit> pieces = fitted(GriddedCloud(Cloud(count, place)));
    ASSERT_GE(pieces.size(), 1u);
    ASSERT_LE(pieces.size(), 1u + kBridgeLevels);  // by rounding a line, a plane one level up
    expectSound(pieces, kAbove);
    for (const SurfaceFit& piece : pieces) {
      EXPECT_LT((piece.center.cast<double>() - place).norm(), 1e-3);
      EXPECT_LE(piece.semi_major, 1.0F);
    }
  }
}

/// Pieces of a line: on it, along it, with the normal across it that is nearest to
/// `wanted(center)`.
void expectLine(const Vector3d& direction, const std::function<Vector3d(const Vector3d&)>& wanted) {
  TestRandom random(8);
  const GriddedCloud gridded(
      test::segment(-30.0 * direction, 30.0 * direction, 1000, 0.0, &random));
  const Vector3f sensor(50, -20, 70);
  const std::vector<SurfaceFit> pieces = fitted(gridded, sensor);
  ASSERT_GT(pieces.size(), 20u);
  expectSound(pieces, sensor);
  for (const SurfaceFit& piece : pieces) {
    const Vector3d center = piece.center.cast<double>();
    ASSERT_LT((center - center.dot(direction) * direction).norm(), 0.01);
    ASSERT_NEAR(std::abs(piece.major.cast<double>().dot(direction)), 1.0, 1e-3);
    ASSERT_EQ(piece.level, 0);
    Vector3d across = wanted(center);
    across -= across.dot(direction) * direction;
    ASSERT_GT(piece.normal.cast<double>().dot(across.normalized()), 0.999);
  }
}

TEST(FitSurface, AStandingLineFacesTheSensor) {
  expectLine(Vector3d(1, -2, 4).normalized(),
             [](const Vector3d& center) -> Vector3d { return Vector3d(50, -20, 70) - center; });
}

TEST(FitSurface, ALyingLineIsAStripOfGround) {
  expectLine(Vector3d(3, 2, 1).normalized(),
             [](const Vector3d&) -> Vector3d { return Vector3d::UnitZ(); });
}

TEST(FitSurface, LinesOnAPlaneFindIt) {
  TestRandom random(9);
  Cloud cloud;
  for (int line = -5; line <= 5; ++line) {
    const Cloud more =
        test::segment({-40, 6.0 * line, 0.5}, {40, 6.0 * line, 0.5}, 800, 0.02, &random);
    cloud.insert(cloud.end(), more.begin(), more.end());
  }
  const std::vector<SurfaceFit> pieces = fitted(GriddedCloud(cloud));
  expectSound(pieces, kAbove);
  std::size_t bridges = 0;
  for (const SurfaceFit& piece : pieces) {
    ASSERT_NEAR(piece.center.z(), 0.5F, 0.3F);
    if (piece.level == 0) continue;
    ++bridges;
    ASSERT_GT(piece.normal.z(), 0.98F);
    ASSERT_GT(piece.semi_minor, 2.0F);
  }
  EXPECT_GT(bridges, 50u);
}

TEST(FitSurface, FoliageIsNotBridged) {
  TestRandom random(10);
  // One point to 30 cells: too few for planes, enough for the coarser levels.
  const std::vector<SurfaceFit> pieces =
      fitted(GriddedCloud(test::ball({0, 0, 0}, 25, 2200, &random)));
  expectSound(pieces, kAbove);
  std::size_t bridges = 0;
  for (const SurfaceFit& piece : pieces) bridges += piece.level > 0 ? 1 : 0;
  EXPECT_LT(bridges, pieces.size() / 50);
}

TEST(FitSurface, IsTheSameForAnyNumberOfThreads) {
  TestRandom random(11);
  const test::PlaneFrame slant({0, 0, 0}, Vector3d(1, 2, 3));
  const GriddedCloud gridded(test::joined(test::patch(slant, 90, 90, 30000, 0.2, &random),
                                          test::ball({20, 20, 20}, 30, 5000, &random)));
  const std::vector<SurfaceFit> one = fitted(gridded);
  for (const int threads : {2, 4}) {
    const std::vector<SurfaceFit> several = fitted(gridded, kAbove, threads);
    ASSERT_EQ(one.size(), several.size());
    for (std::size_t i = 0; i < one.size(); ++i) ASSERT_TRUE(same(one[i], several[i])) << i;
  }
}

}  // namespace
}  // namespace ladar_perception
