// SPDX-License-Identifier: BSD-3-Clause
// Gaussian mixtures, evaluated for many feature vectors at a time.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ladar_perception/saliency/saliency.h"

namespace ladar_perception {

/// One Gaussian of a mixture.
struct GaussianComponent {
  double weight = 0.0;
  Eigen::VectorXd mean;        ///< one entry per feature
  Eigen::MatrixXd covariance;  ///< features x features, symmetric positive definite
};

/// Features of a block of support volumes, feature by feature: value(f, i) of volume i.
class FeatureBlock {
 public:
  static constexpr int kSize = kSaliencyBlock;  ///< volumes in a block

  explicit FeatureBlock(int features) : values_(static_cast<std::size_t>(features) * kSize) {}
  float* row(int feature) { return values_.data() + static_cast<std::size_t>(feature) * kSize; }
  const float* row(int feature) const {
    return values_.data() + static_cast<std::size_t>(feature) * kSize;
  }

 private:
  std::vector<float> values_;
};

/// log p(features) of a mixture of Gaussians with full covariances.
class GaussianMixture {
 public:
  static constexpr std::size_t kMaxComponents = 64;

  /// Why the components are no mixture over `features` features, or "": weights are positive and
  /// sum to 1, there are at most kMaxComponents, means and covariances are finite and of that size,
  /// covariances are symmetric and positive definite.
  static std::string error(const std::vector<GaussianComponent>& components, int features);

  /// `components` for which `error` is empty.
  explicit GaussianMixture(const std::vector<GaussianComponent>& components);

  /// Writes FeatureBlock::kSize log-likelihoods (natural logarithm). float32; the error of a
  /// log-likelihood is about 1e-6 of its squared Mahalanobis distance.
  void logLikelihood(const FeatureBlock& block, float* log_likelihood) const;

 private:
  struct Kernel {
    float log_scale;               // log weight - 1/2 log det(2 pi covariance)
    std::vector<float> offset;     // L^-1 mean, per feature; covariance = L L^T
    std::vector<float> whitening;  // lower triangle of L^-1 by rows
  };

  std::vector<Kernel> kernels_;
};

}  // namespace ladar_perception
