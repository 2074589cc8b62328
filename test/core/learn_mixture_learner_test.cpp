// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "hand_model.h"
#include "io_test_files.h"
#include "ladar_perception/learn/mixture_learner.h"
#include "mixture_samples.h"

namespace ladar_perception {
namespace {

using test::drawSamples;
using test::gaussian;

Eigen::VectorXd tinyFloor() { return Eigen::VectorXd::Constant(2, 1e-6); }

/// Two slanted Gaussians, far from one another and of very different scales along the axes.
std::vector<GaussianComponent> twoGaussians() {
  std::vector<GaussianComponent> mixture = {gaussian(0.7, {0.0, 100.0}, {1.0, 30.0}),
                                            gaussian(0.3, {8.0, 400.0}, {0.5, 10.0})};
  mixture[0].covariance(0, 1) = mixture[0].covariance(1, 0) = 20.0;
  return mixture;
}

int componentsChosen(const Samples& samples, ComponentChoice choice) {
  MixtureOptions options;
  options.choice = choice;
  options.candidates = {1, 2, 3};
  const LearnedMixture learned = learnMixture(samples, tinyFloor(), options);
  EXPECT_EQ(learned.choice, choice);
  EXPECT_EQ(learned.scores.size(), 3u);
  return static_cast<int>(learned.components.size());
}

TEST(LearnMixture, RecoversAKnownMixture) {
  const auto truth = twoGaussians();
  MixtureOptions options;
  options.candidates = {2};
  auto learned = learnMixture(drawSamples(truth, 4000, 20, 1), tinyFloor(), options).components;
  ASSERT_EQ(learned.size(), 2u);
  EXPECT_EQ(GaussianMixture::error(learned, 2), "");
  if (learned[0].weight < learned[1].weight) std::swap(learned[0], learned[1]);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_NEAR(learned[c].weight, truth[c].weight, 0.03);
    for (int i = 0; i < 2; ++i) {
      const double deviation = std::sqrt(truth[c].covariance(i, i));
      EXPECT_NEAR(learned[c].mean[i], truth[c].mean[i], 0.1 * deviation);
      EXPECT_NEAR(learned[c].covariance(i, i) / truth[c].covariance(i, i), 1.0, 0.12);
    }
  }
  EXPECT_NEAR(learned[0].covariance(0, 1), 20.0, 3.0);
}

TEST(LearnMixture, BothChoicesFindHowManyThereAre) {
  const std::vector<GaussianComponent> one = {gaussian(1.0, {3.0, -2.0}, {0.5, 4.0})};
  for (const auto choice : {ComponentChoice::kBic, ComponentChoice::kHeldOut}) {
    for (const uint64_t seed : {1u, 2u}) {
      EXPECT_EQ(componentsChosen(drawSamples(one, 600, 20, seed), choice), 1);
      EXPECT_EQ(componentsChosen(drawSamples(twoGaussians(), 600, 20, seed), choice), 2);
    }
  }
}

TEST(LearnMixture, PlacesThatDifferDoNotBuyComponents) {
  // Every place has a small spread of its own around a mean that is Gaussian over the places: what
  // is common to the class is one Gaussian, the rest is of no use elsewhere.
  test::TestRandom random(5);
  Samples samples;
  samples.values.resize(2, 2000);
  for (int place = 0; place < 40; ++place) {
    const Eigen::Vector2d mean(random.normal(), random.normal());
    for (int i = 0; i < 50; ++i) {
      samples.values.col(place * 50 + i) =
          mean + 0.05 * Eigen::Vector2d(random.normal(), random.normal());
      samples.places.push_back(static_cast<std::size_t>(place));
    }
  }
  MixtureOptions options;
  const Eigen::VectorXd floor = Eigen::VectorXd::Constant(2, 0.1);
  const LearnedMixture held_out = learnMixture(samples, floor, options);
  options.choice = ComponentChoice::kBic;
  const LearnedMixture bic = learnMixture(samples, floor, options);
  EXPECT_LE(held_out.components.size(), 2u);
  EXPECT_GT(bic.components.size(), 2 * held_out.components.size());
}

TEST(LearnMixture, WithoutPlacesEnoughBicDecides) {
  MixtureOptions options;
  options.candidates = {1, 2, 3};
  const LearnedMixture learned =
      learnMixture(drawSamples(twoGaussians(), 1500, 3, 1), tinyFloor(), options);
  EXPECT_EQ(learned.choice, ComponentChoice::kBic);
  EXPECT_EQ(learned.components.size(), 2u);
  for (const MixtureScore& score : learned.scores) EXPECT_TRUE(std::isnan(score.held_out));
}

TEST(LearnMixture, SameArgumentsSameBits) {
  const Samples samples = drawSamples(twoGaussians(), 400, 10, 4);
  MixtureOptions options;
  options.candidates = {2, 4};
  const LearnedMixture a = learnMixture(samples, tinyFloor(), options);
  // Fits in between must not matter.
  learnMixture(drawSamples(twoGaussians(), 300, 10, 5), tinyFloor(), options);
  const LearnedMixture b = learnMixture(samples, tinyFloor(), options);
  ASSERT_EQ(a.components.size(), b.components.size());
  for (std::size_t c = 0; c < a.components.size(); ++c) {
    EXPECT_EQ(a.components[c].weight, b.components[c].weight);
    EXPECT_EQ(a.components[c].mean, b.components[c].mean);
    EXPECT_EQ(a.components[c].covariance, b.components[c].covariance);
  }
}

TEST(LearnMixture, TheFloorIsAddedToVariances) {
  const Samples samples = drawSamples({gaussian(1.0, {0.0, 0.0}, {1.0, 2.0})}, 2000, 10, 1);
  MixtureOptions options;
  options.candidates = {1};
  const auto bare = learnMixture(samples, tinyFloor(), options).components[0];
  const Eigen::Vector2d floor(0.5, 7.0);
  const auto floored = learnMixture(samples, floor, options).components[0];
  EXPECT_NEAR(floored.covariance(0, 0) - bare.covariance(0, 0), 0.5, 1e-5);
  EXPECT_NEAR(floored.covariance(1, 1) - bare.covariance(1, 1), 7.0, 1e-5);
  EXPECT_NEAR(floored.covariance(0, 1), bare.covariance(0, 1), 1e-9);
}

TEST(LearnMixture, AFeatureThatNeverChangesIsNoHarm) {
  Samples samples = drawSamples(twoGaussians(), 1000, 10, 1);
  samples.values.row(0).setConstant(4.0);
  MixtureOptions options;
  options.candidates = {1, 2, 3};
  const LearnedMixture learned = learnMixture(samples, Eigen::VectorXd::Constant(2, 0.01), options);
  EXPECT_EQ(GaussianMixture::error(learned.components, 2), "");
  for (const GaussianComponent& component : learned.components) {
    EXPECT_NEAR(component.mean[0], 4.0, 1e-6);
    EXPECT_NEAR(component.covariance(0, 0), 0.01, 1e-4);
  }
}

TEST(LearnMixture, SaysWhenSamplesAreTooFew) {
  const auto truth = twoGaussians();
  expectError([&] { learnMixture(drawSamples(truth, 49, 5, 1), tinyFloor(), {}); },
              {"49 samples", "at least 50"});
  MixtureOptions options;
  options.candidates = {20};
  expectError([&] { learnMixture(drawSamples(truth, 150, 5, 1), tinyFloor(), options); },
              {"150 samples", "20 components"});
  // Where it chooses, it takes no more than samples allow.
  for (const MixtureScore& score :
       learnMixture(drawSamples(truth, 60, 5, 1), tinyFloor(), {}).scores) {
    EXPECT_LE(score.components, 4);
  }
}

TEST(LearnMixture, CountsItsFits) {
  for (const std::size_t places : {3u, 20u}) {
    const Samples samples = drawSamples(twoGaussians(), 500, places, 1);
    for (const auto choice : {ComponentChoice::kBic, ComponentChoice::kHeldOut}) {
      MixtureOptions options;
      options.choice = choice;
      options.candidates = {1, 2, 3};
      std::size_t fits = 0;
      learnMixture(samples, tinyFloor(), options, [&] { ++fits; });
      EXPECT_EQ(fits, fitCount(samples, options));
    }
  }
}

TEST(LearnMixture, LogLikelihoodsAreThoseOfTheDensity) {
  const GaussianMixture mixture({gaussian(1.0, {1.0, 2.0}, {2.0, 0.5})});
  Eigen::MatrixXd values(2, 130);  // two blocks and a bit
  for (Eigen::Index i = 0; i < values.cols(); ++i) {
    values.col(i) = Eigen::Vector2d(0.01 * static_cast<double>(i), 2.0);
  }
  const std::vector<double> found = logLikelihoods(mixture, values);
  ASSERT_EQ(found.size(), 130u);
  for (Eigen::Index i = 0; i < values.cols(); ++i) {
    const double d = (values(0, i) - 1.0) / 2.0;
    const double expected = -0.5 * d * d - std::log(2.0 * M_PI * 2.0 * 0.5);
    EXPECT_NEAR(found[static_cast<std::size_t>(i)], expected, 1e-5) << i;
  }
}

}  // namespace
}  // namespace ladar_perception
