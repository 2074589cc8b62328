// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/classify/classifier.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "ladar_perception/util/block_math.h"

namespace ladar_perception {

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
  constexpr int kSize = FeatureBlock::kSize;
  assert(count <= kSize && mixtures_.size() <= kMaxClasses);
  float log_joint[kMaxClasses][kSize];
  float best_likelihood[kSize];
  for (std::size_t c = 0; c < mixtures_.size(); ++c) {
    mixtures_[c].logLikelihood(block, log_joint[c]);
    for (int i = 0; i < kSize; ++i) {
      best_likelihood[i] = c == 0 ? log_joint[c][i] : std::max(best_likelihood[i], log_joint[c][i]);
      log_joint[c][i] += log_prior_[c];
    }
  }
  float log_evidence[kSize];
  std::copy(log_joint[0], log_joint[0] + kSize, log_evidence);
  for (std::size_t c = 1; c < mixtures_.size(); ++c) {
    block_math::logAddExp<kSize>(log_joint[c], log_evidence);
  }
  for (int i = 0; i < count; ++i) {
    std::size_t best = 0;
    for (std::size_t c = 1; c < mixtures_.size(); ++c) {
      if (log_joint[c][i] > log_joint[best][i]) best = c;
    }
    if (best_likelihood[i] < unknown_log_likelihood_) {
      result[i] = Classification();
      continue;
    }
    const float log_posterior = std::min(log_joint[best][i] - log_evidence[i], 0.0F);
    result[i] = {static_cast<uint8_t>(best + 1), block_math::expNegative(log_posterior)};
  }
}

}  // namespace ladar_perception
