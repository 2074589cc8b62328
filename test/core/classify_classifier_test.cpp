// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hand_model.h"
#include "ladar_perception/classify/classifier.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::gaussian;
using test::TestRandom;

constexpr int kSize = FeatureBlock::kSize;

/// Classes that are normal in one feature, at these means with deviation 1.
ClassifierModel lineModel(const std::vector<double>& means, const std::vector<double>& priors) {
  ClassifierModel model;
  model.features = {Feature::kScatter};
  for (std::size_t c = 0; c < means.size(); ++c) {
    model.classes.push_back(
        {"c" + std::to_string(c), 0, priors[c], {gaussian(1.0, {means[c]}, {1.0})}});
  }
  return model;
}

std::vector<Classification> classifyLine(const ClassifierModel& model,
                                         const std::vector<float>& values) {
  FeatureBlock block(1);
  std::copy(values.begin(), values.end(), block.row(0));
  std::vector<Classification> result(values.size());
  Classifier(model).classify(block, static_cast<int>(values.size()), result.data());
  return result;
}

Classification classifyOne(const ClassifierModel& model, float value) {
  return classifyLine(model, {value}).front();
}

TEST(Classifier, PosteriorsFollowBayes) {
  for (const auto& priors : {std::vector<double>{1, 1, 1}, {0.2, 0.5, 0.3}, {100, 1, 20}}) {
    const std::vector<double> means = {-1.0, 0.5, 3.0};
    const ClassifierModel model = lineModel(means, priors);
    for (double x = -4.0; x < 6.0; x += 0.13) {
      const auto value = static_cast<float>(x);
      double joint[3];
      for (int c = 0; c < 3; ++c)
        joint[c] = priors[c] * std::exp(-0.5 * std::pow(value - means[c], 2));
      const double evidence = joint[0] + joint[1] + joint[2];
      const double* best = std::max_element(joint, joint + 3);
      const Classification result = classifyOne(model, value);
      EXPECT_EQ(result.label, best - joint + 1) << x;
      EXPECT_NEAR(result.confidence, *best / evidence, 2e-6) << x;
    }
  }
}

TEST(Classifier, TheScaleOfThePriorsDoesNotMatter) {
  const ClassifierModel small = lineModel({0.0, 1.0}, {0.001, 0.003});
  const ClassifierModel large = lineModel({0.0, 1.0}, {1000.0, 3000.0});
  for (const float x : {-1.0F, 0.2F, 0.7F}) {
    EXPECT_EQ(classifyOne(small, x).label, classifyOne(large, x).label);
    EXPECT_NEAR(classifyOne(small, x).confidence, classifyOne(large, x).confidence, 1e-6);
  }
}

TEST(Classifier, PriorsMoveTheBoundary) {
  // Equal priors: the boundary of means 0 and 2 is 1; ratio e^2 moves it by 1.
  EXPECT_EQ(classifyOne(lineModel({0, 2}, {1, 1}), 0.99F).label, 1);
  EXPECT_EQ(classifyOne(lineModel({0, 2}, {1, 1}), 1.01F).label, 2);
  const double ratio = std::exp(2.0);
  EXPECT_EQ(classifyOne(lineModel({0, 2}, {ratio, 1}), 1.99F).label, 1);
  EXPECT_EQ(classifyOne(lineModel({0, 2}, {ratio, 1}), 2.01F).label, 2);
}

TEST(Classifier, TheUnlikelyIsUnknown) {
  ClassifierModel model = lineModel({0.0, 10.0}, {1.0, 1.0});
  // The density 3 deviations away, whatever the prior.
  model.unknown_log_likelihood = -0.9189385 - 4.5;
  for (const double prior : {1e-6, 1.0, 1e6}) {
    model.classes[0].prior = prior;
    EXPECT_EQ(classifyOne(model, 2.99F).label, 1) << prior;
    EXPECT_EQ(classifyOne(model, 7.01F).label, 2) << prior;
    for (const float x : {-3.01F, 5.0F, 13.01F}) {
      EXPECT_EQ(classifyOne(model, x).label, kUnknownLabel) << x;
      EXPECT_EQ(classifyOne(model, x).confidence, 0.0F);
    }
  }
}

TEST(Classifier, BlocksOfFewerVolumesGiveTheSameBits) {
  const ClassifierModel model = test::handModel();
  const Classifier classifier(model);
  EXPECT_EQ(classifier.features(), model.features);
  TestRandom random(1);
  FeatureBlock block(3);
  for (int f = 0; f < 3; ++f) {
    for (int i = 0; i < kSize; ++i) block.row(f)[i] = static_cast<float>(random.real(0, 0.6));
  }
  Classification all[kSize];
  classifier.classify(block, kSize, all);
  for (int count = 0; count <= kSize; ++count) {
    Classification some[kSize];
    std::fill(some, some + kSize, Classification{99, 0.5F});
    classifier.classify(block, count, some);
    for (int i = 0; i < kSize; ++i) {
      EXPECT_EQ(some[i].label, i < count ? all[i].label : 99);
      EXPECT_EQ(some[i].confidence, i < count ? all[i].confidence : 0.5F);
    }
  }
}

TEST(Classifier, ConfidenceIsAProbabilityEverywhere) {
  const ClassifierModel model = lineModel({-1.0, 0.0, 1.0}, {1.0, 1.0, 1.0});
  for (const float x : {0.0F, 1e2F, -1e3F, 1e6F, -1e12F, 1e18F}) {
    const Classification result = classifyOne(model, x);
    EXPECT_GE(result.label, 1);
    EXPECT_GE(result.confidence, 1.0F / 3 - 1e-6F) << x;
    EXPECT_LE(result.confidence, 1.0F) << x;
  }
}

TEST(Classifier, EvenTheGreatestFloatsGiveAProbability) {
  // classify() promises to take any finite numbers; beyond 1e19 squared distances overflow.
  ClassifierModel model = lineModel({-1.0, 0.0, 1.0}, {1.0, 1.0, 1.0});
  for (const float x : {1e20F, -1e30F, std::numeric_limits<float>::max()}) {
    const Classification result = classifyOne(model, x);
    EXPECT_FALSE(std::isnan(result.confidence)) << x;
    EXPECT_LE(result.confidence, 1.0F) << x;
    model.unknown_log_likelihood = -100.0;
    EXPECT_EQ(classifyOne(model, x).label, kUnknownLabel) << x;
    EXPECT_EQ(classifyOne(model, x).confidence, 0.0F) << x;
    model.unknown_log_likelihood = -std::numeric_limits<double>::infinity();
  }
}

TEST(Classifier, TwoAndSixteenClasses) {
  std::vector<double> means;
  for (int c = 0; c < static_cast<int>(kMaxClasses); ++c) means.push_back(20.0 * c);
  const ClassifierModel model = lineModel(means, std::vector<double>(kMaxClasses, 1.0));
  for (int c = 0; c < static_cast<int>(kMaxClasses); ++c) {
    const Classification result = classifyOne(model, static_cast<float>(20 * c + 1));
    EXPECT_EQ(result.label, c + 1);
    EXPECT_NEAR(result.confidence, 1.0F, 1e-6F);
  }
}

}  // namespace
}  // namespace ladar_perception
