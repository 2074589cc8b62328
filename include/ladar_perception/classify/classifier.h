// SPDX-License-Identifier: BSD-3-Clause
// Maximum-likelihood classification of support volumes.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/classify/gaussian_mixture.h"

namespace ladar_perception {

/// What a support volume is taken for.
struct Classification {
  uint8_t label = kUnknownLabel;
  float confidence = 0.0F;  ///< posterior probability of the label under the model's priors
};

/// Labels blocks of support volumes with the class of greatest prior times likelihood.
class Classifier {
 public:
  explicit Classifier(const ClassifierModel& model);

  const std::vector<Feature>& features() const { return features_; }
  /// Classifies the first `count` <= FeatureBlock::kSize volumes of the block (the rest of the
  /// block must hold finite numbers). A volume whose greatest log-likelihood is below the model's
  /// threshold is unknown.
  void classify(const FeatureBlock& block, int count, Classification* result) const;

 private:
  std::vector<Feature> features_;
  std::vector<GaussianMixture> mixtures_;
  std::vector<float> log_prior_;
  float unknown_log_likelihood_;
};

}  // namespace ladar_perception
