// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/classify/classifier_model.h"

namespace ladar_perception::test {

/// One Gaussian without correlations.
inline GaussianComponent gaussian(double weight, const std::vector<double>& mean,
                                  const std::vector<double>& deviation) {
  GaussianComponent component;
  component.weight = weight;
  component.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), mean.size());
  const Eigen::VectorXd d = Eigen::Map<const Eigen::VectorXd>(deviation.data(), deviation.size());
  component.covariance = d.array().square().matrix().asDiagonal();
  return component;
}

constexpr uint8_t kSurfaceLabel = 1;
constexpr uint8_t kScatterLabel = 2;
constexpr uint8_t kLinearLabel = 3;

/// Surface, scatter and linear on the cube roots of the saliencies, for 0.1 m voxels and r = 4.
/// A plane across the cube of 0.9 m has eigenvalues near (0, 0.07, 0.07), a full cube three times
/// 0.07, a line one of 0.07; 0.07^(1/3) is 0.41.
inline ClassifierModel handModel() {
  ClassifierModel model;
  model.voxel_size_m = 0.1;
  model.support_radius_voxels = 4;
  model.features = {{Quantity::kCbrtScatter}, {Quantity::kCbrtSurface}, {Quantity::kCbrtLinear}};
  const std::vector<double> deviation = {0.12, 0.12, 0.12};
  model.classes = {{"surface", 0xff0000, 1.0, {gaussian(1.0, {0.05, 0.4, 0.2}, deviation)}},
                   {"scatter", 0x00ff00, 1.0, {gaussian(1.0, {0.4, 0.15, 0.2}, deviation)}},
                   {"linear", 0x0000ff, 1.0, {gaussian(1.0, {0.05, 0.05, 0.4}, deviation)}}};
  model.provenance = {{"source", "made by hand for tests"}};
  return model;
}

}  // namespace ladar_perception::test
