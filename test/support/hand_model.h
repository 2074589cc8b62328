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

/// Surface, scatter and linear on the cube roots of the saliencies, for 0.1 m voxels and r = 6.
/// A plane across the cube of 1.3 m has eigenvalues near (0, 0.14, 0.14), a full cube three times
/// 0.14, a line one of 0.14; 0.14^(1/3) is 0.52.
inline ClassifierModel handModel() {
  ClassifierModel model;
  model.voxel_size_m = 0.1;
  model.support_radius_voxels = 6;
  model.features = {{Quantity::kCbrtScatter}, {Quantity::kCbrtSurface}, {Quantity::kCbrtLinear}};
  const std::vector<double> deviation = {0.15, 0.15, 0.15};
  model.classes = {{"surface", 0xff0000, 1.0, {gaussian(1.0, {0.06, 0.51, 0.26}, deviation)}},
                   {"scatter", 0x00ff00, 1.0, {gaussian(1.0, {0.51, 0.19, 0.26}, deviation)}},
                   {"linear", 0x0000ff, 1.0, {gaussian(1.0, {0.06, 0.06, 0.51}, deviation)}}};
  model.provenance = {{"source", "made by hand for tests"}};
  return model;
}

}  // namespace ladar_perception::test
