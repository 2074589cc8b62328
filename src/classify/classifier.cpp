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

/// Lane by lane: the greatest likelihood, and the class of greatest prior times likelihood (the
/// first of equal ones) with its posterior probability.
LADAR_INLINE void choose(float (*log_joint)[kSize], const float* log_prior, std::size_t classes,
                         float* __restrict__ best_likelihood, int32_t* __restrict__ best,
                         float* __restrict__ posterior) {
  float best_joint[kSize];
  float log_evidence[kSize];
  for (std::size_t c = 0; c < classes; ++c) {
    const float* __restrict__ log_likelihood = log_joint[c];
    float joint[kSize];
    for (int i = 0; i < kSize; ++i) joint[i] = log_likelihood[i] + log_prior[c];
    if (c == 0) {
      std::copy_n(log_likelihood, kSize, best_likelihood);
      std::copy_n(joint, kSize, best_joint);
      std::copy_n(joint, kSize, log_evidence);
      std::fill_n(best, kSize, 0);
      continue;
    }
    for (int i = 0; i < kSize; ++i) {
      best_likelihood[i] = std::max(best_likelihood[i], log_likelihood[i]);
      best[i] = joint[i] > best_joint[i] ? static_cast<int32_t>(c) : best[i];
      best_joint[i] = std::max(best_joint[i], joint[i]);
    }
    block_math::logAddExp<kSize>(joint, log_evidence);
  }
  for (int i = 0; i < kSize; ++i) {
    posterior[i] = block_math::expNegative(std::min(best_joint[i] - log_evidence[i], 0.0F));
  }
}

}  // namespace

Classifier::Classifier(const ClassifierModel& model)
    : features_(model.features),
      unknown_log_likelihood_(static_cast<float>(model.unknown_log_likelihood)) {
  double prior_sum = 0.0;
  for (const ModelClass& model_class : model.classes) prior_sum += model_class.prior;
  for (const ModelClass& model_class : model.classes) {
    mixtures_.emplace_back(model_class.mixture);
    log_prior_.push_back(static_cast<float>(std::log(model_class.prior / prior_sum)));
  }
}

void Classifier::classify(const FeatureBlock& block, int count, Classification* result) const {
  assert(count <= kSize && mixtures_.size() <= kMaxClasses);
  float log_joint[kMaxClasses][kSize];
  for (std::size_t c = 0; c < mixtures_.size(); ++c) {
    mixtures_[c].logLikelihood(block, log_joint[c]);
  }
  float best_likelihood[kSize];
  float posterior[kSize];
  int32_t best[kSize];
  dispatch([&]() LADAR_INLINE_LAMBDA {
    choose(log_joint, log_prior_.data(), log_prior_.size(), best_likelihood, best, posterior);
  });
  for (int i = 0; i < count; ++i) {
    const bool known = best_likelihood[i] >= unknown_log_likelihood_;
    result[i] =
        known ? Classification{static_cast<uint8_t>(best[i] + 1), posterior[i]} : Classification();
  }
}

}  // namespace ladar_perception
