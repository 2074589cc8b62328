// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/classify/classifier.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "ladar_perception/util/block_math.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

constexpr int kSize = FeatureBlock::kSize;

/// Turns the logarithms of what is proportional to probabilities into probabilities, in place.
LADAR_INLINE void normalizeLogs(float (*__restrict__ p)[kSize], std::size_t classes) {
  float greatest[kSize];
  float sum[kSize];
  std::copy_n(p[0], kSize, greatest);
  for (std::size_t c = 1; c < classes; ++c) {
    for (int i = 0; i < kSize; ++i) greatest[i] = std::max(greatest[i], p[c][i]);
  }
  std::fill_n(sum, kSize, 0.0F);
  for (std::size_t c = 0; c < classes; ++c) {
    for (int i = 0; i < kSize; ++i) {
      p[c][i] = block_math::expNegative(p[c][i] - greatest[i]);
      sum[i] += p[c][i];
    }
  }
  for (int i = 0; i < kSize; ++i) sum[i] = 1.0F / sum[i];
  for (std::size_t c = 0; c < classes; ++c) {
    for (int i = 0; i < kSize; ++i) p[c][i] *= sum[i];
  }
}

}  // namespace

Classifier::Classifier(const ClassifierModel& model)
    : features_(model.features),
      unknown_log_likelihood_(static_cast<float>(model.unknown_log_likelihood)),
      temperature_(static_cast<float>(model.calibration.temperature)),
      offsets_(model.calibration.offsets.begin(), model.calibration.offsets.end()) {
  assert(model.classes.size() <= kMaxClasses);
  offsets_.resize(model.classes.size(), 0.0F);
  double prior_sum = 0.0;
  for (const ModelClass& model_class : model.classes) prior_sum += model_class.prior;
  for (const ModelClass& model_class : model.classes) {
    mixtures_.emplace_back(model_class.mixture);
    log_prior_.push_back(static_cast<float>(std::log(model_class.prior / prior_sum)));
  }
}

void Classifier::posteriors(const FeatureBlock& block, float temperature, const float* offsets,
                            PosteriorBlock* result) const {
  float(*p)[kSize] = result->probability;
  for (std::size_t c = 0; c < classes(); ++c) mixtures_[c].logLikelihood(block, p[c]);
  const float by_temperature = 1.0F / temperature;
  dispatch([&]() LADAR_INLINE_LAMBDA {
    float best_likelihood[kSize];
    std::copy_n(p[0], kSize, best_likelihood);
    for (std::size_t c = 0; c < classes(); ++c) {
      const float added = log_prior_[c] + (offsets == nullptr ? 0.0F : offsets[c]);
      for (int i = 0; i < kSize; ++i) {
        best_likelihood[i] = std::max(best_likelihood[i], p[c][i]);
        p[c][i] = p[c][i] * by_temperature + added;
      }
    }
    for (int i = 0; i < kSize; ++i) {
      result->known[i] = best_likelihood[i] >= unknown_log_likelihood_ ? 1U : 0U;
    }
    normalizeLogs(p, classes());
  });
}

void Classifier::normalize(PosteriorBlock* block) const {
  dispatch([&]() LADAR_INLINE_LAMBDA { normalizeLogs(block->probability, classes()); });
}

void Classifier::choose(const PosteriorBlock& block, int count, Classification* result) const {
  assert(count <= kSize);
  float greatest[kSize];
  int32_t best[kSize];
  dispatch([&]() LADAR_INLINE_LAMBDA {
    std::copy_n(block.probability[0], kSize, greatest);
    std::fill_n(best, kSize, 0);
    for (std::size_t c = 1; c < classes(); ++c) {
      const float* __restrict__ p = block.probability[c];
      for (int i = 0; i < kSize; ++i) {
        best[i] = p[i] > greatest[i] ? static_cast<int32_t>(c) : best[i];
        greatest[i] = std::max(greatest[i], p[i]);
      }
    }
  });
  for (int i = 0; i < count; ++i) {
    result[i] = block.known[i] != 0 ? Classification{static_cast<uint8_t>(best[i] + 1), greatest[i]}
                                    : Classification();
  }
}

void Classifier::classify(const FeatureBlock& block, int count, Classification* result) const {
  PosteriorBlock posterior;
  calibratedPosteriors(block, &posterior);
  choose(posterior, count, result);
}

}  // namespace ladar_perception
