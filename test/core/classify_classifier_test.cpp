// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

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
  model.features = {{Quantity::kScatter}};
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

/// Values of a feature that are within a few deviations of line models.
FeatureBlock lineValues(TestRandom* random) {
  FeatureBlock block(1);
  for (int i = 0; i < kSize; ++i) block.row(0)[i] = static_cast<float>(random->real(-5.0, 20.0));
  return block;
}

/// Priors times likelihoods to the power of 1 / temperature and e^offset, in double precision.
std::vector<double> expectedPosterior(const std::vector<double>& means,
                                      const std::vector<double>& priors, double x,
                                      double temperature, const std::vector<float>& offsets) {
  std::vector<double> log_joint;
  for (std::size_t c = 0; c < means.size(); ++c) {
    log_joint.push_back(std::log(priors[c]) - 0.5 * std::pow(x - means[c], 2) / temperature +
                        (offsets.empty() ? 0.0F : offsets[c]));
  }
  const double greatest = *std::max_element(log_joint.begin(), log_joint.end());
  double sum = 0.0;
  for (double& joint : log_joint) sum += joint = std::exp(joint - greatest);
  for (double& joint : log_joint) joint /= sum;
  return log_joint;
}

class AnyClasses : public testing::TestWithParam<int> {
 protected:
  AnyClasses() {
    for (int c = 0; c < GetParam(); ++c) {
      means_.push_back(random_.real(0.0, 15.0));
      priors_.push_back(random_.real(0.1, 10.0));
    }
  }
  ClassifierModel model() const { return lineModel(means_, priors_); }
  std::size_t classes() const { return means_.size(); }

  TestRandom random_{static_cast<uint64_t>(GetParam())};
  std::vector<double> means_;
  std::vector<double> priors_;
};

double sumOf(const PosteriorBlock& block, std::size_t classes, int i) {
  double sum = 0.0;
  for (std::size_t c = 0; c < classes; ++c) sum += block.probability[c][i];
  return sum;
}

TEST_P(AnyClasses, PosteriorsFollowBayesAtAnyTemperature) {
  const Classifier classifier(model());
  EXPECT_EQ(classifier.classes(), classes());
  std::vector<float> offsets;
  for (std::size_t c = 0; c < classes(); ++c) {
    offsets.push_back(static_cast<float>(random_.real(-3.0, 3.0)));
  }
  for (const double temperature : {0.25, 1.0, 1.7, 8.0, 100.0}) {
    const FeatureBlock values = lineValues(&random_);
    for (const std::vector<float>& added : {std::vector<float>(), offsets}) {
      PosteriorBlock posterior;
      classifier.posteriors(values, static_cast<float>(temperature),
                            added.empty() ? nullptr : added.data(), &posterior);
      for (int i = 0; i < kSize; ++i) {
        const auto expected =
            expectedPosterior(means_, priors_, values.row(0)[i], temperature, added);
        for (std::size_t c = 0; c < classes(); ++c) {
          ASSERT_NEAR(posterior.probability[c][i], expected[c], 1e-4 / temperature + 2e-6);
          ASSERT_GE(posterior.probability[c][i], 0.0F);
        }
        ASSERT_NEAR(sumOf(posterior, classes(), i), 1.0, 1e-6);
        ASSERT_EQ(posterior.known[i], 1U);
      }
    }
  }
}

TEST_P(AnyClasses, TemperatureFlattensAndKeepsTheOrder) {
  const Classifier classifier(lineModel(means_, std::vector<double>(classes(), 1.0)));
  const FeatureBlock values = lineValues(&random_);
  std::vector<Classification> before;
  for (const float temperature : {0.1F, 0.5F, 1.0F, 2.0F, 10.0F, 1000.0F}) {
    PosteriorBlock posterior;
    classifier.posteriors(values, temperature, nullptr, &posterior);
    std::vector<Classification> chosen(kSize);
    classifier.choose(posterior, kSize, chosen.data());
    for (int i = 0; i < kSize && !before.empty(); ++i) {
      ASSERT_LE(chosen[i].confidence, before[i].confidence + 1e-6F);
      const bool is_close = before[i].confidence < 0.5F + 1e-3F;  // rounding may decide
      if (!is_close) {
        ASSERT_EQ(chosen[i].label, before[i].label);
      }
    }
    before = chosen;
  }
  for (const Classification& flat : before) {
    EXPECT_NEAR(flat.confidence, 1.0 / GetParam(), 0.2 / GetParam());
  }
}

TEST_P(AnyClasses, AtHighTemperaturesThePriorsDecide) {
  const Classifier classifier(model());
  PosteriorBlock posterior;
  classifier.posteriors(lineValues(&random_), 1e6F, nullptr, &posterior);
  const double sum = std::accumulate(priors_.begin(), priors_.end(), 0.0);
  for (int i = 0; i < kSize; ++i) {
    for (std::size_t c = 0; c < classes(); ++c) {
      ASSERT_NEAR(posterior.probability[c][i], priors_[c] / sum, 1e-3);
    }
  }
}

TEST_P(AnyClasses, NormalizingMakesProbabilitiesOfLogarithms) {
  const Classifier classifier(model());
  for (const float common : {0.0F, -700.0F, 90.0F}) {
    PosteriorBlock block = {};
    std::vector<std::vector<double>> logs(kSize);
    for (int i = 0; i < kSize; ++i) {
      block.known[i] = i % 3;
      for (std::size_t c = 0; c < classes(); ++c) {
        block.probability[c][i] = common + static_cast<float>(random_.real(-30.0, 0.0));
        logs[i].push_back(block.probability[c][i]);
      }
    }
    classifier.normalize(&block);
    for (int i = 0; i < kSize; ++i) {
      const double greatest = *std::max_element(logs[i].begin(), logs[i].end());
      double sum = 0.0;
      for (const double log : logs[i]) sum += std::exp(log - greatest);
      for (std::size_t c = 0; c < classes(); ++c) {
        ASSERT_NEAR(block.probability[c][i], std::exp(logs[i][c] - greatest) / sum, 2e-6);
      }
      ASSERT_NEAR(sumOf(block, classes(), i), 1.0, 1e-6);
      ASSERT_EQ(block.known[i], static_cast<uint32_t>(i % 3));
    }
  }
}

TEST_P(AnyClasses, TheFirstOfEqualsIsChosen) {
  const Classifier classifier(model());
  PosteriorBlock block = {};
  for (int i = 0; i < kSize; ++i) {
    block.known[i] = i % 5 == 4 ? 0 : 1;
    for (std::size_t c = 0; c < classes(); ++c) block.probability[c][i] = 0.01F;
    // Two that are equal and greater than the rest.
    block.probability[i % classes()][i] = 0.4F;
    block.probability[(3 * i + 1) % classes()][i] = 0.4F;
  }
  Classification chosen[kSize];
  std::fill_n(chosen, kSize, Classification{99, 0.5F});
  classifier.choose(block, kSize - 3, chosen);
  for (int i = 0; i < kSize; ++i) {
    const std::size_t first = std::min(i % classes(), (3 * i + 1) % classes());
    Classification expected = {static_cast<uint8_t>(first + 1), 0.4F};
    if (i % 5 == 4) expected = Classification();
    if (i >= kSize - 3) expected = {99, 0.5F};
    ASSERT_EQ(chosen[i].label, expected.label) << i;
    ASSERT_EQ(chosen[i].confidence, expected.confidence) << i;
  }
}

TEST_P(AnyClasses, ClassifyingIsChoosingByTheModelsCalibration) {
  ClassifierModel model = this->model();
  model.calibration.temperature = 2.5;
  std::vector<float> offsets;
  for (std::size_t c = 0; c < classes(); ++c) {
    offsets.push_back(0.25F * static_cast<float>(c % 4));
    model.calibration.offsets.push_back(offsets.back());
  }
  model.calibration.smoothing.temperature = 77.0;
  model.calibration.smoothing.offsets.assign(classes(), -5.0);
  model.unknown_log_likelihood = -8.0;
  const Classifier classifier(model);
  const FeatureBlock values = lineValues(&random_);
  PosteriorBlock posterior;
  classifier.posteriors(values, 2.5F, offsets.data(), &posterior);
  Classification expected[kSize];
  Classification found[kSize];
  classifier.choose(posterior, kSize, expected);
  classifier.classify(values, kSize, found);
  int unknown = 0;
  for (int i = 0; i < kSize; ++i) {
    ASSERT_EQ(found[i].label, expected[i].label);
    ASSERT_EQ(found[i].confidence, expected[i].confidence);
    // The threshold is of likelihoods, whatever the temperature.
    double nearest = 1e9;
    for (const double mean : means_) {
      nearest = std::min(nearest, std::abs(values.row(0)[i] - mean));
    }
    const double log_likelihood = -0.9189385 - 0.5 * nearest * nearest;
    ASSERT_EQ(found[i].label == kUnknownLabel, log_likelihood < -8.0) << log_likelihood;
    unknown += found[i].label == kUnknownLabel ? 1 : 0;
  }
  EXPECT_GT(unknown, 0);
}

INSTANTIATE_TEST_SUITE_P(Classifier, AnyClasses, testing::Range(2, 17),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace ladar_perception
