// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/classify/gaussian_mixture.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "ladar_perception/util/block_math.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

constexpr int kSize = FeatureBlock::kSize;
constexpr float kLeastLogDensity = -1e30F;

std::string componentError(const GaussianComponent& component, int features) {
  if (!(component.weight > 0.0) || !std::isfinite(component.weight)) {
    return "weight must be positive";
  }
  if (component.mean.size() != features || !component.mean.allFinite()) {
    return "mean must have " + std::to_string(features) + " finite numbers";
  }
  const Eigen::MatrixXd& covariance = component.covariance;
  if (covariance.rows() != features || covariance.cols() != features || !covariance.allFinite()) {
    return "covariance must be " + std::to_string(features) + " x " + std::to_string(features) +
           " finite numbers";
  }
  const double tolerance = 1e-6 * covariance.cwiseAbs().maxCoeff();
  if (!covariance.isApprox(covariance.transpose(), 1e-6) &&
      (covariance - covariance.transpose()).cwiseAbs().maxCoeff() > tolerance) {
    return "covariance must be symmetric";
  }
  if (Eigen::LLT<Eigen::MatrixXd>(covariance).info() != Eigen::Success) {
    return "covariance must be positive definite";
  }
  return "";
}

/// Log density of one weighted Gaussian; `features` are rows of kSize lanes.
LADAR_INLINE void logDensity(const float* __restrict__ features, float log_scale,
                             const float* __restrict__ offset, const float* __restrict__ whitening,
                             int feature_count, float* __restrict__ log_density) {
  float squared[kSize] = {};
  const float* w = whitening;
  for (int i = 0; i < feature_count; ++i) {
    float whitened[kSize];
    std::fill_n(whitened, kSize, -offset[i]);
    for (int j = 0; j <= i; ++j, ++w) {
      const float* __restrict__ value = features + j * kSize;
      for (int lane = 0; lane < kSize; ++lane) whitened[lane] += *w * value[lane];
    }
    for (int lane = 0; lane < kSize; ++lane) squared[lane] += whitened[lane] * whitened[lane];
  }
  // Beyond 1e15 deviations squares overflow; -inf or NaN would spoil every sum they enter. The
  // order of the arguments matters: max(a, NaN) is a.
  for (int lane = 0; lane < kSize; ++lane) {
    log_density[lane] = std::max(kLeastLogDensity, log_scale - 0.5F * squared[lane]);
  }
}

/// Lane by lane, the logarithm of the sum of the densities; `greatest` is the greatest of them.
LADAR_INLINE void logSumExp(const float (*log_density)[kSize], std::size_t count,
                            const float* __restrict__ greatest, float* __restrict__ log_sum) {
  float sum[kSize] = {};
  for (std::size_t c = 0; c < count; ++c) {
    const float* __restrict__ density = log_density[c];
    for (int lane = 0; lane < kSize; ++lane) {
      sum[lane] += block_math::expNegative(density[lane] - greatest[lane]);
    }
  }
  for (int lane = 0; lane < kSize; ++lane) {
    log_sum[lane] = greatest[lane] + block_math::logPositive(sum[lane]);
  }
}

}  // namespace

std::string GaussianMixture::error(const std::vector<GaussianComponent>& components, int features) {
  if (components.empty()) return "has no components";
  if (components.size() > kMaxComponents) {
    return "has " + std::to_string(components.size()) + " components, expected at most " +
           std::to_string(kMaxComponents);
  }
  double weights = 0.0;
  for (std::size_t i = 0; i < components.size(); ++i) {
    const std::string problem = componentError(components[i], features);
    if (!problem.empty()) return "component " + std::to_string(i) + ": " + problem;
    weights += components[i].weight;
  }
  if (std::abs(weights - 1.0) > 1e-3) {
    return "weights sum to " + std::to_string(weights) + ", expected 1";
  }
  return "";
}

GaussianMixture::GaussianMixture(const std::vector<GaussianComponent>& components) {
  constexpr double kLog2Pi = 1.8378770664093453;
  for (const GaussianComponent& component : components) {
    const auto n = component.mean.size();
    const Eigen::MatrixXd l = Eigen::LLT<Eigen::MatrixXd>(component.covariance).matrixL();
    const Eigen::MatrixXd inverse =
        l.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(n, n));
    Kernel kernel;
    kernel.log_scale =
        static_cast<float>(std::log(component.weight) - 0.5 * static_cast<double>(n) * kLog2Pi -
                           l.diagonal().array().log().sum());
    for (Eigen::Index i = 0; i < n; ++i) {
      kernel.offset.push_back(static_cast<float>(inverse.row(i).dot(component.mean)));
      for (Eigen::Index j = 0; j <= i; ++j) {
        kernel.whitening.push_back(static_cast<float>(inverse(i, j)));
      }
    }
    kernels_.push_back(std::move(kernel));
  }
}

void GaussianMixture::logLikelihood(const FeatureBlock& block, float* log_likelihood) const {
  assert(kernels_.size() <= kMaxComponents);
  dispatch([&]() LADAR_INLINE_LAMBDA {
    float log_density[kMaxComponents][kSize];
    float greatest[kSize];
    std::fill_n(greatest, kSize, kLeastLogDensity);
    for (std::size_t c = 0; c < kernels_.size(); ++c) {
      const Kernel& kernel = kernels_[c];
      logDensity(block.row(0), kernel.log_scale, kernel.offset.data(), kernel.whitening.data(),
                 static_cast<int>(kernel.offset.size()), log_density[c]);
      for (int lane = 0; lane < kSize; ++lane) {
        greatest[lane] = std::max(greatest[lane], log_density[c][lane]);
      }
    }
    logSumExp(log_density, kernels_.size(), greatest, log_likelihood);
  });
}

}  // namespace ladar_perception
