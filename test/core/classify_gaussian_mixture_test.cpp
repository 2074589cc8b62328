// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "hand_model.h"
#include "ladar_perception/classify/gaussian_mixture.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::gaussian;
using test::TestRandom;

constexpr int kSize = FeatureBlock::kSize;

/// The definition, by determinant and inverse in double.
double exactLogLikelihood(const std::vector<GaussianComponent>& components, const VectorXd& x,
                          double* least_squared_distance) {
  constexpr double kTwoPi = 6.283185307179586;
  std::vector<double> logs;
  *least_squared_distance = std::numeric_limits<double>::infinity();
  for (const GaussianComponent& c : components) {
    const VectorXd d = x - c.mean;
    const double squared = d.dot(c.covariance.inverse() * d);
    *least_squared_distance = std::min(*least_squared_distance, squared);
    const auto n = static_cast<double>(x.size());
    logs.push_back(std::log(c.weight) - 0.5 * squared -
                   0.5 * (n * std::log(kTwoPi) + std::log(c.covariance.determinant())));
  }
  const double greatest = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double log : logs) sum += std::exp(log - greatest);
  return greatest + std::log(sum);
}

std::vector<GaussianComponent> randomMixture(TestRandom* random, int features, int count) {
  std::vector<GaussianComponent> components;
  double weights = 0.0;
  for (int c = 0; c < count; ++c) {
    GaussianComponent component;
    component.weight = random->real(0.1, 1.0);
    weights += component.weight;
    component.mean = VectorXd(features);
    MatrixXd a(features, features);
    for (int i = 0; i < features; ++i) {
      component.mean[i] = random->real(-1, 1);
      for (int j = 0; j < features; ++j) a(i, j) = random->real(-1, 1);
    }
    component.covariance = a * a.transpose() + 0.1 * MatrixXd::Identity(features, features);
    components.push_back(component);
  }
  for (GaussianComponent& component : components) component.weight /= weights;
  return components;
}

/// Vectors around the means, the farthest some 10 `spread` away.
FeatureBlock randomBlock(TestRandom* random, int features, double spread) {
  FeatureBlock block(features);
  for (int f = 0; f < features; ++f) {
    for (int i = 0; i < kSize; ++i) {
      block.row(f)[i] = static_cast<float>(spread * random->normal());
    }
  }
  return block;
}

VectorXd lane(const FeatureBlock& block, int features, int i) {
  VectorXd x(features);
  for (int f = 0; f < features; ++f) x[f] = static_cast<double>(block.row(f)[i]);
  return x;
}

TEST(GaussianMixture, LogLikelihoodEqualsTheDefinition) {
  TestRandom random(1);
  for (int round = 0; round < 200; ++round) {
    const int features = 1 + round % 6;
    const auto components = randomMixture(&random, features, 1 + round % 5);
    ASSERT_EQ(GaussianMixture::error(components, features), "");
    const GaussianMixture mixture(components);
    const FeatureBlock block = randomBlock(&random, features, round % 3 == 0 ? 5.0 : 1.0);
    float values[kSize];
    mixture.logLikelihood(block, values);
    for (int i = 0; i < kSize; ++i) {
      double squared = 0.0;
      const double exact = exactLogLikelihood(components, lane(block, features, i), &squared);
      ASSERT_NEAR(values[i], exact, 1e-5 + 2e-6 * squared) << "lane " << i << " round " << round;
    }
  }
}

TEST(GaussianMixture, AStandardNormalAtKnownPlaces) {
  const GaussianMixture mixture({gaussian(1.0, {0.0}, {1.0})});
  FeatureBlock block(1);
  block.row(0)[1] = 2.0F;
  block.row(0)[2] = -2.0F;
  float values[kSize];
  mixture.logLikelihood(block, values);
  EXPECT_FLOAT_EQ(values[0], -0.9189385F);
  EXPECT_FLOAT_EQ(values[1], -2.9189385F);
  EXPECT_FLOAT_EQ(values[2], -2.9189385F);
}

TEST(GaussianMixture, SplittingAComponentChangesNothing) {
  const GaussianMixture whole({gaussian(1.0, {0.3, -1.0}, {0.5, 2.0})});
  const GaussianMixture split(
      {gaussian(0.25, {0.3, -1.0}, {0.5, 2.0}), gaussian(0.75, {0.3, -1.0}, {0.5, 2.0})});
  TestRandom random(2);
  const FeatureBlock block = randomBlock(&random, 2, 2.0);
  float a[kSize];
  float b[kSize];
  whole.logLikelihood(block, a);
  split.logLikelihood(block, b);
  for (int i = 0; i < kSize; ++i) EXPECT_NEAR(a[i], b[i], 1e-6 + 1e-6 * std::abs(a[i]));
}

TEST(GaussianMixture, AVolumesValueDoesNotDependOnItsNeighbours) {
  TestRandom random(3);
  const auto components = randomMixture(&random, 3, 4);
  const GaussianMixture mixture(components);
  const FeatureBlock block = randomBlock(&random, 3, 1.0);
  float values[kSize];
  mixture.logLikelihood(block, values);
  for (int i = 0; i < kSize; ++i) {
    FeatureBlock alone(3);
    for (int f = 0; f < 3; ++f) alone.row(f)[kSize - 1 - i] = block.row(f)[i];
    float lonely[kSize];
    mixture.logLikelihood(alone, lonely);
    EXPECT_EQ(lonely[kSize - 1 - i], values[i]);
  }
}

TEST(GaussianMixture, FarAwayIsVeryUnlikelyAndNeverNan) {
  const GaussianMixture one({gaussian(1.0, {0.0, 0.0}, {0.01, 0.01})});
  const GaussianMixture two(
      {gaussian(0.5, {0.0, 0.0}, {0.01, 0.01}), gaussian(0.5, {1.0, 1.0}, {0.01, 0.01})});
  for (const float far : {1e2F, 1e6F, 1e12F, 1e16F}) {
    FeatureBlock block(2);
    std::fill_n(block.row(0), kSize, far);
    std::fill_n(block.row(1), kSize, -far);
    float values[kSize];
    one.logLikelihood(block, values);
    EXPECT_LT(values[0], -1e6F) << far;
    two.logLikelihood(block, values);
    EXPECT_FALSE(std::isnan(values[0])) << far;
    EXPECT_LT(values[0], -1e6F) << far;
  }
}

TEST(GaussianMixture, EvenTheGreatestFloatsGiveNoNan) {
  const GaussianMixture two(
      {gaussian(0.5, {0.0, 0.0}, {0.01, 0.01}), gaussian(0.5, {1.0, 1.0}, {0.01, 0.01})});
  for (const float far : {1e19F, 1e25F, std::numeric_limits<float>::max()}) {
    FeatureBlock block(2);
    std::fill_n(block.row(0), kSize, far);
    std::fill_n(block.row(1), kSize, -far);
    float values[kSize];
    two.logLikelihood(block, values);
    EXPECT_FALSE(std::isnan(values[0])) << far;
  }
}

void expectError(const std::vector<GaussianComponent>& components, int features,
                 const std::string& part) {
  const std::string error = GaussianMixture::error(components, features);
  EXPECT_NE(error.find(part), std::string::npos) << "'" << part << "' is not in: " << error;
}

TEST(GaussianMixtureError, SaysWhatIsWrong) {
  const GaussianComponent good = gaussian(0.5, {0.0, 1.0}, {1.0, 2.0});
  const double nan = std::nan("");
  EXPECT_EQ(GaussianMixture::error({good, good}, 2), "");
  expectError({}, 2, "no components");
  expectError({good}, 2, "weights sum");
  const auto broken = [&](auto change) {
    GaussianComponent bad = good;
    change(&bad);
    return std::vector<GaussianComponent>{good, bad};
  };
  expectError(broken([](auto* c) { c->weight = 0.0; }), 2, "component 1: weight");
  expectError(broken([](auto* c) { c->weight = -0.5; }), 2, "component 1: weight");
  expectError(broken([&](auto* c) { c->weight = nan; }), 2, "component 1: weight");
  expectError(broken([](auto* c) { c->mean.resize(3); }), 2, "component 1: mean");
  expectError(broken([&](auto* c) { c->mean[0] = nan; }), 2, "component 1: mean");
  expectError(broken([](auto* c) { c->covariance.resize(2, 3); }), 2, "component 1: covariance");
  expectError(broken([&](auto* c) { c->covariance(0, 0) = HUGE_VAL; }), 2, "finite");
  expectError(broken([](auto* c) { c->covariance(0, 1) = 0.1; }), 2, "symmetric");
  expectError(broken([](auto* c) { c->covariance.setOnes(); }), 2, "positive definite");
  expectError(broken([](auto* c) { c->covariance *= -1.0; }), 2, "positive definite");
  expectError({good, good}, 3, "mean must have 3");
}

}  // namespace
}  // namespace ladar_perception
