// SPDX-License-Identifier: BSD-3-Clause
// Clouds that are hardly clouds, or that lie far away.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "resample_clouds.h"

namespace ladar_perception {
namespace {

using namespace test;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What holds for every result, of whatever cloud.
void expectConsistent(const ResampledCloud& samples, const PoseCloudData& cloud) {
  EXPECT_EQ(samples.normals.size(), samples.size());
  EXPECT_EQ(samples.sources.size(), samples.size());
  EXPECT_EQ(samples.covering_radii.size(), samples.size());
  EXPECT_EQ(samples.weights.size(), samples.size());
  EXPECT_EQ(samples.points_in, cloud.positions_m.size());
  EXPECT_LE(samples.points_finite, samples.points_in);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_TRUE(samples.positions_m[i].allFinite());
    EXPECT_NEAR(samples.normals[i].norm(), 1.0f, 1e-4f);
    ASSERT_LT(samples.sources[i], cloud.positions_m.size());
    EXPECT_TRUE(cloud.positions_m[samples.sources[i]].allFinite());
    EXPECT_GT(samples.weights[i], 0.0f);
  }
}

class ResampleDegenerate : public testing::TestWithParam<std::string> {
 protected:
  static ResampleConfig config(int count, int min_component_points = 1) {
    ResampleConfig config = countConfig(count, GetParam());
    config.min_component_points = min_component_points;
    return config;
  }
};

TEST_P(ResampleDegenerate, NoPointsGiveNoSamples) {
  for (const int least : {1, 5}) {
    const ResampledCloud samples = resampled(config(10, least), {});
    EXPECT_EQ(samples.size(), 0u);
    EXPECT_EQ(samples.cells, 0u);
    expectConsistent(samples, {});
  }
}

/// 1, 2 and 3 points, near one another, far apart, in a line.
TEST_P(ResampleDegenerate, FewPointsGiveFewSamples) {
  const std::vector<std::vector<Eigen::Vector3d>> clouds = {{{1, 2, 3}},
                                                            {{1, 2, 3}, {1.001, 2, 3}},
                                                            {{1, 2, 3}, {100, 2, 3}},
                                                            {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}},
                                                            {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  for (const auto& points : clouds) {
    PoseCloudData cloud;
    cloud.positions_m = points;
    cloud.sensor_m = Eigen::Vector3d(0, 0, 10);
    const ResampledCloud samples = resampled(config(10), cloud);
    EXPECT_GE(samples.size(), 1u);
    EXPECT_LE(samples.size(), 10u);
    expectConsistent(samples, cloud);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Eigen::Vector3d& nearest = cloud.positions_m[samples.sources[i]];
      EXPECT_LT((samples.positions_m[i] - nearest).norm(), 4.0 * samples.cell_size_m);
    }
    // Islands of so few points are taken for noise unless asked for.
    expectConsistent(resampled(config(10, 5), cloud), cloud);
  }
}

TEST_P(ResampleDegenerate, ASinglePointIsItsOwnSample) {
  PoseCloudData cloud;
  cloud.positions_m = {{1.0, 2.0, 3.0}};
  const ResampledCloud samples = resampled(config(1), cloud);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_LT((samples.positions_m[0] - cloud.positions_m[0]).norm(), samples.cell_size_m);
  EXPECT_EQ(samples.sources[0], 0u);
}

TEST_P(ResampleDegenerate, DuplicatesAreOnePlace) {
  PoseCloudData cloud;
  cloud.positions_m.assign(1000, Eigen::Vector3d(5.0, -3.0, 2.0));
  for (const int least : {1, 5}) {
    const ResampledCloud samples = resampled(config(10, least), cloud);
    ASSERT_GE(samples.size(), 1u);
    expectConsistent(samples, cloud);
    EXPECT_LT((samples.positions_m[0] - cloud.positions_m[0]).norm(), samples.cell_size_m);
  }
}

TEST_P(ResampleDegenerate, ALineIsSampledAlongItsLength) {
  PoseCloudData cloud;
  for (int i = 0; i < 2000; ++i) cloud.positions_m.emplace_back(0.005 * i, 0.0, 3.0);
  const ResampledCloud samples = resampled(config(40), cloud);
  EXPECT_EQ(samples.size(), 40u);
  expectConsistent(samples, cloud);
  std::vector<double> along;
  for (const Eigen::Vector3d& p : samples.positions_m) along.push_back(p.x());
  std::sort(along.begin(), along.end());
  EXPECT_LT(along.front(), 0.5);
  EXPECT_GT(along.back(), 9.5);
  for (std::size_t i = 1; i < along.size(); ++i) EXPECT_LT(along[i] - along[i - 1], 0.6);
}

TEST_P(ResampleDegenerate, PointsThatAreNotFiniteAreAsIfNotThere) {
  Sheet sheet;
  sheet.points = 5000;
  const PoseCloudData clean = sheetCloud(sheet);
  PoseCloudData dirty;
  dirty.sensor_m = clean.sensor_m;
  std::vector<uint32_t> clean_index;
  for (uint32_t i = 0; i < clean.positions_m.size(); ++i) {
    const std::vector<Eigen::Vector3d> bad = {
        {kNaN, 0, 0}, {0, kNaN, kNaN}, {0, 0, kInfinity}, {-kInfinity, 0, 0}};
    if (i % 3 == 0) {
      dirty.positions_m.push_back(bad[i % 4]);
      clean_index.push_back(0);
    }
    dirty.positions_m.push_back(clean.positions_m[i]);
    clean_index.push_back(i);
  }
  const ResampledCloud expected = resampled(config(300), clean);
  const ResampledCloud samples = resampled(config(300), dirty);
  expectConsistent(samples, dirty);
  EXPECT_EQ(samples.points_finite, clean.positions_m.size());
  ASSERT_EQ(samples.positions_m, expected.positions_m);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(clean_index[samples.sources[i]], expected.sources[i]);
  }
}

TEST_P(ResampleDegenerate, NothingButNaNGivesNoSamples) {
  PoseCloudData cloud;
  cloud.positions_m.assign(100, Eigen::Vector3d::Constant(kNaN));
  cloud.rgb.assign(100, 0x102030u);
  const ResampledCloud samples =
      resampled(config(10), cloud, {makePolicy("color:target=#102030"), makePolicy("range")});
  EXPECT_EQ(samples.size(), 0u);
  EXPECT_EQ(samples.points_in, 100u);
  EXPECT_EQ(samples.points_finite, 0u);
}

/// Coordinates as on a map, 1000 km from its origin.
TEST_P(ResampleDegenerate, PlacesFarFromTheOriginAreSampledAlike) {
  Sheet sheet;
  sheet.points = 20000;
  sheet.noise_m = 0.01;
  PoseCloudData near = sheetCloud(sheet);
  // To multiples of 2^-13 m, so that moving is exact.
  for (Eigen::Vector3d& p : near.positions_m) p = (p * 8192.0).array().round() / 8192.0;
  PoseCloudData far = near;
  const Eigen::Vector3d offset(1048576.0, -1048576.0, 4096.0);
  for (Eigen::Vector3d& p : far.positions_m) p += offset;
  far.sensor_m += offset;
  const ResampledCloud expected = resampled(config(1000), near);
  const ResampledCloud samples = resampled(config(1000), far);
  ASSERT_EQ(samples.size(), expected.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ASSERT_LT((samples.positions_m[i] - offset - expected.positions_m[i]).norm(), 1e-6);
  }
}

/// One point far away does not spoil the grid of the others.
TEST_P(ResampleDegenerate, OutliersFarAwayDoNotMatter) {
  Sheet sheet;
  sheet.points = 20000;
  PoseCloudData cloud = sheetCloud(sheet);
  cloud.positions_m.emplace_back(1e7, 0.0, 0.0);
  cloud.positions_m.emplace_back(0.0, -1e30, 0.0);
  const ResampledCloud samples = resampled(config(1000, 5), cloud);
  ASSERT_EQ(samples.size(), 1000u);
  for (const Eigen::Vector3d& p : samples.positions_m) EXPECT_LT(p.norm(), 15.0);
}

INSTANTIATE_TEST_SUITE_P(Engines, ResampleDegenerate, testing::Values("fast_marching", "flood"),
                         [](const auto& test_case) { return test_case.param; });

}  // namespace
}  // namespace ladar_perception
