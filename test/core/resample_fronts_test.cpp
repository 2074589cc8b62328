// SPDX-License-Identifier: BSD-3-Clause
// Arrival times of fronts against distances in closed form, against the paper's equation 7 on a
// fine grid, and against scikit-fmm.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <string>

#include "eikonal_oracle.h"
#include "ladar_perception/resample/fronts.h"
#include "skfmm_times.h"
#include "test_crusts.h"
#include "test_random.h"

namespace ladar_perception::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
using Distance = std::function<double(const Eigen::Vector3d&, const Eigen::Vector3d&)>;

double straightDistance(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).norm();
}

/// Expects kArrivalError and returns the mean error in cells, late counting as positive.
double expectArrivals(const Crust& crust, const std::vector<double>& times,
                      const std::vector<uint32_t>& sources, const Distance& distance,
                      double farthest = 1e9, double more_cells = 0.0) {
  double sum = 0.0;
  int wrong = 0;
  for (std::size_t i = 0; i < crust.size(); ++i) {
    double expected = 1e9;
    for (const uint32_t source : sources) {
      expected = std::min(expected, distance(placeOf(crust, source), placeOf(crust, i)));
    }
    sum += times[i] - expected;
    const double bound = double{kArrivalError} * expected + kArrivalErrorCells + more_cells;
    if (expected > farthest || std::abs(times[i] - expected) <= bound) continue;
    if (++wrong < 5) {
      ADD_FAILURE() << "cell at " << placeOf(crust, i).transpose() << ": " << times[i]
                    << ", expected " << expected;
    }
  }
  EXPECT_EQ(wrong, 0) << "of " << crust.size();
  return sum / static_cast<double>(crust.size());
}

/// Points on a square of that many cells, turned about an axis in it.
std::vector<Eigen::Vector3d> tiltedPlane(double edge, double angle, double noise = 0.0) {
  TestRandom random(7);
  const Eigen::AngleAxisd tilt(angle, Eigen::Vector3d(1.0, 0.3, 0.0).normalized());
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < static_cast<int>(8.0 * edge * edge); ++i) {
    const double x = random.real(0.0, edge);
    const double y = random.real(0.0, edge);
    points.push_back(tilt * Eigen::Vector3d(x, y, noise * random.normal()));
  }
  return points;
}

template <typename Metric>
class ResampleFronts : public testing::Test {};
using Metrics = testing::Types<FastMarching, Flood>;
TYPED_TEST_SUITE(ResampleFronts, Metrics);

TYPED_TEST(ResampleFronts, NoneWithoutSources) {
  const Crust crust = gridCrust(3, 3);
  const FrontField field(crust);
  for (const FrontField::Arrival& arrival : field.arrivals) {
    EXPECT_TRUE(std::isinf(arrival.time));
    EXPECT_EQ(arrival.owner, kNoIndex);
  }
}

TYPED_TEST(ResampleFronts, ACrustOfOneCell) {
  const Crust crust = gridCrust(1, 1);
  FrontField field(crust);
  Fronts<TypeParam>(&field).insert(0, Eigen::Vector3f(0.3F, 0.4F, 0.0F));
  EXPECT_NEAR(field.arrivals[0].time, 0.5F, 1e-6F);
  EXPECT_EQ(field.arrivals[0].owner, 0u);
}

TYPED_TEST(ResampleFronts, PlanesAtAnyAngle) {
  for (const double angle : {0.0, 0.2, 0.5, 0.25 * kPi, 1.2, 0.5 * kPi}) {
    SCOPED_TRACE(angle);
    const Eigen::AngleAxisd tilt(angle, Eigen::Vector3d(1.0, 0.3, 0.0).normalized());
    const Crust crust =
        surfelCrust(tiltedPlane(70.0, angle), tilt * Eigen::Vector3d(35.0, 35.0, 1e3));
    const uint32_t source = cellNear(crust, tilt * Eigen::Vector3d(30.0, 20.0, 0.0));
    const double late =
        expectArrivals(crust, arrivalTimes<TypeParam>(crust, {source}), {source}, straightDistance);
    EXPECT_LT(std::abs(late), 0.05);
  }
}

/// Whichever comes last, every cell belongs to the nearest of many samples.
TYPED_TEST(ResampleFronts, TheEarliestOfManyCounts) {
  const Crust crust = surfelCrust(tiltedPlane(60.0, 0.5), Eigen::Vector3d(0, 0, 1e4));
  TestRandom random(5);
  std::vector<uint32_t> sources;
  for (int i = 0; i < 60; ++i) {
    sources.push_back(
        static_cast<uint32_t>(random.integer(0, static_cast<int64_t>(crust.size()) - 1)));
    if (i % 20 != 0) continue;
    SCOPED_TRACE(i);
    expectArrivals(crust, arrivalTimes<TypeParam>(crust, sources), sources, straightDistance);
  }
}

TYPED_TEST(ResampleFronts, EndAtTheLimit) {
  const Crust crust = gridCrust(41, 41);
  FrontField field(crust);
  field.reset(10.0F);
  const uint32_t source = cellNear(crust, Eigen::Vector3d(20, 20, 0));
  Fronts<TypeParam>(&field).insert(source, crust.positions[source]);
  for (std::size_t i = 0; i < crust.size(); ++i) {
    const float distance = (crust.positions[i] - crust.positions[source]).norm();
    EXPECT_NEAR(field.arrivals[i].time, std::min(distance, 10.0F), 0.05F);
    if (std::abs(distance - 10.0F) < 0.05F) continue;
    EXPECT_EQ(field.arrivals[i].owner, distance < 10.0F ? source : kNoIndex);
  }
}

TYPED_TEST(ResampleFronts, StayOnTheirIsland) {
  // Two strips with a gap of one cell.
  const Crust crust = gridCrust(20, 11, [](int, int y) { return y != 5; });
  FrontField field(crust);
  const uint32_t source = cellNear(crust, Eigen::Vector3d(3, 2, 0));
  Fronts<TypeParam>(&field).insert(source, crust.positions[source]);
  for (std::size_t i = 0; i < crust.size(); ++i) {
    EXPECT_EQ(std::isfinite(field.arrivals[i].time), crust.positions[i].y() < 5.0F);
  }
}

/// The sample lies beside the place of its cell: times count from where it is.
TYPED_TEST(ResampleFronts, SamplesNeedNotBeInTheMiddleOfCells) {
  const Crust crust = gridCrust(21, 21);
  FrontField field(crust);
  const Eigen::Vector3f sample(10.4F, 9.7F, 0.0F);
  Fronts<TypeParam>(&field).insert(cellNear(crust, Eigen::Vector3d(10, 10, 0)), sample);
  for (std::size_t i = 0; i < crust.size(); ++i) {
    EXPECT_NEAR(field.arrivals[i].time, (crust.positions[i] - sample).norm(), 0.01F);
  }
}

/// Noise of single normals and heights, where points are few, must not hold a front up: it would
/// get a second sample beside the first.
TYPED_TEST(ResampleFronts, NoiseDoesNotHoldThemUpNearTheirSample) {
  TestRandom random(11);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 3600; ++i) {
    const double x = random.real(0.0, 60.0);
    const double y = random.real(0.0, 60.0);
    points.emplace_back(x, y, 0.2 * random.normal());
  }
  const Crust crust = surfelCrust(points, Eigen::Vector3d(30, 30, 1e3));
  int near = 0;
  int late = 0;
  for (int i = 0; i < 200; ++i) {
    const auto source =
        static_cast<uint32_t>(random.integer(0, static_cast<int64_t>(crust.size()) - 1));
    FrontField field(crust);
    field.reset(4.0F);
    Fronts<TypeParam>(&field).insert(source, crust.positions[source]);
    for (std::size_t k = 0; k < crust.size(); ++k) {
      const float distance = (crust.positions[k] - crust.positions[source]).norm();
      if (distance > 2.4F) continue;
      ++near;
      if (field.arrivals[k].time > distance + 0.1F) ++late;
    }
  }
  EXPECT_LT(late, near / 200) << "of " << near;
}

TEST(ResampleFlood, IsStraightAcrossACorner) {
  const Crust crust = gridCrust(9, 9);
  Crust bent = crust;
  for (std::size_t i = 0; i < bent.size(); ++i) {
    if (bent.positions[i].x() <= 4.0F) continue;
    bent.positions[i].z() = bent.positions[i].x() - 4.0F;
    bent.positions[i].x() = 4.0F;
    bent.normals[i] = -Eigen::Vector3f::UnitX();
  }
  const uint32_t source = cellNear(bent, Eigen::Vector3d(1, 4, 0));
  const std::vector<double> times = arrivalTimes<Flood>(bent, {source});
  for (std::size_t i = 0; i < bent.size(); ++i) {
    EXPECT_NEAR(times[i], (bent.positions[i] - bent.positions[source]).norm(), 1e-5);
  }
}

TEST(ResampleFastMarching, GreatCirclesOfSpheres) {
  for (const double radius : {10.0, 15.0, 30.0}) {
    SCOPED_TRACE(radius);
    TestRandom random(3);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < static_cast<int>(100.0 * radius * radius); ++i) {
      points.push_back(radius * random.normal3().normalized());
    }
    const Crust crust = surfelCrust(points, Eigen::Vector3d::Zero());
    for (const Eigen::Vector3d& place :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(-0.2, 0.5, 0.8)}) {
      const uint32_t source = cellNear(crust, radius * place.normalized());
      expectArrivals(
          crust, arrivalTimes<FastMarching>(crust, {source}), {source},
          [radius](const auto& a, const auto& b) { return sphereDistance(radius, a, b); },
          0.9 * kPi * radius);
    }
  }
}

/// A plane of cells, bent at right angles in the x axis.
Crust cornerCrust(int edge) {
  Crust crust = gridCrust(edge, edge);
  const float fold = static_cast<float>(edge / 2) + 0.5F;
  for (std::size_t i = 0; i < crust.size(); ++i) {
    Eigen::Vector3f& p = crust.positions[i];
    const float across = p.y() - fold;
    p = Eigen::Vector3f(p.x(), std::max(across, 0.0F), std::max(-across, 0.0F));
    if (across < 0.0F) crust.normals[i] = Eigen::Vector3f::UnitY();
  }
  return crust;
}

const Eigen::Vector3d kBesideACorner[] = {{25, 10, 0}, {10, 0, 3}, {5, 0, 0.5}, {25, 2, 0}};

TEST(ResampleFastMarching, ACornerUnfolds) {
  const Crust crust = cornerCrust(60);
  for (const Eigen::Vector3d& place : kBesideACorner) {
    SCOPED_TRACE(place.transpose());
    const uint32_t source = cellNear(crust, place);
    expectArrivals(crust, arrivalTimes<FastMarching>(crust, {source}), {source}, cornerDistance);
  }
}

/// Surfels cut the corner, so that the way is up to a cell shorter; and where the corner meets the
/// rim there is no second neighbour for a front to come between.
TEST(ResampleFastMarching, ACornerOfSurfels) {
  TestRandom random(9);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 40000; ++i) {
    const double x = random.real(0.0, 50.0);
    const double across = random.real(0.0, 50.0);
    points.emplace_back(x, i % 2 == 0 ? across : 0.0, i % 2 == 0 ? 0.0 : across);
  }
  const Crust crust = surfelCrust(points, Eigen::Vector3d(25, 25, 25));
  for (const Eigen::Vector3d& place : kBesideACorner) {
    SCOPED_TRACE(place.transpose());
    const uint32_t source = cellNear(crust, place);
    expectArrivals(crust, arrivalTimes<FastMarching>(crust, {source}), {source}, cornerDistance,
                   1e9, 0.8);
  }
}

/// Distance in a plane around a disc at the origin.
double aroundDisc(double radius, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double t = std::clamp(a.dot(a - b) / (a - b).squaredNorm(), 0.0, 1.0);
  if ((a == b) || (a + t * (b - a)).norm() >= radius) return (a - b).norm();
  const double turned = std::acos(a.dot(b) / (a.norm() * b.norm()));
  const double along = turned - std::acos(radius / a.norm()) - std::acos(radius / b.norm());
  return std::sqrt(a.squaredNorm() - radius * radius) +
         std::sqrt(b.squaredNorm() - radius * radius) + radius * std::max(along, 0.0);
}

TEST(ResampleFastMarching, GoesAroundAHole) {
  constexpr int kHalf = 40;
  constexpr double kHole = 12.0;
  const Crust crust = gridCrust(2 * kHalf + 1, 2 * kHalf + 1, [](int x, int y) {
    return std::hypot(x - kHalf, y - kHalf) >= kHole;
  });
  const Eigen::Vector3d middle(kHalf, kHalf, 0);
  const uint32_t source = cellNear(crust, middle + Eigen::Vector3d(-20, 3, 0));
  const std::vector<double> times = arrivalTimes<FastMarching>(crust, {source});
  for (std::size_t i = 0; i < crust.size(); ++i) {
    const double expected =
        aroundDisc(kHole, placeOf(crust, source) - middle, placeOf(crust, i) - middle);
    // The hole's rim is a staircase of cells; and sight reaches a bit around it.
    EXPECT_NEAR(times[i], expected, 0.09 * expected + 0.5) << placeOf(crust, i).transpose();
  }
}

/// Sets slowness to 1 / speed and returns times; speeds in cells per unit of time.
std::vector<double> timesWithSpeed(Crust crust, const std::function<double(double, double)>& speed,
                                   uint32_t source) {
  for (std::size_t i = 0; i < crust.size(); ++i) {
    const Eigen::Vector3d p = placeOf(crust, i);
    crust.slowness[i] = static_cast<float>(1.0 / speed(p.x(), p.y()));
  }
  return arrivalTimes<FastMarching>(crust, {source});
}

TEST(ResampleFastMarching, SpeedThatGrowsEvenly) {
  const Crust crust = gridCrust(51, 41);
  const uint32_t source = cellNear(crust, Eigen::Vector3d(10, 20, 0));
  const std::vector<double> times = timesWithSpeed(
      crust, [](double x, double) { return 0.5 + 0.03 * x; }, source);
  for (std::size_t i = 0; i < crust.size(); ++i) {
    const double expected = linearSpeedTime(0.5, 0.03, placeOf(crust, source), placeOf(crust, i));
    EXPECT_NEAR(times[i], expected, 0.03 * expected + 0.1) << placeOf(crust, i).transpose();
  }
}

/// A front that comes from slow into fast ground runs along the border and comes back (as light
/// and earthquakes do): the paper's equation on a grid eight times as fine has no closed form's
/// gaps.
TEST(ResampleFastMarching, SpeedThatJumps) {
  constexpr int kCells = 31;
  constexpr int kFiner = 8;
  const auto speed = [](double x, double) { return x < 12.0 ? 0.5 : 1.0; };
  const Crust crust = gridCrust(kCells, kCells);
  const RegularGrid fine{(kCells - 1) * kFiner + 1, (kCells - 1) * kFiner + 1, 1, 1.0 / kFiner};
  std::vector<double> speeds;
  for (std::size_t i = 0; i < fine.size(); ++i) speeds.push_back(speed(fine.center(i).x(), 0.0));
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(6, 10, 0), Eigen::Vector3d(20, 10, 0)}) {
    SCOPED_TRACE(place.transpose());
    const uint32_t source = cellNear(crust, place);
    const std::vector<double> times = timesWithSpeed(crust, speed, source);
    const std::vector<double> expected =
        EikonalOracle(fine, speeds)
            .march({fine.index(static_cast<int>(place.x()) * kFiner,
                               static_cast<int>(place.y()) * kFiner)});
    for (std::size_t i = 0; i < crust.size(); ++i) {
      const Eigen::Vector3d p = placeOf(crust, i);
      const double there =
          expected[fine.index(static_cast<int>(p.x()) * kFiner, static_cast<int>(p.y()) * kFiner)];
      // Half a cell of slow ground, and half a cell because the border lies between two cells.
      EXPECT_NEAR(times[i], there, 0.03 * there + 1.5) << p.transpose();
    }
  }
}

TEST(ResampleFastMarching, AgreesWithScikitFmm) {
  const auto fields = readSkfmmFields(std::string(LADAR_SOURCE_DIR) + "/test/data/skfmm_times.txt");
  for (const auto& [name, field] : fields) {
    if (field.grid.nz > 1) continue;  // crusts are thin
    SCOPED_TRACE(name);
    Crust crust = gridCrust(field.grid.nx, field.grid.ny);
    const auto indexOf = [&grid = field.grid](const Eigen::Vector3f& p) {
      return grid.index(static_cast<int>(p.x()), static_cast<int>(p.y()));
    };
    double slowest = 0.0;
    for (std::size_t i = 0; i < crust.size(); ++i) {
      const double slowness = 1.0 / field.speeds[indexOf(crust.positions[i])];
      slowest = std::max(slowest, slowness);
      crust.slowness[i] = static_cast<float>(slowness);
    }
    std::vector<uint32_t> sources;
    for (const std::size_t source : field.sources) {
      sources.push_back(cellNear(crust, field.grid.center(source) / field.grid.spacing_m));
    }
    const std::vector<double> times = arrivalTimes<FastMarching>(crust, sources);
    for (std::size_t i = 0; i < crust.size(); ++i) {
      const double expected =
          field.second_order[indexOf(crust.positions[i])] / field.grid.spacing_m;
      EXPECT_NEAR(times[i], expected, 0.03 * expected + 0.5 * slowest) << i;
    }
  }
}

}  // namespace
}  // namespace ladar_perception::test
