// SPDX-License-Identifier: BSD-3-Clause
// Surfaces that samplings by fronts get wrong: sheets behind one another, islands, rings, ties.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "expect_error.h"
#include "ladar_perception/resample/sampling_quality.h"
#include "resample_clouds.h"

namespace ladar_perception {
namespace {

using namespace test;

class ResampleTraps : public testing::TestWithParam<std::string> {
 protected:
  static ResampleConfig config(int count) { return countConfig(count, GetParam()); }
};

constexpr double kCell_m = 0.05;

/// Level sheets of 4 x 4 m at heights.
PoseCloudData levelSheets(const std::vector<double>& heights_m) {
  PoseCloudData cloud;
  TestRandom random(2);
  for (const double z : heights_m) {
    Sheet sheet;
    sheet.length_m = sheet.width_m = 4.0;
    sheet.points = 60000;
    sheet.noise_m = 0.003;
    sheet.pose = Eigen::Translation3d(0.0, 0.0, z);
    addSheet(sheet, &random, &cloud);
  }
  cloud.sensor_m = Eigen::Vector3d(2.0, 2.0, 6.0);
  return cloud;
}

/// Fronts of one sheet never reach the other: each is sampled as if it were alone.
TEST_P(ResampleTraps, SheetsThreeCellsApartStayApart) {
  ResampleConfig with_cells = config(0);
  with_cells.cell_size_m = kCell_m;
  with_cells.radius_m = 0.15;
  const auto alone = static_cast<double>(resampled(with_cells, levelSheets({0.0})).size());
  EXPECT_GT(alone, 300.0);
  for (const double cells : {3.0, 3.5, 5.0}) {
    const double apart_m = cells * kCell_m;
    std::vector<int> counts(2, 0);
    const ResampledCloud samples = resampled(with_cells, levelSheets({0.0, apart_m}));
    for (const Eigen::Vector3d& p : samples.positions_m) {
      const bool upper = p.z() > 0.5 * apart_m;
      EXPECT_NEAR(p.z(), upper ? apart_m : 0.0, 0.3 * kCell_m) << cells << " cells apart";
      ++counts[upper ? 1 : 0];
    }
    EXPECT_NEAR(counts[0] / alone, 1.0, 0.05) << cells;
    EXPECT_NEAR(counts[1] / alone, 1.0, 0.05) << cells;
  }
}

/// Sheets that are nearer than two cells cannot be told apart everywhere. Samples lie on one, on
/// the other or between them, and not beyond.
TEST_P(ResampleTraps, SheetsACellApartMayBecomeOne) {
  ResampleConfig with_cells = config(800);
  with_cells.cell_size_m = kCell_m;
  for (const double cells : {0.3, 1.0, 2.0}) {
    const ResampledCloud samples = resampled(with_cells, levelSheets({0.0, cells * kCell_m}));
    EXPECT_EQ(samples.size(), 800u);
    for (const Eigen::Vector3d& p : samples.positions_m) {
      EXPECT_GT(p.z(), -0.5 * kCell_m) << cells;
      EXPECT_LT(p.z(), (cells + 0.5) * kCell_m) << cells;
    }
  }
}

/// No link leads from one sheet to the other, and still no two samples are nearer to each other
/// than on one sheet.
TEST_P(ResampleTraps, SamplesOfNearSheetsKeepTheirDistance) {
  for (const char* policy : {"uniform", "range:min=1"}) {
    for (const double apart_m : {0.08, 0.12, 0.16}) {
      const ResampledCloud samples =
          resampled(config(2500), levelSheets({0.0, apart_m}), {makePolicy(policy)});
      const SpacingStatistics spacing = spacingOf(samples.positions_m);
      const double least = policy == std::string("uniform") ? 0.75 : 0.6;
      EXPECT_GT(spacing.min_over_mean, least) << policy << " " << apart_m << " m apart";
    }
  }
}

/// Points between two depths are the farthest of all, and would be the first to be chosen.
TEST_P(ResampleTraps, IsolatedPointsGetNoSamples) {
  Sheet sheet;
  sheet.points = 40000;
  sheet.noise_m = 0.01;
  PoseCloudData cloud = sheetCloud(sheet);
  constexpr int kMixed = 92;  // 0.23 per cent
  for (int i = 0; i < kMixed; ++i) {
    // 3 m and more from one another.
    cloud.positions_m.emplace_back(1.0 * (i % 10), 1.0 * (i / 10),
                                   3.0 + 3.0 * (i % 10 % 3) + 9.0 * (i / 10 % 3));
  }
  const ResampledCloud samples = resampled(config(4000), cloud);
  EXPECT_EQ(samples.size(), 4000u);
  EXPECT_EQ(samples.components, 1u);
  EXPECT_EQ(samples.dropped_components, static_cast<uint64_t>(kMixed));
  for (const Eigen::Vector3d& p : samples.positions_m) EXPECT_LT(std::abs(p.z()), 0.1);

  ResampleConfig all_islands = config(4000);
  all_islands.min_component_points = 1;
  const ResampledCloud with_islands = resampled(all_islands, cloud);
  EXPECT_EQ(with_islands.components, 1u + kMixed);
  EXPECT_EQ(with_islands.size(), 4000u);
}

/// Nearer to a surface they are on its island, but still the farthest places of all.
TEST_P(ResampleTraps, LonePointsGetNoSamplesUnlessTheyAreMany) {
  Sheet sheet;
  sheet.points = 40000;
  sheet.noise_m = 0.01;
  const auto above = [&](int count) {
    PoseCloudData cloud = sheetCloud(sheet);
    for (int i = 0; i < count; ++i) {
      // Two and a half spacings over the sheet, as far or farther from one another.
      cloud.positions_m.emplace_back(0.5 + 0.45 * (i % 20), 0.5 + 0.45 * (i / 20), 0.45);
    }
    return cloud;
  };
  const auto high = [](const ResampledCloud& samples) {
    return std::count_if(samples.positions_m.begin(), samples.positions_m.end(),
                         [](const Eigen::Vector3d& p) { return p.z() > 0.2; });
  };
  const ResampledCloud samples = resampled(config(4000), above(100));
  EXPECT_EQ(samples.size(), 4000u);
  EXPECT_EQ(samples.lone_points, 100u);
  EXPECT_EQ(high(samples), 0);

  ResampleConfig all_points = config(4000);
  all_points.min_component_points = 1;
  const ResampledCloud with_all = resampled(all_points, above(100));
  EXPECT_EQ(with_all.lone_points, 0u);
  EXPECT_EQ(high(with_all), 100);

  // More than one in a hundred.
  const ResampledCloud many = resampled(config(4000), above(410));
  EXPECT_EQ(many.lone_points, 0u);
  EXPECT_GT(high(many), 400);
}

/// Patches of different sizes; there are samples for the largest only, one for each.
TEST_P(ResampleTraps, MoreIslandsThanSamplesLeaveOutTheSmallest) {
  constexpr int kPatches = 30;
  constexpr int kSamples = 12;
  PoseCloudData cloud;
  for (int patch = 0; patch < kPatches; ++patch) {
    // Every size once, in a scrambled order.
    const int side = 8 + (7 * patch) % kPatches;
    for (int i = 0; i < side * side; ++i) {
      cloud.positions_m.emplace_back(10.0 * patch + 0.02 * (i % side), 0.02 * (i / side), 0.0);
    }
  }
  cloud.sensor_m = Eigen::Vector3d(0.0, 0.0, 10.0);
  ResampleConfig with_cells = config(kSamples);
  with_cells.cell_size_m = 0.05;
  const ResampledCloud samples = resampled(with_cells, cloud);
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
  EXPECT_EQ(samples.components, static_cast<uint64_t>(kSamples));
  EXPECT_EQ(samples.dropped_components, static_cast<uint64_t>(kPatches - kSamples));
  std::set<int> patches;
  int smaller = 0;
  for (const Eigen::Vector3d& p : samples.positions_m) {
    const int patch = static_cast<int>(std::floor(p.x() / 10.0 + 0.05));
    patches.insert(patch);
    // Patches of nearly one size may have as many cells.
    if (8 + (7 * patch) % kPatches < 8 + kPatches - kSamples - 1) ++smaller;
  }
  EXPECT_EQ(patches.size(), static_cast<std::size_t>(kSamples));
  EXPECT_EQ(smaller, 0);
}

/// On a lattice whole shells of cells have the same time.
TEST_P(ResampleTraps, TiesDoNotBreakTheCount) {
  const PoseCloudData cloud = latticeCloud(160, 160, 0.0625);
  for (const int count : {63, 64, 65, 1000, 1001, 2500}) {
    ResampleConfig with_cells = config(count);
    with_cells.cell_size_m = 0.0625;
    const ResampledCloud samples = resampled(with_cells, cloud);
    EXPECT_EQ(samples.size(), static_cast<std::size_t>(count));
    EXPECT_GT(spacingOf(samples.positions_m).min_over_mean, 0.5) << count;
  }
}

/// The ground as a sensor with 16 rings sees it: dense along the rings, metres between them.
TEST_P(ResampleTraps, SparseRingsStayOnTheGround) {
  PoseCloudData cloud;
  TestRandom random(3);
  constexpr double kHeight_m = 1.8;
  for (int ring = 0; ring < 8; ++ring) {
    const double range_m = kHeight_m / std::tan((15.0 - 2.0 * ring) * M_PI / 180.0);
    for (int i = 0; i < 1800; ++i) {
      const double angle = 2.0 * M_PI * i / 1800.0;
      const double noisy_m = range_m + 0.02 * random.normal();
      cloud.positions_m.emplace_back(noisy_m * std::cos(angle), noisy_m * std::sin(angle), 0.0);
    }
  }
  cloud.sensor_m = Eigen::Vector3d(0.0, 0.0, kHeight_m);
  const ResampledCloud samples = resampled(config(3000), cloud);
  EXPECT_EQ(samples.size(), 3000u);
  int off_ground = 0;
  for (const Eigen::Vector3d& p : samples.positions_m) {
    if (std::abs(p.z()) > 0.05) ++off_ground;
    // The nearest ring; pieces of the largest voxels, sixteen cells wide, end beyond their points.
    EXPECT_GT(p.head<2>().norm(), 6.7 - 7.5 * samples.cell_size_m);
  }
  EXPECT_EQ(off_ground, 0);
  // All rings are covered.
  const double covering_m = samples.covering_radii.back();
  const Summary covered = coveringOf(samples.positions_m, cloud.positions_m, 1.0).distance_m;
  EXPECT_LT(covered.max, 1.1 * covering_m + samples.cell_size_m);
}

TEST_P(ResampleTraps, MissingFieldsAreNamed) {
  const PoseCloudData cloud = latticeCloud(20, 20, 0.1);
  expectError<std::runtime_error>(
      [&] { resampled(config(50), cloud, {makePolicy("color:target=#b08060")}); },
      {"color:target=#b08060", "'rgb'"});
  expectError<std::runtime_error>(
      [&] { resampled(config(50), cloud, {makePolicy("label:linear=4")}); },
      {"label:linear=4", "'label'"});
}

/// An error leaves the resampler as good as new.
TEST_P(ResampleTraps, WorksAfterAnError) {
  const PoseCloudData cloud = latticeCloud(40, 40, 0.1);
  CloudResampler resampler(config(50));
  const ResampledCloud before = resampler.resample(cloud);
  EXPECT_THROW(resampler.resample(cloud, {makePolicy("color:target=#b08060")}), std::runtime_error);
  EXPECT_EQ(resampler.resample(cloud).positions_m, before.positions_m);
}

TEST(ResampleTrapsConfig, AllViolationsAreTold) {
  ResampleConfig config;
  config.engine = "fast";
  config.crust = "bread";
  expectError<std::invalid_argument>([&] { CloudResampler resampler(config); },
                                     {"'fast'", "'bread'", "count, radius_m, time_budget_s"});
}

INSTANTIATE_TEST_SUITE_P(Engines, ResampleTraps, testing::Values("fast_marching", "flood"),
                         [](const auto& test_case) { return test_case.param; });

}  // namespace
}  // namespace ladar_perception
