// SPDX-License-Identifier: BSD-3-Clause
// Learns the Gaussian mixture of one class by expectation maximisation.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ladar_perception/classify/gaussian_mixture.h"
#include "ladar_perception/learn/sample_collector.h"

namespace ladar_perception {

/// What decides on the number of components.
enum class ComponentChoice {
  /// The log-likelihood of samples from places that were left out of learning, as far as there are
  /// places enough, else kBic. Neighbouring samples are much alike: left out one by one, they
  /// would call for ever more components.
  kHeldOut,
  kBic,  ///< the Bayesian information criterion
};

struct MixtureOptions {
  std::vector<int> candidates = {1, 2, 3, 4, 5, 6, 8};  ///< numbers of components, ascending
  ComponentChoice choice = ComponentChoice::kHeldOut;
  uint64_t seed = 1;
};

/// How well a number of components does; log-likelihoods are per sample, natural logarithm.
struct MixtureScore {
  int components = 0;
  double log_likelihood = 0.0;  ///< of the samples that were learned from
  double bic = 0.0;             ///< less is better
  double held_out = 0.0;        ///< log-likelihood of samples left out; NaN if that was not tried
  double held_out_error = 0.0;  ///< standard error of held_out, from the spread between folds
};

struct LearnedMixture {
  std::vector<GaussianComponent> components;
  ComponentChoice choice = ComponentChoice::kBic;  ///< what decided
  std::vector<MixtureScore> scores;                ///< one per candidate that was tried
};

/// Fewest samples that a mixture is learned from.
constexpr std::size_t kLeastSamples = 50;
/// Samples that a component needs at least, next to one per feature.
constexpr std::size_t kLeastSamplesPerComponent = 10;

/// Learns from the samples of one class. `floor` (per feature, positive) is added to the variances
/// of every component: narrower ones would follow the training scenes, not the class. All scores
/// are of mixtures with the floor in them, as they will be used. The number of components is the
/// least whose held-out log-likelihood is within one standard error of the best, or that of the
/// least BIC. The same arguments give the same bits. `advance` is called after every fit
/// (see fitCount). Throws std::runtime_error if there are fewer than kLeastSamples or EM fails.
LearnedMixture learnMixture(const Samples& samples, const Eigen::VectorXd& floor,
                            const MixtureOptions& options,
                            const std::function<void()>& advance = {});
/// Fits that learnMixture will make.
std::size_t fitCount(const Samples& samples, const MixtureOptions& options);

/// Log-likelihoods of samples (features x samples), by the code that runs on the vehicle.
std::vector<double> logLikelihoods(const GaussianMixture& mixture, const Eigen::MatrixXd& values);

}  // namespace ladar_perception
