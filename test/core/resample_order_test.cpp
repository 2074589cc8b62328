// SPDX-License-Identifier: BSD-3-Clause
// How many samples, in which order, how far apart: what ResampledCloud says of itself is true.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "ladar_perception/resample/sampling_quality.h"
#include "resample_clouds.h"

namespace ladar_perception {
namespace {

using namespace test;

class ResampleOrder : public testing::TestWithParam<std::string> {
 protected:
  static ResampleConfig config(int count) { return countConfig(count, GetParam()); }
  static Sheet noisySheet() {
    Sheet sheet;
    sheet.points = 100000;
    sheet.noise_m = 0.015;
    sheet.pose = Eigen::Isometry3d(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 1, 0).normalized()));
    return sheet;
  }
  static std::vector<Eigen::Vector3d> prefix(const ResampledCloud& samples, std::size_t count) {
    return {samples.positions_m.begin(),
            samples.positions_m.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  /// Places of the true surface, a third of `spacing_m` apart; those that noise puts beyond the rim
  /// of the crust are left out.
  static std::vector<Eigen::Vector3d> surface(const Sheet& sheet, double spacing_m) {
    constexpr double kRim_m = 0.02;
    std::vector<Eigen::Vector3d> places;
    for (double x = kRim_m; x <= sheet.length_m - kRim_m; x += spacing_m / 3.0) {
      for (double y = kRim_m; y <= sheet.width_m - kRim_m; y += spacing_m / 3.0) {
        places.push_back(sheet.pose * Eigen::Vector3d(x, y, 0.0));
      }
    }
    return places;
  }
};

TEST_P(ResampleOrder, CountsAreExact) {
  const PoseCloudData cloud = sheetCloud(noisySheet());
  for (const int count : {1, 2, 3, 4, 7, 10, 99, 100, 101, 5000}) {
    const ResampledCloud samples = resampled(config(count), cloud);
    EXPECT_EQ(samples.size(), static_cast<std::size_t>(count));
    EXPECT_EQ(samples.components, 1u);
  }
}

TEST_P(ResampleOrder, TwoThreadsGiveTheSameBytes) {
  const PoseCloudData cloud = sheetCloud(noisySheet());
  ResampleConfig one = config(10000);
  ResampleConfig two = one;
  two.threads = 2;
  ResampleConfig seven = one;
  seven.threads = 7;
  const Policies policies = {makePolicy("range:min=2"), makePolicy("normal_variation")};
  const ResampledCloud expected = resampled(one, cloud, policies);
  for (const ResampleConfig& many : {two, seven}) {
    const ResampledCloud samples = resampled(many, cloud, policies);
    EXPECT_TRUE(samples.positions_m == expected.positions_m);
    EXPECT_TRUE(samples.normals == expected.normals);
    EXPECT_TRUE(samples.sources == expected.sources);
    EXPECT_TRUE(samples.covering_radii == expected.covering_radii);
    EXPECT_TRUE(samples.weights == expected.weights);
    EXPECT_EQ(samples.cells, expected.cells);
  }
}

TEST_P(ResampleOrder, ASecondRunGivesTheSameBytes) {
  const PoseCloudData cloud = sheetCloud(noisySheet());
  CloudResampler resampler(config(3000));
  const ResampledCloud first = resampler.resample(cloud);
  resampler.resample(latticeCloud(50, 50, 0.1));
  const ResampledCloud again = resampler.resample(cloud);
  EXPECT_TRUE(again.positions_m == first.positions_m);
  EXPECT_TRUE(again.covering_radii == first.covering_radii);
}

TEST_P(ResampleOrder, PrefixesAreGoodSamplings) {
  const Sheet sheet = noisySheet();
  const ResampledCloud samples = resampled(config(6400), sheetCloud(sheet));
  ASSERT_EQ(samples.size(), 6400u);
  for (const std::size_t count : {100, 350, 1500, 6400}) {
    const std::vector<Eigen::Vector3d> chosen = prefix(samples, count);
    const bool all = count == samples.size();
    const SpacingStatistics spacing = spacingOf(chosen);
    EXPECT_GT(spacing.min_over_mean, all ? 0.8 : 0.6) << count;
    EXPECT_LT(spacing.cov, all ? 0.13 : 0.22) << count;
    const CoveringStatistics covering =
        coveringOf(chosen, surface(sheet, spacing.mean_m), spacing.mean_m);
    EXPECT_LT(covering.p99_over_spacing, all ? 0.85 : 1.05) << count;
  }
}

/// No place of the surface is farther from the samples than they say, and one is nearly that far.
TEST_P(ResampleOrder, CoveringRadiiAreTrue) {
  const Sheet sheet = noisySheet();
  const ResampledCloud samples = resampled(config(6400), sheetCloud(sheet));
  ASSERT_EQ(samples.size(), 6400u);
  EXPECT_TRUE(std::is_sorted(samples.covering_radii.rbegin(), samples.covering_radii.rend()));
  for (const std::size_t count : {1, 2, 5, 20, 100, 1000, 6400}) {
    const std::vector<Eigen::Vector3d> chosen = prefix(samples, count);
    const double spacing_m = std::sqrt(sheet.area() / static_cast<double>(count));
    const double farthest_m =
        coveringOf(chosen, surface(sheet, std::min(spacing_m, 0.3)), 1.0).distance_m.max;
    // Times are told of places in the middle of cells: others are up to half a diagonal farther.
    const double told_m = samples.covering_radii[count - 1];
    EXPECT_LT(farthest_m, 1.05 * told_m + 0.75 * samples.cell_size_m) << count;
    EXPECT_GT(farthest_m, 0.95 * told_m - 0.75 * samples.cell_size_m) << count;
  }
}

/// The next sample is the farthest place, or near to it: of a prefix, no two are much nearer than
/// its covering radius.
TEST_P(ResampleOrder, SamplesKeepTheirDistance) {
  const ResampledCloud samples = resampled(config(2000), sheetCloud(noisySheet()));
  for (const std::size_t count : {10, 100, 1000, 2000}) {
    const std::vector<double> distances = neighbourDistances(prefix(samples, count));
    const double nearest_m = *std::min_element(distances.begin(), distances.end());
    EXPECT_GT(nearest_m, 0.7 * samples.covering_radii[count - 1]) << count;
  }
}

TEST_P(ResampleOrder, StopsAtARadius) {
  const Sheet sheet = noisySheet();
  ResampleConfig by_radius = config(0);
  by_radius.radius_m = 0.2;
  const ResampledCloud samples = resampled(by_radius, sheetCloud(sheet));
  ASSERT_GT(samples.size(), 0u);
  EXPECT_LE(samples.covering_radii.back(), 0.2f);
  const double farthest_m =
      coveringOf(samples.positions_m, surface(sheet, 0.1), 1.0).distance_m.max;
  EXPECT_LT(farthest_m, 0.2 + samples.cell_size_m);
  // Farthest points with a covering radius r lie 1.2 to 1.3 r apart.
  EXPECT_NEAR(static_cast<double>(samples.size()), sheet.area() / (0.04 * 1.35), 600.0);
  // The first of two conditions counts.
  by_radius.count = 100;
  EXPECT_EQ(resampled(by_radius, sheetCloud(sheet)).size(), 100u);
  by_radius.count = 100000;
  EXPECT_EQ(resampled(by_radius, sheetCloud(sheet)).size(), samples.size());
}

TEST_P(ResampleOrder, SourcesAreTheNearestPoints) {
  Sheet sheet = noisySheet();
  sheet.points = 5000;
  const PoseCloudData cloud = sheetCloud(sheet);
  const ResampledCloud samples = resampled(config(300), cloud);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    double nearest_m = 1e9;
    for (const Eigen::Vector3d& p : cloud.positions_m) {
      nearest_m = std::min(nearest_m, (p - samples.positions_m[i]).norm());
    }
    const Eigen::Vector3d& source = cloud.positions_m[samples.sources[i]];
    EXPECT_NEAR((source - samples.positions_m[i]).norm(), nearest_m, 1e-4);
  }
}

TEST_P(ResampleOrder, NearestOriginalsAreOriginals) {
  const PoseCloudData cloud = sheetCloud(noisySheet());
  ResampleConfig originals = config(2000);
  originals.nearest_original = true;
  const ResampledCloud samples = resampled(originals, cloud);
  EXPECT_EQ(samples.size(), 2000u);
  std::set<uint32_t> different(samples.sources.begin(), samples.sources.end());
  EXPECT_EQ(different.size(), samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples.positions_m[i], cloud.positions_m[samples.sources[i]]);
  }
}

TEST_P(ResampleOrder, SamplesLieOnTheSurface) {
  const Sheet sheet = noisySheet();
  const PoseCloudData cloud = sheetCloud(sheet);
  const ResampledCloud samples = resampled(config(6400), cloud);
  double error_m = 0.0;
  int askew = 0;
  const Eigen::Vector3f up = (sheet.pose.linear() * Eigen::Vector3d::UnitZ()).cast<float>();
  for (std::size_t i = 0; i < samples.size(); ++i) {
    error_m += std::abs(sheet.toSheet(samples.positions_m[i]).z());
    if (samples.normals[i].dot(up) < 0.9f) ++askew;
  }
  // Some of the cells on the rim have few points to fit a plane to.
  EXPECT_LT(askew, 10);
  // The points' own mean error is 0.8 times their standard deviation.
  EXPECT_LT(error_m / static_cast<double>(samples.size()), 0.8 * sheet.noise_m / 3.0);
}

INSTANTIATE_TEST_SUITE_P(Engines, ResampleOrder, testing::Values("fast_marching", "flood"),
                         [](const auto& test_case) { return test_case.param; });

}  // namespace
}  // namespace ladar_perception
