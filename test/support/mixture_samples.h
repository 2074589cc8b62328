// SPDX-License-Identifier: BSD-3-Clause
// Samples drawn from known Gaussians.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "ladar_perception/learn/sample_collector.h"
#include "test_random.h"

namespace ladar_perception::test {

/// `count` samples of a mixture, from `places` places in turn (sorted by place).
inline Samples drawSamples(const std::vector<GaussianComponent>& mixture, std::size_t count,
                           std::size_t places, uint64_t seed) {
  TestRandom random(seed);
  const Eigen::Index n = mixture.front().mean.size();
  Samples samples;
  samples.values.resize(n, static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < count; ++i) {
    double left = random.real(0.0, 1.0);
    std::size_t c = 0;
    while (c + 1 < mixture.size() && left >= mixture[c].weight) left -= mixture[c++].weight;
    Eigen::VectorXd z(n);
    for (double& value : z) value = random.normal();
    const Eigen::MatrixXd l = Eigen::LLT<Eigen::MatrixXd>(mixture[c].covariance).matrixL();
    samples.values.col(static_cast<Eigen::Index>(i)) = mixture[c].mean + l * z;
    samples.places.push_back(i * places / count);
  }
  return samples;
}

}  // namespace ladar_perception::test
