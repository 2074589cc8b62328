// SPDX-License-Identifier: BSD-3-Clause
// Density follows the weight: what a policy promises, on flat faces whose area is known.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <ostream>
#include <string>

#include "resample_clouds.h"

namespace ladar_perception {
namespace {

using namespace test;

/// Strips of a sheet across x, within which the weight is nearly even.
struct Strip {
  double begin_m;
  double end_m;
  double weight;
};

constexpr double kMargin_m = 0.5;  // from the rim and from steps of the weight

/// Slope of log density against log weight over the strips.
double densitySlope(const Sheet& sheet, const ResampledCloud& samples,
                    const std::vector<Strip>& strips) {
  std::vector<double> log_weights;
  std::vector<double> log_densities;
  for (const Strip& strip : strips) {
    int count = 0;
    for (const Eigen::Vector3d& p : samples.positions_m) {
      const Eigen::Vector3d q = sheet.toSheet(p);
      if (sheet.isInside(q, kMargin_m) && q.x() >= strip.begin_m && q.x() < strip.end_m) ++count;
    }
    const double area = (strip.end_m - strip.begin_m) * (sheet.width_m - 2.0 * kMargin_m);
    log_weights.push_back(std::log(strip.weight));
    log_densities.push_back(std::log(count / area));
  }
  return slopeOf(log_weights, log_densities);
}

/// The density that is asked for has a slope of 1. A little less is what cells of a finite size
/// give: 0.95 within 0.05, and up to 1.05, which is as near to 1.
void expectSlope(double slope, const std::string& what) {
  EXPECT_GT(slope, 0.90) << what;
  EXPECT_LT(slope, 1.05) << what;
}

struct DensityCase {
  std::string engine;
  double noise_m;
};

std::ostream& operator<<(std::ostream& out, const DensityCase& of) {
  return out << of.engine << ", noise " << of.noise_m << " m";
}

class ResampleDensity : public testing::TestWithParam<DensityCase> {
 protected:
  static constexpr int kSamples = 12000;

  static Sheet sheet() {
    Sheet sheet;
    sheet.points = 150000;
    sheet.noise_m = GetParam().noise_m;
    sheet.pose = Eigen::Translation3d(3.0, -2.0, 1.0) *
                 Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
    return sheet;
  }
  static ResampledCloud resample(const PoseCloudData& cloud, const Policies& policies) {
    return resampled(countConfig(kSamples, GetParam().engine), cloud, policies);
  }
  /// The user's own policy: a weight by the place along the sheet.
  static std::shared_ptr<const Policy> byPlace(const std::function<double(double)>& weight_at_x) {
    return makePolicy("by_place", [=](const PointAttributes& points, std::size_t i) {
      return weight_at_x(sheet().toSheet(points.positions_m[i]).x());
    });
  }
};

TEST_P(ResampleDensity, IsEvenWithoutPolicies) {
  const ResampledCloud samples = resample(sheetCloud(sheet()), {});
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      int count = 0;
      for (const Eigen::Vector3d& p : samples.positions_m) {
        const Eigen::Vector2d q = (sheet().toSheet(p).head<2>().array() - kMargin_m) / 3.0;
        if (std::floor(q.x()) == column && std::floor(q.y()) == row) ++count;
      }
      EXPECT_NEAR(count / 9.0, kSamples / sheet().area(), 0.05 * kSamples / sheet().area());
    }
  }
}

TEST_P(ResampleDensity, FollowsAStep) {
  const PoseCloudData cloud = sheetCloud(sheet());
  for (const double weight : {3.0, 16.0}) {
    const ResampledCloud samples =
        resample(cloud, {byPlace([=](double x) { return x < 5.0 ? 1.0 : weight; })});
    ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
    expectSlope(densitySlope(sheet(), samples, {{kMargin_m, 4.5, 1.0}, {5.5, 9.5, weight}}),
                "step to " + std::to_string(weight));
  }
}

TEST_P(ResampleDensity, FollowsASmoothWeight) {
  // From 1 to 16 across the sheet.
  const auto weight = [](double x) { return std::exp(0.1 * std::log(16.0) * x); };
  const ResampledCloud samples = resample(sheetCloud(sheet()), {byPlace(weight)});
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
  std::vector<Strip> strips;
  for (double x = kMargin_m; x < 9.0; x += 1.0) strips.push_back({x, x + 1.0, weight(x + 0.5)});
  expectSlope(densitySlope(sheet(), samples, strips), "smooth");
}

TEST_P(ResampleDensity, FollowsLabels) {
  PoseCloudData cloud = sheetCloud(sheet());
  for (const Eigen::Vector3d& p : cloud.positions_m) {
    cloud.labels.push_back(sheet().toSheet(p).x() < 5.0 ? 1 : 3);
  }
  const ResampledCloud samples = resample(cloud, {makePolicy("label:surface=0.5,linear=3")});
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
  expectSlope(densitySlope(sheet(), samples, {{kMargin_m, 4.5, 0.5}, {5.5, 9.5, 3.0}}), "labels");
}

/// Scaling all weights changes nothing: only what they are relative to each other counts.
TEST_P(ResampleDensity, DoesNotDependOnTheWeightsScale) {
  const PoseCloudData cloud = sheetCloud(sheet());
  const auto step = [](double scale) {
    return byPlace([=](double x) { return x < 5.0 ? scale : 4.0 * scale; });
  };
  std::vector<std::size_t> left;
  for (const double scale : {1e-4, 1.0, 1e4}) {
    const ResampledCloud samples = resample(cloud, {step(scale)});
    ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
    left.push_back(0);
    for (const Eigen::Vector3d& p : samples.positions_m) {
      if (sheet().toSheet(p).x() < 5.0) ++left.back();
    }
  }
  EXPECT_NEAR(static_cast<double>(left[0]), static_cast<double>(left[1]), 0.02 * left[1]);
  EXPECT_NEAR(static_cast<double>(left[2]), static_cast<double>(left[1]), 0.02 * left[1]);
}

/// A sheet at every slant, one of them with hardly more points than samples: equal areas get equal
/// numbers of samples.
TEST_P(ResampleDensity, IsEvenOverFacesOfAnySlant) {
  constexpr double kSide_m = 3.0;
  constexpr int kPerSquareMetre = 120;
  std::vector<Sheet> sheets;
  PoseCloudData cloud;
  TestRandom random(5);
  const std::vector<double> slants_deg = {0, 15, 26.6, 35.3, 45, 54.7, 70, 90, 30, 45, 60};
  for (std::size_t i = 0; i < slants_deg.size(); ++i) {
    Sheet sheet;
    sheet.length_m = sheet.width_m = kSide_m;
    sheet.noise_m = GetParam().noise_m;
    const bool sparse = i >= 8;
    sheet.points = static_cast<int>((sparse ? 2 : 12) * kPerSquareMetre * sheet.area());
    sheet.pose = Eigen::Translation3d(10.0 * static_cast<double>(i), 0.0, 0.0) *
                 Eigen::AngleAxisd(0.3 * static_cast<double>(i), Eigen::Vector3d::UnitZ()) *
                 Eigen::AngleAxisd(slants_deg[i] * M_PI / 180.0, Eigen::Vector3d::UnitX());
    addSheet(sheet, &random, &cloud);
    sheets.push_back(sheet);
  }
  cloud.sensor_m = Eigen::Vector3d(50.0, -40.0, 20.0);
  const int count =
      static_cast<int>(static_cast<double>(sheets.size()) * kPerSquareMetre * kSide_m * kSide_m);
  const ResampledCloud samples = resampled(countConfig(count, GetParam().engine), cloud);
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(count));
  std::vector<double> counts;
  double sum = 0.0;
  for (const Sheet& sheet : sheets) {
    counts.push_back(0.0);
    for (const Eigen::Vector3d& p : samples.positions_m) {
      const Eigen::Vector3d q = sheet.toSheet(p);
      if (std::abs(q.z()) < 0.2 && sheet.isInside(q, 0.2)) ++counts.back();
    }
    sum += counts.back();
  }
  const double mean = sum / static_cast<double>(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    EXPECT_NEAR(counts[i] / mean, 1.0, 0.05) << "sheet " << i << " at " << slants_deg[i] << " deg";
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, ResampleDensity,
                         testing::Values(DensityCase{"fast_marching", 0.0},
                                         DensityCase{"fast_marching", 0.015},
                                         DensityCase{"flood", 0.0}, DensityCase{"flood", 0.015}),
                         [](const testing::TestParamInfo<DensityCase>& test_case) {
                           return test_case.param.engine +
                                  (test_case.param.noise_m > 0.0 ? "_noisy" : "_exact");
                         });

}  // namespace
}  // namespace ladar_perception
