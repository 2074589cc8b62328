// SPDX-License-Identifier: BSD-3-Clause
// Measures of samplings on lattices whose values are known, and against brute force.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "ladar_perception/resample/sampling_quality.h"
#include "ladar_perception/sim/random.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

const double kInfinity = std::numeric_limits<double>::infinity();

/// Hexagonal lattice of spacing `a` that fills a square from the origin, z = 0.
Points hexagons(double size_m, double a) {
  Points points;
  const double row_m = a * std::sqrt(0.75);
  for (int row = 0; row * row_m < size_m; ++row) {
    for (int i = 0; (i + 0.5 * (row % 2)) * a < size_m; ++i) {
      points.emplace_back((i + 0.5 * (row % 2)) * a, row * row_m, 0.0);
    }
  }
  return points;
}

/// Square lattice whose points are the middles of square cells.
Points squares(double size_m, double a) {
  Points points;
  for (double y = 0.5 * a; y < size_m; y += a) {
    for (double x = 0.5 * a; x < size_m; x += a) points.emplace_back(x, y, 0.0);
  }
  return points;
}

Points randomPoints(std::size_t count, double size_m, double high_m, uint64_t seed) {
  sim::Random random(seed);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.uniform(0.0, size_m);
    const double y = random.uniform(0.0, size_m);
    const double z = random.uniform(0.0, high_m);
    points.emplace_back(x, y, z);
  }
  return points;
}

TEST(SamplingQuality, SummaryOfAFewNumbers) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Summary summary = summarize(values);
  EXPECT_EQ(summary.count, 100u);
  EXPECT_NEAR(summary.mean, 50.5, 1e-12);
  EXPECT_NEAR(summary.rms, std::sqrt(338350.0 / 100.0), 1e-9);
  EXPECT_EQ(summary.median, 50.0);
  EXPECT_EQ(summary.p95, 95.0);
  EXPECT_EQ(summary.p99, 99.0);
  EXPECT_EQ(summary.max, 100.0);
  EXPECT_EQ(summarize({3.0}).p99, 3.0);
  EXPECT_EQ(summarize({}).count, 0u);
}

TEST(SamplingQuality, DistancesAgreeWithBruteForce) {
  const Points from = randomPoints(400, 2.0, 2.0, 1);
  const Points to = randomPoints(300, 2.0, 1.0, 2);
  const std::vector<double> nearest = nearestDistances(from, to);
  const std::vector<double> neighbour = neighbourDistances(from);
  ASSERT_EQ(nearest.size(), from.size());
  ASSERT_EQ(neighbour.size(), from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    double least = kInfinity;
    for (const Vector3d& p : to) least = std::min(least, (p - from[i]).norm());
    EXPECT_NEAR(nearest[i], least, 1e-12);
    double other = kInfinity;
    for (std::size_t k = 0; k < from.size(); ++k) {
      if (k != i) other = std::min(other, (from[k] - from[i]).norm());
    }
    EXPECT_NEAR(neighbour[i], other, 1e-12);
  }
}

TEST(SamplingQuality, DegenerateSetsOfPoints) {
  EXPECT_EQ(spacingOf({}).samples, 0u);
  EXPECT_EQ(spacingOf({{1, 2, 3}}).mean_m, 0.0);
  EXPECT_EQ(neighbourDistances({{1, 2, 3}}), std::vector<double>{kInfinity});
  EXPECT_EQ(nearestDistances({{1, 2, 3}}, {}), std::vector<double>{kInfinity});
  const SpacingStatistics twins = spacingOf({{1, 2, 3}, {1, 2, 3}});
  EXPECT_EQ(twins.mean_m, 0.0);
  EXPECT_EQ(twins.cov, 0.0);
  const SpacingStatistics pair = spacingOf({{0, 0, 0}, {0, 3, 4}});
  EXPECT_EQ(pair.mean_m, 5.0);
  EXPECT_EQ(pair.cov, 0.0);
  EXPECT_EQ(pair.min_over_mean, 1.0);
  // Far from the origin nothing is lost.
  const SpacingStatistics far = spacingOf({{1e6, 1e6, 0}, {1e6 + 0.25, 1e6, 0}});
  EXPECT_EQ(far.mean_m, 0.25);
}

TEST(SamplingQuality, HexagonalLatticeIsPerfectUpToItsRim) {
  const SpacingStatistics spacing = spacingOf(hexagons(5.0, 0.1));
  EXPECT_GT(spacing.samples, 2500u);
  EXPECT_NEAR(spacing.mean_m, 0.1, 1e-9);
  EXPECT_NEAR(spacing.cov, 0.0, 1e-9);
  EXPECT_NEAR(spacing.min_over_mean, 1.0, 1e-9);
  EXPECT_EQ(spacing.isolated, 0u);
}

TEST(SamplingQuality, RandomPointsHaveTheCovOfAPoissonProcess) {
  const SpacingStatistics spacing = spacingOf(randomPoints(20000, 10.0, 0.0, 3));
  // Mean 1 / (2 sqrt(density)), cov sqrt(4 / pi - 1).
  EXPECT_NEAR(spacing.mean_m, 0.5 / std::sqrt(200.0), 0.01 * spacing.mean_m);
  EXPECT_NEAR(spacing.cov, std::sqrt(4.0 / M_PI - 1.0), 0.01);
  EXPECT_LT(spacing.min_over_mean, 0.05);
}

TEST(SamplingQuality, IslandsAreCountedNotAveraged) {
  Points points = hexagons(2.0, 0.1);
  const auto lattice = points.size();
  points.emplace_back(1.0, 1.0, 3.0);
  points.emplace_back(1.0, 1.0, 6.0);
  const SpacingStatistics spacing = spacingOf(points);
  EXPECT_EQ(spacing.samples, lattice + 2);
  EXPECT_EQ(spacing.isolated, 2u);
  EXPECT_GT(spacing.cov, 0.5);
  EXPECT_NEAR(spacing.connected_cov, 0.0, 1e-9);
  EXPECT_NEAR(spacing.connected_mean_m, 0.1, 1e-9);
  EXPECT_NEAR(spacing.connected_min_over_mean, 1.0, 1e-9);
}

TEST(SamplingQuality, CoveringOfLattices) {
  // Inside, so that no place lies beyond the last row.
  Points reference;
  for (const Vector3d& p : squares(3.0, 0.013)) reference.push_back(p + Vector3d(1.0, 1.0, 0.0));
  const CoveringStatistics hexagonal = coveringOf(hexagons(5.0, 0.2), reference, 0.2);
  EXPECT_NEAR(hexagonal.max_over_spacing, 1.0 / std::sqrt(3.0), 0.01);
  EXPECT_NEAR(hexagonal.p99_over_spacing, 0.55, 0.01);
  const CoveringStatistics square = coveringOf(squares(5.0, 0.2), reference, 0.2);
  EXPECT_NEAR(square.max_over_spacing, std::sqrt(0.5), 0.01);
  // The mean distance of a square's points from its middle.
  EXPECT_NEAR(square.distance_m.mean / 0.2, (std::sqrt(2.0) + std::log(1.0 + std::sqrt(2.0))) / 6.0,
              0.005);
  EXPECT_EQ(square.distance_m.count, reference.size());
}

TEST(SamplingQuality, PlacesOfTheRimThatAreNotReachedAreSeen) {
  const Points reference = squares(4.0, 0.02);
  Points samples = hexagons(4.0, 0.2);
  const double whole = coveringOf(samples, reference, 0.2).max_over_spacing;
  const auto beyond = [](const Vector3d& p) { return p.x() > 3.0; };
  samples.erase(std::remove_if(samples.begin(), samples.end(), beyond), samples.end());
  EXPECT_LT(whole, 1.0);
  EXPECT_GT(coveringOf(samples, reference, 0.2).max_over_spacing, 4.5);
  EXPECT_EQ(coveringOf({}, reference, 0.2).distance_m.max, kInfinity);
  EXPECT_EQ(coveringOf(samples, reference, 0.0).p99_over_spacing, 0.0);
}

TEST(SamplingQuality, BoxesCountWhatTheyHold) {
  const Points points = squares(10.0, 0.1);  // 100 per m^2
  OrientedBox upright;
  upright.centre_m = {5.0, 5.0, 0.0};
  upright.half_size_m = {1.0, 0.5, 0.1};
  OrientedBox turned = upright;
  turned.axes = Eigen::AngleAxisd(0.3, Vector3d::UnitZ()).toRotationMatrix();
  OrientedBox raised = upright;
  raised.centre_m.z() = 0.2;
  const std::vector<uint64_t> counts = countInBoxes(points, {upright, turned, raised});
  EXPECT_EQ(counts[0], 200u);
  EXPECT_NEAR(static_cast<double>(counts[1]), 200.0, 6.0);
  EXPECT_EQ(counts[2], 0u);
  OrientedBox exact;  // its sides belong to it
  EXPECT_TRUE(exact.contains({0.5, -0.5, 0.5}));
  EXPECT_FALSE(exact.contains({0.5000001, 0.0, 0.0}));
  EXPECT_FALSE(exact.contains({std::nan(""), 0.0, 0.0}));
}

TEST(SamplingQuality, ARegionIsWhereThePointsAre) {
  const Rectangle face{{1, 0, 0}, {4, 0, 0}, {0, 0, 3}};  // x from 1 to 5, z from 0 to 3, y = 0
  EXPECT_EQ(face.normal(), Vector3d(0, -1, 0));
  FaceRegion region(face, 0.1);
  EXPECT_EQ(region.columns(), 40);
  EXPECT_EQ(region.rows(), 30);
  EXPECT_EQ(region.area(), 0.0);
  region.coverBy({{2.05, 0.01, 1.05}}, 0.21, 0.02);  // five by five cells
  EXPECT_NEAR(region.area(), 0.25, 1e-9);
  EXPECT_TRUE(region.contains({2.05, -0.01, 1.05}, 0.02));
  EXPECT_FALSE(region.contains({2.05, 0.03, 1.05}, 0.02)) << "off the plane";
  EXPECT_FALSE(region.contains({2.35, 0.0, 1.05}, 0.02));
  region.coverBy({{2.05, 0.03, 1.9}, {1e300, 0, 0}, {std::nan(""), 0, 0}}, 0.21, 0.02);
  EXPECT_NEAR(region.area(), 0.25, 1e-9) << "off the plane, far away, nowhere";
  region.coverBy({{0.95, 0.0, -0.05}}, 0.21, 0.02);  // beside it: two by two cells are in reach
  EXPECT_NEAR(region.area(), 0.29, 1e-9);
}

TEST(SamplingQuality, ShrinkingTakesTheRimsAway) {
  // Drawn: '#' is in. One cell is missing in the middle, and the rectangle's own rim counts.
  FaceRegion region({{0, 0, 0}, {0.9, 0, 0}, {0, 0.5, 0}}, 0.1);
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 9; ++column) region.set(column, row, column != 5 || row != 2);
  }
  region.shrink(0.1);
  std::string picture;
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 9; ++column) picture += region.at(column, row) ? '#' : '.';
    picture += '\n';
  }
  EXPECT_EQ(picture,
            ".........\n"
            ".###...#.\n"
            ".###...#.\n"
            ".###...#.\n"
            ".........\n");
  region.shrink(1.0);
  EXPECT_EQ(region.area(), 0.0);
}

TEST(SamplingQuality, DensityOfFacesRelativeToEachOther) {
  const auto whole = [](const Rectangle& face) {
    FaceRegion region(face, 0.05);
    for (int row = 0; row < region.rows(); ++row) {
      for (int column = 0; column < region.columns(); ++column) region.set(column, row, true);
    }
    return region;
  };
  const Rectangle floor{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const Rectangle shelf{{0, 0, 1}, {2, 0, 0}, {0, 4, 0}};
  const Rectangle shelf_again{{1, 0, 1}, {1, 0, 0}, {0, 4, 0}};
  const Rectangle unseen{{0, 0, 2}, {4, 0, 0}, {0, 4, 0}};
  Points samples = squares(4.0, 0.1);  // 1600 on the floor
  for (const Vector3d& p : squares(4.0, 0.2)) samples.push_back(p + Vector3d(0, 0, 1.0));
  const auto densities = faceDensities(
      {{whole(floor)}, {whole(shelf), whole(shelf_again)}, {FaceRegion(unseen, 0.05)}}, samples,
      0.01);
  EXPECT_EQ(densities[0].samples, 1600u);
  EXPECT_NEAR(densities[0].perSquareMetre(), 100.0, 1e-9);
  EXPECT_EQ(densities[1].samples, 200u) << "a sample in two rectangles of a face counts once";
  EXPECT_EQ(densities[2].samples, 0u);
  EXPECT_EQ(densities[2].relative, 0.0);
  const double all = 1800.0 / (16.0 + 12.0);
  EXPECT_NEAR(densities[0].relative, 100.0 / all, 1e-9);
}

}  // namespace
}  // namespace ladar_perception
