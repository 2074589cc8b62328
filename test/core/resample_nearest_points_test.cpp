// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "crust_clouds.h"
#include "ladar_perception/resample/nearest_points.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::GriddedCloud;
using test::TestRandom;
using Places = std::vector<Vector3f>;

uint32_t nearestOfAll(const GridPoints& points, const Vector3f& place) {
  uint32_t nearest = 0;
  for (uint32_t i = 1; i < points.size(); ++i) {
    const float d2 = (points.positions[i] - place).squaredNorm();
    if (d2 < (points.positions[nearest] - place).squaredNorm()) nearest = i;
  }
  return nearest;
}

void expectNearest(const GriddedCloud& gridded, const Places& places) {
  ThreadPool one(1);
  const std::vector<uint32_t> nearest =
      nearestPoints(gridded.points, gridded.pyramid, places, &one);
  ASSERT_EQ(nearest.size(), places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_EQ(nearest[i], nearestOfAll(gridded.points, places[i])) << places[i].transpose();
  }
  ThreadPool three(3);
  ASSERT_EQ(nearestPoints(gridded.points, gridded.pyramid, places, &three), nearest);
}

Places randomPlaces(std::size_t count, double reach, TestRandom* random) {
  Places places;
  for (std::size_t i = 0; i < count; ++i)
    places.push_back((reach * random->normal3()).cast<float>());
  return places;
}

TEST(NearestPoints, AgreeWithBruteForce) {
  TestRandom random(1);
  for (const double spread : {0.3, 3.0, 30.0}) {
    Cloud cloud;
    for (int i = 0; i < 800; ++i) cloud.push_back(spread * random.normal3());
    for (const int levels : {1, 2, 4, 8}) {
      const GriddedCloud gridded(cloud, test::gridFrame(1.0), {}, levels);
      expectNearest(gridded, randomPlaces(300, spread, &random));
      expectNearest(gridded, randomPlaces(300, 10.0 * spread, &random));
    }
  }
}

TEST(NearestPoints, OfManyPlacesOnAPlane) {
  TestRandom random(2);
  const test::PlaneFrame plane({3, 4, 5}, Vector3d(1, 1, 3));
  const Cloud on_plane = test::patch(plane, 40, 40, 3000, 0.1, &random);
  Places places;
  for (const Vector3d& p : test::patch(plane, 44, 44, 3000, 0.5, &random)) {
    places.push_back(p.cast<float>());
  }
  expectNearest(GriddedCloud(on_plane), places);
}

TEST(NearestPoints, OfSeveralTheFirst) {
  // A lattice and the middles between its points: ties in every direction, across cells and
  // levels, at both signs; every point twice.
  Cloud cloud;
  for (int n = 0; n < 2; ++n) {
    for (int z = -2; z <= 2; ++z) {
      for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) cloud.emplace_back(2 * x, 2 * y, 2 * z);
      }
    }
  }
  Places places;
  for (int n = 0; n < 11 * 11 * 11; ++n) {
    places.emplace_back(static_cast<float>(n % 11 - 5), static_cast<float>(n / 11 % 11 - 5),
                        static_cast<float>(n / 121 - 5));
  }
  expectNearest(GriddedCloud(cloud), places);
  for (Vector3f& place : places) place *= 2.0F;
  expectNearest(GriddedCloud(cloud), places);
  for (Vector3f& place : places) place *= 0.25F;
  expectNearest(GriddedCloud(cloud), places);
}

TEST(NearestPoints, OnTheBordersOfCells) {
  TestRandom random(3);
  Cloud cloud;
  Places places;
  const auto border = [&] { return static_cast<double>(random.integer(-9, 9)); };
  const auto either = [&] { return random.integer(0, 1) == 0 ? border() : random.real(-9.0, 9.0); };
  for (int i = 0; i < 500; ++i) {
    const double x = either();
    const double y = either();
    cloud.emplace_back(x, y, either());
    const double u = either();
    const double v = either();
    places.push_back(Vector3d(u, v, either()).cast<float>());
  }
  expectNearest(GriddedCloud(cloud), places);
}

TEST(NearestPoints, OfOneTwoAndEqualPoints) {
  TestRandom random(4);
  const Places places = randomPlaces(100, 20.0, &random);
  expectNearest(GriddedCloud({{1, 2, 3}}), places);
  expectNearest(GriddedCloud({{1, 2, 3}, {-4, 0, 9}}), places);
  expectNearest(GriddedCloud(Cloud(50, Vector3d(1, 2, 3))), places);
  expectNearest(GriddedCloud({{1, 2, 3}}), {});
}

TEST(NearestPoints, InWideGaps) {
  TestRandom random(6);
  for (const double gap : {12.0, 25.0, 60.0, 140.0}) {
    Cloud cloud;
    for (int i = 0; i < 60; ++i) {
      cloud.push_back(gap * Vector3d(i % 4, i / 4 % 4, i / 16) + random.normal3());
    }
    expectNearest(GriddedCloud(cloud), randomPlaces(400, 4.0 * gap, &random));
  }
}

TEST(NearestPoints, OfPlacesFarAway) {
  TestRandom random(5);
  Cloud cloud;
  for (int i = 0; i < 50; ++i) cloud.push_back(Vector3d(-1e5, 1e5, 2e5) + 30.0 * random.normal3());
  Places places = randomPlaces(50, 1000.0, &random);
  places.emplace_back(-4e5F, -4e5F, -4e5F);
  places.emplace_back(5e5F, 5e5F, 5e5F);
  places.emplace_back(-1e5F, 1e5F, 2e5F);
  expectNearest(GriddedCloud(cloud), places);
}

}  // namespace
}  // namespace ladar_perception
