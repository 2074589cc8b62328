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

/// Turns the logarithms of what is proportional to probabilities, times `scale`, into
/// probabilities, in place.
LADAR_INLINE void normalize(float (*__restrict__ p)[kSize], std::size_t classes, float scale) {
  float greatest[kSize];
  float sum[kSize];
  std::copy_n(p[0], kSize, greatest);
  for (std::size_t c = 1; c < classes; ++c) {
    for (int i = 0; i < kSize; ++i) greatest[i] = std::max(greatest[i], p[c][i]);
  }
  std::fill_n(sum, kSize, 0.0F);
  for (std::size_t c = 0; c < classes; ++c) {
    for (int i = 0; i < kSize; ++i) {
      p[c][i] = block_math::expNegative((p[c][i] - greatest[i]) * scale);
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
      temperature_(static_cast<float>(model.calibration.temperature)) {
  assert(model.classes.size() <= kMaxClasses);
  double prior_sum = 0.0;
  for (const ModelClass& model_class : model.classes) prior_sum += model_class.prior;
  for (const ModelClass& model_class : model.classes) {
    mixtures_.emplace_back(model_class.mixture);
    log_prior_.push_back(static_cast<float>(std::log(model_class.prior / prior_sum)));
  }
}

void Classifier::posteriors(const FeatureBlock& block, float temperature,
                            PosteriorBlock* result) const {
  float(*p)[kSize] = result->probability;
  for (std::size_t c = 0; c < classes(); ++c) mixtures_[c].logLikelihood(block, p[c]);
  dispatch([&]() LADAR_INLINE_LAMBDA {
    float best_likelihood[kSize];
    std::copy_n(p[0], kSize, best_likelihood);
    for (std::size_t c = 0; c < classes(); ++c) {
      const float log_prior = log_prior_[c];
      for (int i = 0; i < kSize; ++i) {
        best_likelihood[i] = std::max(best_likelihood[i], p[c][i]);
        p[c][i] += log_prior;
      }
    }
    for (int i = 0; i < kSize; ++i) {
      result->known[i] = best_likelihood[i] >= unknown_log_likelihood_ ? 1U : 0U;
    }
    normalize(p, classes(), 1.0F / temperature);
  });
}

void Classifier::sharpen(float sharpness, PosteriorBlock* block) const {
  constexpr float kLeast = 1e-6F;  // below the steps in which smoothed posteriors come
  dispatch([&]() LADAR_INLINE_LAMBDA {
    for (std::size_t c = 0; c < classes(); ++c) {
      float* p = block->probability[c];
      for (int i = 0; i < kSize; ++i) p[i] = block_math::logPositive(std::max(p[i], kLeast));
    }
    normalize(block->probability, classes(), sharpness);
  });
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
  posteriors(block, temperature_, &posterior);
  choose(posterior, count, result);
}

}  // namespace ladar_perception
