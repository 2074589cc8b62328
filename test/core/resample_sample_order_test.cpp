// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "ladar_perception/resample/sample_order.h"
#include "test_random.h"

namespace ladar_perception::test {
namespace {

/// In rows, so that near ones are together.
std::vector<WeightedPlace> randomPlaces(int count, uint64_t seed, double slowest = 1.0) {
  TestRandom random(seed);
  std::vector<WeightedPlace> places;
  for (int i = 0; i < count; ++i) {
    places.push_back(
        {Eigen::Vector3d(0.1 * i + random.real(0, 5), random.real(0, 20), random.real(0, 3))
             .cast<float>(),
         static_cast<float>(random.real(1.0, slowest + 1e-9))});
  }
  return places;
}

float distance(const WeightedPlace& a, const WeightedPlace& b) {
  return (a.position - b.position).norm() * 0.5F * (a.slowness + b.slowness);
}

float toNearest(const WeightedPlace& place, const std::vector<WeightedPlace>& chosen) {
  float least = std::numeric_limits<float>::infinity();
  for (const WeightedPlace& other : chosen) least = std::min(least, distance(place, other));
  return least;
}

void expectFarthestFirst(const std::vector<WeightedPlace>& places,
                         const std::vector<WeightedPlace>& witnesses,
                         const std::vector<WeightedPlace>& before) {
  const PlaceOrder order = orderFarthestFirst(places, witnesses, before);
  std::vector<uint32_t> sorted = order.order;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(sorted.size(), places.size());
  for (uint32_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(sorted[i], i);
  ASSERT_EQ(order.covering.size(), places.size());
  ASSERT_EQ(order.covering_before.size(), before.size());
  std::vector<WeightedPlace> chosen;
  const auto expectCovering = [&](float told) {
    float farthest = 0.0F;
    for (const auto* list : {&places, &witnesses}) {
      for (const WeightedPlace& place : *list) {
        farthest = std::max(farthest, toNearest(place, chosen));
      }
    }
    EXPECT_NEAR(told, farthest, 1e-4F * farthest + 1e-5F) << chosen.size();
  };
  for (std::size_t i = 0; i < before.size(); ++i) {
    chosen.push_back(before[i]);
    expectCovering(order.covering_before[i]);
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    const WeightedPlace& next = places[order.order[i]];
    if (!chosen.empty()) {
      float farthest = 0.0F;
      for (const WeightedPlace& place : places) {
        farthest = std::max(farthest, toNearest(place, chosen));
      }
      EXPECT_NEAR(toNearest(next, chosen), farthest, 1e-4F * farthest) << i;
    }
    chosen.push_back(next);
    expectCovering(order.covering[i]);
  }
}

TEST(ResampleSampleOrder, IsThatOfBruteForce) {
  for (const int count : {1, 2, 15, 16, 17, 33, 150}) {
    expectFarthestFirst(randomPlaces(count, 1), randomPlaces(2 * count, 2), {});
  }
}

TEST(ResampleSampleOrder, SlownessCounts) {
  expectFarthestFirst(randomPlaces(150, 3, 6.0), randomPlaces(100, 4, 6.0), {});
}

TEST(ResampleSampleOrder, PlacesBeforeComeFirst) {
  expectFarthestFirst(randomPlaces(80, 5), randomPlaces(60, 6), randomPlaces(40, 7));
  expectFarthestFirst({}, randomPlaces(60, 6), randomPlaces(40, 7));
}

TEST(ResampleSampleOrder, WithoutWitnesses) { expectFarthestFirst(randomPlaces(50, 8), {}, {}); }

TEST(ResampleSampleOrder, Nothing) {
  const PlaceOrder order = orderFarthestFirst({}, {});
  EXPECT_TRUE(order.order.empty());
  EXPECT_TRUE(order.covering.empty());
}

TEST(ResampleSampleOrder, DuplicatesAreAllOrdered) {
  std::vector<WeightedPlace> places(40);
  const PlaceOrder order = orderFarthestFirst(places, places);
  std::vector<uint32_t> sorted = order.order;
  std::sort(sorted.begin(), sorted.end());
  for (uint32_t i = 0; i < 40; ++i) EXPECT_EQ(sorted[i], i);
  for (const float covering : order.covering) EXPECT_EQ(covering, 0.0F);
}

}  // namespace
}  // namespace ladar_perception::test
