// SPDX-License-Identifier: BSD-3-Clause
// The crust of surfels with cells of one size.
#include <gtest/gtest.h>

#include <cmath>

#include "crust_checks.h"
#include "crust_clouds.h"
#include "ladar_perception/resample/crust.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::GriddedCloud;
using test::PlaneFrame;
using test::TestRandom;

Crust crustOf(const GriddedCloud& gridded, const Vector3f& sensor, int threads = 1) {
  ThreadPool pool(threads);
  return makeSurfelCrust(gridded.pyramid, gridded.points.frame, {}, sensor, &pool);
}

Crust crustOf(const Cloud& cloud, const Vector3f& sensor = {0, 0, 500}) {
  return crustOf(GriddedCloud(cloud), sensor);
}

void expectOneCellAColumn(const Crust& crust, std::size_t axis) {
  std::set<std::array<int, 2>> columns;
  for (std::size_t i = 0; i < crust.size(); ++i) {
    ASSERT_TRUE(columns.insert(test::columnOf(crust, i, axis)).second) << i;
  }
}

TEST(SurfelCrust, OfAPlaneIsOnePartWithOneCellAColumn) {
  TestRandom random(1);
  for (const double tilt : {0.0, 2.0, 14.0, 27.0, 38.0}) {
    for (const double height : {0.0, 0.3, 0.5}) {
      const PlaneFrame plane({0, 0, height}, test::tilted(tilt, 20.0));
      const Crust crust = crustOf(test::patch(plane, 50, 50, 30000, 0.05, &random));
      test::expectSoundCrust(crust, {0, 0, 500});
      expectOneCellAColumn(crust, 2);
      EXPECT_EQ(test::countParts(crust), 1u) << tilt << " " << height;
      // Every column under the middle has its cell.
      std::size_t inside = 0;
      for (const Vector3f& p : crust.positions) {
        inside += p.head<2>().cwiseAbs().maxCoeff() < 14.0F ? 1 : 0;
      }
      EXPECT_EQ(inside, 28u * 28u) << tilt << " " << height;
    }
  }
}

TEST(SurfelCrust, AveragesTheNoiseOfAPlane) {
  TestRandom random(2);
  for (const double tilt : {0.0, 30.0, 54.7}) {
    for (const double noise : {0.05, 0.15, 0.3}) {
      const PlaneFrame plane({0, 0, 0.2}, test::tilted(tilt, 45.0));
      const Vector3f sensor = (200.0 * plane.normal).cast<float>();
      const Crust crust = crustOf(test::patch(plane, 50, 50, 25000, noise, &random), sensor);
      double sum2 = 0.0;
      for (std::size_t i = 0; i < crust.size(); ++i) {
        const double height = plane.height(crust.positions[i].cast<double>());
        sum2 += height * height;
        if (crust.positions[i].norm() > 22.0F) continue;  // the rim has fewer points
        ASSERT_GT(crust.normals[i].cast<double>().dot(plane.normal), 0.98);
      }
      EXPECT_LT(std::sqrt(sum2 / static_cast<double>(crust.size())), noise / 3.0)
          << tilt << " " << noise;
    }
  }
}

TEST(SurfelCrust, AreaOfPlanesAtManySlants) {
  TestRandom random(3);
  for (const double tilt : {0.0, 10.0, 30.0, 45.0, 54.7356, 70.0, 90.0}) {
    for (const double azimuth : {0.0, 20.0, 45.0}) {
      // Not through corners of the grid, where two layers of cells are as near to the plane.
      const PlaneFrame plane({0.012, 0.018, 0.013}, test::tilted(tilt, azimuth));
      const GriddedCloud gridded(test::patch(plane, 8.0, 6.0, 40000, 0.005, &random),
                                 test::gridFrame(0.1));
      const Crust crust = crustOf(gridded, (1000.0 * plane.normal).cast<float>());
      EXPECT_NEAR(crust.area_m2() / 48.0, 1.0, 0.05) << tilt << " " << azimuth;
      EXPECT_EQ(test::countParts(crust), 1u) << tilt << " " << azimuth;
    }
  }
}

TEST(SurfelCrust, NormalsPointTowardsTheSensorOnEitherSide) {
  TestRandom random(4);
  const PlaneFrame plane({0, 0, 0}, Vector3d(1, 2, 3));
  const GriddedCloud gridded(test::patch(plane, 30, 30, 6000, 0.05, &random));
  for (const double side : {1.0, -1.0}) {
    const Crust crust = crustOf(gridded, (side * 100.0 * plane.normal).cast<float>());
    for (const Vector3f& normal : crust.normals) {
      ASSERT_GT(side * normal.cast<double>().dot(plane.normal), 0.97);
    }
  }
}

TEST(SurfelCrust, OfASphereIsClosed) {
  TestRandom random(5);
  const Vector3d center(3, 4, 5);
  const double radius = 15.0;
  const Crust crust =
      crustOf(test::sphere(center, radius, 20000, 0.05, &random), center.cast<float>());
  test::expectSoundCrust(crust, center.cast<float>());
  EXPECT_EQ(test::countParts(crust), 1u);
  EXPECT_NEAR(crust.area_m2() / (4.0 * M_PI * radius * radius), 1.0, 0.08);
  for (std::size_t i = 0; i < crust.size(); ++i) {
    const Vector3d d = crust.positions[i].cast<double>() - center;
    ASSERT_NEAR(d.norm(), radius, 0.35);
    ASSERT_LT(crust.normals[i].cast<double>().dot(d.normalized()), -0.95);
    ASSERT_GE(test::neighborsOf(crust, i).size(), 4u);
  }
}

TEST(SurfelCrust, ACornerIsConnected) {
  TestRandom random(6);
  for (const double shift : {0.0, 0.3, 0.7}) {
    const Cloud floor = test::patch({{0, 0, shift}, {0, 0, 1}}, 40, 40, 10000, 0.05, &random);
    const Cloud wall =
        test::patch({{20.0 + shift, 0, 15 + shift}, {1, 0, 0}}, 30, 40, 8000, 0.05, &random);
    const Vector3f sensor(-60, 0, 70);
    const Crust crust = crustOf(test::joined(floor, wall), sensor);
    test::expectSoundCrust(crust, sensor);
    EXPECT_GT(test::largestPart(crust), 0.995);
    std::size_t links = 0;  // from the one to the other
    for (std::size_t i = 0; i < crust.size(); ++i) {
      if (crust.normals[i].z() < 0.8F) continue;
      for (const uint32_t other : test::neighborsOf(crust, i)) {
        links += crust.normals[other].z() < 0.8F ? 1 : 0;
      }
    }
    EXPECT_GT(links, 30u);
  }
}

/// How many cells of two sheets, at heights of `low` and `low + gap`, have links across.
std::size_t linksBetweenSheets(double low, double gap, double tilt, TestRandom* random) {
  const Vector3d normal = test::tilted(tilt, 35.0);
  const PlaneFrame first(low * normal, normal);
  const PlaneFrame second((low + gap) * normal, normal);
  const Crust crust = crustOf(test::joined(test::patch(first, 40, 40, 10000, 0.05, random),
                                           test::patch(second, 40, 40, 10000, 0.05, random)));
  test::expectSoundCrust(crust, {0, 0, 500});
  std::size_t links = 0;
  for (std::size_t i = 0; i < crust.size(); ++i) {
    const bool above = first.height(crust.positions[i].cast<double>()) > 0.5 * gap;
    for (const uint32_t other : test::neighborsOf(crust, i)) {
      links += above != (first.height(crust.positions[other].cast<double>()) > 0.5 * gap) ? 1 : 0;
    }
  }
  return links;
}

TEST(SurfelCrust, SheetsThreeCellsApartAreNotLinked) {
  TestRandom random(7);
  for (const double gap : {3.2, 4.0, 6.5}) {
    for (const double low : {0.0, 0.25, 0.5, 0.9}) {
      EXPECT_EQ(linksBetweenSheets(low, gap, 0.0, &random), 0u) << low << " " << gap;
      EXPECT_EQ(linksBetweenSheets(low, gap, 20.0, &random), 0u) << low << " " << gap;
    }
  }
}

TEST(SurfelCrust, SidesOfAThinWallSeenFromBetweenAreNotLinked) {
  // A sensor in the gap sees both sides: their normals are opposite.
  TestRandom random(8);
  for (const double gap : {3.0, 4.0}) {
    const Cloud left = test::patch({{-0.5 * gap, 0, 20}, {1, 0, 0}}, 40, 40, 10000, 0.02, &random);
    const Cloud right = test::patch({{0.5 * gap, 0, 20}, {1, 0, 0}}, 40, 40, 10000, 0.02, &random);
    const Crust crust = crustOf(test::joined(left, right), {0, 0, 20});
    test::expectSoundLinks(crust);
    for (std::size_t i = 0; i < crust.size(); ++i) {
      ASSERT_LT(crust.normals[i].x() * crust.positions[i].x(), 0.0F);
      for (const uint32_t other : test::neighborsOf(crust, i)) {
        ASSERT_GT(crust.positions[i].x() * crust.positions[other].x(), 0.0F);
      }
    }
  }
}

/// Cells at which a straight way over the ground from the first to the last line has none.
std::size_t holesBetween(const Crust& crust, int low, int high) {
  std::set<std::array<int, 2>> columns;
  for (std::size_t i = 0; i < crust.size(); ++i) columns.insert(test::columnOf(crust, i, 2));
  std::size_t holes = 0;
  const int origin = static_cast<int>(GridFrame::kOriginCell);
  for (int x = -30; x < 30; ++x) {
    for (int y = low; y < high; ++y) holes += 1 - columns.count({origin + x, origin + y});
  }
  return holes;
}

TEST(SurfelCrust, GapsBetweenScanLinesAreBridged) {
  TestRandom random(9);
  for (const double gap : {2.5, 4.0, 5.5, 7.0, 8.0}) {
    Cloud cloud;
    for (int line = 0; line < 8; ++line) {
      cloud = test::joined(
          cloud, test::segment({-40, gap * line, 0.4}, {40, gap * line, 0.4}, 1000, 0.03, &random));
    }
    const Crust crust = crustOf(cloud);
    test::expectSoundCrust(crust, {0, 0, 500});
    EXPECT_EQ(test::countParts(crust), 1u) << gap;
    EXPECT_EQ(holesBetween(crust, 2, static_cast<int>(7 * gap) - 2), 0u) << gap;
    for (std::size_t i = 0; i < crust.size(); ++i) {
      ASSERT_NEAR(crust.positions[i].z(), 0.4F, 0.4F);
    }
  }
}

TEST(SurfelCrust, RingsOfASpinningLadarOnTheGroundAreBridged) {
  // Beams of 15 to 9 degrees below the horizon, 2 m over the ground, cells of 0.3 m: gaps of 4 to 8
  // cells.
  TestRandom random(10);
  std::vector<double> radii;
  for (const double degrees : {15.0, 13.0, 11.0, 9.0}) {
    radii.push_back(2.0 / std::tan(degrees * M_PI / 180.0));
  }
  const GriddedCloud gridded(test::rings(radii, 1800, 0.01, &random), test::gridFrame(0.3));
  const Vector3f sensor(0, 0, 2.0F / 0.3F);
  const Crust crust = crustOf(gridded, sensor);
  test::expectSoundCrust(crust, sensor);
  EXPECT_EQ(test::countParts(crust), 1u);
  const double area = M_PI * (radii.back() * radii.back() - radii.front() * radii.front());
  EXPECT_NEAR(crust.area_m2() / area, 1.15, 0.2);  // and a little beyond the outermost
  for (std::size_t i = 0; i < crust.size(); ++i) {
    ASSERT_NEAR(0.3F * crust.positions[i].z(), 0.0F, 0.1F);
    const double radius = 0.3 * crust.positions[i].head<2>().norm();
    ASSERT_GT(radius, radii.front() - 1.8);
    ASSERT_LT(radius, radii.back() + 1.2);
    if (radius < radii.front() + 0.5 || radius > radii.back() - 0.5) continue;
    ASSERT_GT(crust.normals[i].z(), 0.95F);
  }
}

TEST(SurfelCrust, FoliageIsNotBridged) {
  TestRandom random(11);
  for (const std::size_t count : {1000u, 3000u}) {
    const Cloud leaves = test::ball({0, 0, 0}, 25, count, &random);
    const GriddedCloud gridded(leaves);
    const Crust crust = crustOf(gridded, {0, 0, 500});
    test::expectSoundCrust(crust, {0, 0, 500});
    ASSERT_GT(crust.size(), count / 3);
    ASSERT_LT(crust.size(), 3 * count);
    std::size_t far = 0;  // from every point
    for (const Vector3f& p : crust.positions) {
      double least2 = 1e9;
      for (const Vector3d& leaf : leaves) {
        least2 = std::min(least2, (leaf - p.cast<double>()).squaredNorm());
      }
      far += least2 > 2.0 * 2.0 ? 1 : 0;
    }
    EXPECT_LT(far, crust.size() / 50) << count;
  }
}

TEST(SurfelCrust, AWireStaysALine) {
  TestRandom random(12);
  for (const Vector3d& along : {Vector3d(1, 0, 0), Vector3d(1, 0.3, 0.1), Vector3d(1, 1, 1)}) {
    const Vector3d direction = along.normalized();
    const Vector3d middle(0.4, 0.2, 0.7);
    const Crust crust = crustOf(
        test::segment(middle - 30 * direction, middle + 30 * direction, 600, 0.02, &random));
    test::expectSoundCrust(crust, {0, 0, 500});
    EXPECT_EQ(test::countParts(crust), 1u) << along.transpose();
    EXPECT_LT(crust.size(), 2.5 * 60.0);
    double low = 0.0;
    double high = 0.0;
    for (const Vector3f& p : crust.positions) {
      const Vector3d d = p.cast<double>() - middle;
      const double s = d.dot(direction);
      low = std::min(low, s);
      high = std::max(high, s);
      ASSERT_LT((d - s * direction).norm(), 1.5) << along.transpose();
    }
    EXPECT_NEAR(low, -30.0, 1.5);
    EXPECT_NEAR(high, 30.0, 1.5);
  }
}

TEST(SurfelCrust, WeightsAreThoseOfThePoints) {
  TestRandom random(13);
  const Cloud cloud = test::patch({}, 40, 40, 10000, 0.05, &random);
  std::vector<float> weights;
  for (const Vector3d& p : cloud) weights.push_back(p.x() < 0.0 ? 0.09F : 1.0F);
  const Crust crust = crustOf(GriddedCloud(cloud, test::gridFrame(1.0), weights), {0, 0, 500});
  for (std::size_t i = 0; i < crust.size(); ++i) {
    ASSERT_GE(crust.weight(i), 0.0899F);
    ASSERT_LE(crust.weight(i), 1.0001F);
    if (crust.positions[i].x() < -4.0F) {
      ASSERT_NEAR(crust.weight(i), 0.09F, 1e-4F);
    }
    if (crust.positions[i].x() > 4.0F) {
      ASSERT_NEAR(crust.weight(i), 1.0F, 1e-4F);
    }
  }
}

TEST(SurfelCrust, OfFewPoints) {
  const Crust none = crustOf(Cloud());
  EXPECT_EQ(none.size(), 0u);
  EXPECT_EQ(none.area_m2(), 0.0);
  test::expectSoundLinks(none);
  const Cloud three = {{0.5, 0.5, 0.5}, {40.5, 0.5, 0.5}, {0.5, 40.5, 9.5}};
  for (std::size_t count = 1; count <= 3; ++count) {
    const Crust crust = crustOf({three.begin(), three.begin() + std::ptrdiff_t(count)});
    test::expectSoundCrust(crust, {0, 0, 500});
    ASSERT_GE(crust.size(), count);
    EXPECT_EQ(test::countParts(crust), count);
    for (std::size_t i = 0; i < count; ++i) {
      const bool near = std::any_of(
          crust.positions.begin(), crust.positions.end(),
          [&](const Vector3f& p) { return (p.cast<double>() - three[i]).norm() < 0.5; });
      EXPECT_TRUE(near) << i;
    }
  }
}

TEST(SurfelCrust, OfEqualPointsIsAFewCellsAround) {
  for (const std::size_t count : {2u, 8u, 1000u}) {
    const Vector3d place(7.3, -2.2, 9.9);
    const Crust crust = crustOf(Cloud(count, place));
    test::expectSoundCrust(crust, {0, 0, 500});
    ASSERT_GE(crust.size(), 1u);
    ASSERT_LE(crust.size(), 4u);
    for (const Vector3f& p : crust.positions) ASSERT_LT((p.cast<double>() - place).norm(), 1.5);
  }
}

TEST(SurfelCrust, IsTheSameForAnyNumberOfThreads) {
  TestRandom random(14);
  const Cloud cloud =
      test::joined(test::patch({{0, 0, 0}, {1, 2, 3}}, 120, 120, 60000, 0.2, &random),
                   test::ball({40, 40, 40}, 30, 8000, &random));
  const GriddedCloud gridded(cloud);
  const Crust one = crustOf(gridded, {0, 0, 500});
  test::expectSameCrust(one, crustOf(gridded, {0, 0, 500}, 2));
  test::expectSameCrust(one, crustOf(gridded, {0, 0, 500}, 4));
}

TEST(SurfelCrust, OfACloudFarFromTheOriginIsTheSame) {
  TestRandom random(15);
  Cloud near = test::patch({{0, 0, 0}, {1, 2, 3}}, 6, 6, 20000, 0.02, &random);
  for (Vector3d& p : near) p = (p * 4096.0).array().round() / 4096.0;
  const Vector3d offset(1048576.0, -1048576.0, 4096.0);
  Cloud far = near;
  for (Vector3d& p : far) p += offset;
  const Vector3f sensor(0, 0, 500);
  const Crust here = crustOf(GriddedCloud(near, test::gridFrame(0.1)), sensor);
  const Crust there = crustOf(GriddedCloud(far, test::gridFrame(0.1, offset)), sensor);
  test::expectSameCrust(here, there);
  EXPECT_EQ(here.area_m2(), there.area_m2());
}

}  // namespace
}  // namespace ladar_perception
