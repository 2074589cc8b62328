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

/// Probabilities of the classes for a block of support volumes.
struct PosteriorBlock {
  /// By class, then volume; of the model's classes they sum to 1.
  float probability[kMaxClasses][FeatureBlock::kSize];
  /// 0 where nothing is to be said: the greatest log-likelihood is below the model's threshold.
  uint32_t known[FeatureBlock::kSize];
};

/// The class of greatest prior times likelihood of support volumes, block by block.
class Classifier {
 public:
  explicit Classifier(const ClassifierModel& model);

  const std::vector<Feature>& features() const { return features_; }
  std::size_t classes() const { return mixtures_.size(); }
  /// Posteriors under the model's priors: prior (likelihood)^(1 / temperature), times e^offset if
  /// there are offsets (one per class). All of the block must hold finite numbers.
  void posteriors(const FeatureBlock& block, float temperature, const float* offsets,
                  PosteriorBlock* result) const;
  /// The same by the model's calibration without smoothing.
  void calibratedPosteriors(const FeatureBlock& block, PosteriorBlock* result) const {
    posteriors(block, temperature_, offsets_.data(), result);
  }
  /// Makes probabilities of their logarithms, which may lack a common term.
  void normalize(PosteriorBlock* block) const;
  /// The most probable class of the first `count` volumes, the first of equal ones.
  void choose(const PosteriorBlock& block, int count, Classification* result) const;
  /// calibratedPosteriors, then choose.
  void classify(const FeatureBlock& block, int count, Classification* result) const;

 private:
  std::vector<Feature> features_;
  std::vector<GaussianMixture> mixtures_;
  std::vector<float> log_prior_;
  float unknown_log_likelihood_;
  float temperature_;
  std::vector<float> offsets_;
};

}  // namespace ladar_perception
