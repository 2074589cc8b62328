// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "ladar_perception/map/moments.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::TestRandom;
__extension__ using Int128 = __int128;  // the oracle's integers, wide enough for anything here

struct WideMoments {
  Int128 n = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

/// Adds `times` copies of a point.
void addTo(WideMoments* m, const FixedPoint& q, const FixedPoint& center, Int128 times = 1) {
  const Int128 x = q.x - center.x;
  const Int128 y = q.y - center.y;
  const Int128 z = q.z - center.z;
  m->n += times;
  m->x += times * x;
  m->y += times * y;
  m->z += times * z;
  m->xx += times * x * x;
  m->xy += times * x * y;
  m->xz += times * x * z;
  m->yy += times * y * y;
  m->yz += times * y * z;
  m->zz += times * z * z;
}

bool equal(const CenteredMoments& m, const WideMoments& w) {
  return m.n == w.n && m.x == w.x && m.y == w.y && m.z == w.z && m.xx == w.xx && m.xy == w.xy &&
         m.xz == w.xz && m.yy == w.yy && m.yz == w.yz && m.zz == w.zz;
}

/// n copies of the sum, by doubling.
Moments times(const Moments& moments, uint32_t n) {
  Moments sum;
  Moments power = moments;
  for (; n != 0; n >>= 1) {
    if ((n & 1) != 0) sum += power;
    power += Moments(power);
  }
  return sum;
}

std::vector<FixedPoint> randomPoints(TestRandom* random, const FixedPoint& around, int64_t reach,
                                     int count) {
  std::vector<FixedPoint> points;
  for (int i = 0; i < count; ++i) {
    const int64_t x = around.x + random->integer(-reach, reach);
    const int64_t y = around.y + random->integer(-reach, reach);
    points.push_back({x, y, around.z + random->integer(-reach, reach)});
  }
  return points;
}

Moments sumOf(const std::vector<FixedPoint>& points) {
  Moments sum;
  for (const FixedPoint& q : points) sum.add(q);
  return sum;
}

/// Places near the origin and up to 10^7 m away at voxels of 1 cm, on all sides.
std::vector<FixedPoint> places() {
  const int64_t far = 256'000'000'000;  // 1e7 m / 0.01 m * 256
  return {{0, 0, 0},       {-1, 1, -1},        {256, -256, 128},     {2560000000, -2560000000, 0},
          {far, far, far}, {-far, -far, -far}, {-far, far, 25600000}};
}

TEST(Moments, StartEmpty) {
  const Moments moments;
  EXPECT_EQ(moments.count(), 0U);
  EXPECT_TRUE(equal(moments.about({1000, -2000, 3000}), WideMoments()));
}

TEST(Moments, AboutACentreEqualsTheWideSumsEverywhere) {
  TestRandom random(1);
  for (const FixedPoint& place : places()) {
    for (const int count : {1, 2, 3, 17, 500}) {
      const auto points = randomPoints(&random, place, 4 * kStepsPerVoxel + 128, count);
      const FixedPoint center = centerOf(voxelOf(place));
      WideMoments expected;
      for (const FixedPoint& q : points) addTo(&expected, q, center);
      EXPECT_TRUE(equal(sumOf(points).about(center), expected)) << place.x << " " << count;
    }
  }
}

TEST(Moments, AnyOrderOfAddingGivesTheSameBits) {
  TestRandom random(2);
  for (const FixedPoint& place : places()) {
    auto points = randomPoints(&random, place, 1000, 300);
    const Moments forward = sumOf(points);
    std::shuffle(points.begin(), points.end(), random.engine());
    EXPECT_EQ(forward, sumOf(points));
    Moments halves = sumOf({points.begin() + 100, points.end()});
    halves += sumOf({points.begin(), points.begin() + 100});
    EXPECT_EQ(forward, halves);
  }
}

TEST(Moments, SubtractingTakesOutExactlyWhatWasAdded) {
  TestRandom random(3);
  for (const FixedPoint& place : places()) {
    const auto points = randomPoints(&random, place, 1000, 200);
    const Moments first = sumOf({points.begin(), points.begin() + 80});
    const Moments second = sumOf({points.begin() + 80, points.end()});
    Moments sum = first;
    sum += second;
    sum -= first;
    EXPECT_EQ(sum, second);
    sum -= second;
    EXPECT_EQ(sum, Moments());
  }
}

TEST(Moments, SumsMayPassThroughNegativeCounts) {
  TestRandom random(4);
  const auto points = randomPoints(&random, {-2560000000, 5, 7}, 1000, 100);
  Moments sum;
  sum -= sumOf(points);
  sum += sumOf(points);
  sum += sumOf(points);
  EXPECT_EQ(sum, sumOf(points));
}

TEST(Moments, DifferWhenAnyPointDiffers) {
  const Moments one = sumOf({{1, 2, 3}, {4, 5, 6}});
  EXPECT_NE(one, sumOf({{1, 2, 3}, {4, 5, 7}}));
  EXPECT_NE(one, sumOf({{1, 2, 3}}));
  EXPECT_FALSE(one != sumOf({{4, 5, 6}, {1, 2, 3}}));
}

TEST(Moments, CentreOfAVoxelIsItsMiddle) {
  const FixedPoint center = centerOf({-1, 0, 10000000});
  EXPECT_EQ(center.x, -128);
  EXPECT_EQ(center.y, 128);
  EXPECT_EQ(center.z, 2560000128);
}

TEST(MaxPointsPerVoxel, AreThoseOfTheMethodOrMore) {
  EXPECT_GE(maxPointsPerVoxel(4), 2500U);
  EXPECT_GE(maxPointsPerVoxel(5), 1145U);
  EXPECT_GE(maxPointsPerVoxel(6), 587U);
}

/// Points of a support volume filled to the cap, all as far from its middle as they can be:
/// `high[i]` tells for axis i which share of the points is at the upper face, in eighths.
struct Corners {
  int high[3];
  bool diagonal;  // the same points are high on every axis
};

class Cap : public testing::TestWithParam<int> {
 protected:
  /// Checks one filling of the support volume around `voxel` against 128-bit integers.
  void check(const VoxelIndex& voxel, const Corners& corners) const {
    const int64_t k = 2 * GetParam() + 1;
    const auto n = static_cast<uint32_t>(maxPointsPerVoxel(GetParam()) * k * k * k);
    const FixedPoint center = centerOf(voxel);
    const int64_t low = -kStepsPerVoxel / 2 * k;
    const int64_t high = kStepsPerVoxel / 2 * k - 1;
    Moments sum;
    WideMoments expected;
    for (uint32_t eighth = 0; eighth < 8; ++eighth) {
      const uint32_t part = n / 8 + (eighth == 0 ? n % 8 : 0);
      const auto at = [&](int axis) {
        const int index = corners.diagonal ? static_cast<int>(eighth)
                                           : static_cast<int>((eighth * (axis * 2 + 1)) % 8);
        return index < corners.high[axis] ? high : low;
      };
      const FixedPoint q = {center.x + at(0), center.y + at(1), center.z + at(2)};
      Moments one;
      one.add(q);
      sum += times(one, part);
      addTo(&expected, q, center, part);
    }
    expectExact(sum.about(center), expected);
  }

 private:
  static void expectExact(const CenteredMoments& m, const WideMoments& w) {
    ASSERT_TRUE(equal(m, w));
    // What saliency.cpp computes from them in 64 bits must not overflow either.
    const auto same = [&](int64_t ab, int64_t a, int64_t b, Int128 exact) {
      int64_t product = 0;
      int64_t square = 0;
      int64_t difference = 0;
      ASSERT_FALSE(__builtin_mul_overflow(m.n, ab, &product));
      ASSERT_FALSE(__builtin_mul_overflow(a, b, &square));
      ASSERT_FALSE(__builtin_sub_overflow(product, square, &difference));
      ASSERT_TRUE(difference == exact);
    };
    same(m.xx, m.x, m.x, w.n * w.xx - w.x * w.x);
    same(m.xy, m.x, m.y, w.n * w.xy - w.x * w.y);
    same(m.xz, m.x, m.z, w.n * w.xz - w.x * w.z);
    same(m.yy, m.y, m.y, w.n * w.yy - w.y * w.y);
    same(m.yz, m.y, m.z, w.n * w.yz - w.y * w.z);
    same(m.zz, m.z, m.z, w.n * w.zz - w.z * w.z);
  }
};

TEST_P(Cap, SumsInExtremeCornersAreExact) {
  for (const VoxelIndex& voxel : {VoxelIndex{0, 0, 0}, VoxelIndex{10000000, -10000000, 1000000},
                                  VoxelIndex{-1000000000, 1000000000, -1000000000}}) {
    for (const bool diagonal : {true, false}) {
      for (int x = 0; x <= 8; ++x) {
        for (int y = 0; y <= 8; y += 2) {
          for (int z = 0; z <= 8; z += 4) check(voxel, {{x, y, z}, diagonal});
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(SupportRadii, Cap, testing::Range(1, 7));

}  // namespace
}  // namespace ladar_perception
