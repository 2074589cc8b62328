// SPDX-License-Identifier: BSD-3-Clause
// Models that use all a model can name.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hand_model.h"
#include "ladar_perception/terrain/terrain_config.h"
#include "test_random.h"

namespace ladar_perception::test {

/// The model made by hand, said to be learned on the configuration's voxels and support.
inline ClassifierModel modelFor(const TerrainConfig& config) {
  ClassifierModel model = handModel();
  model.voxel_size_m = config.voxel_size_m;
  model.support_radius_voxels = config.support_radius_voxels;
  model.support_kernel = config.support_kernel;
  return model;
}

/// Classes that are mixtures of two Gaussians anywhere, as wide as features commonly are, so that
/// every class is the likeliest somewhere.
inline std::vector<ModelClass> randomClasses(int classes, int features, uint64_t seed) {
  TestRandom random(seed);
  std::vector<ModelClass> result;
  for (int c = 0; c < classes; ++c) {
    ModelClass model_class;
    model_class.name = "class " + std::to_string(c + 1);
    model_class.rgb = static_cast<uint32_t>(random.integer(0, 0xffffff));
    model_class.prior = random.real(0.5, 1.0);
    for (const double weight : {0.375, 0.625}) {
      std::vector<double> mean;
      for (int f = 0; f < features; ++f) mean.push_back(random.real(-0.5, 1.0));
      model_class.mixture.push_back(gaussian(weight, mean, std::vector<double>(features, 0.6)));
    }
    result.push_back(model_class);
  }
  return result;
}

/// A model of these features, its classes at random.
inline ClassifierModel randomModel(const TerrainConfig& config,
                                   const std::vector<std::string>& features, int classes,
                                   uint64_t seed = 1) {
  ClassifierModel model = modelFor(config);
  model.features = parseFeatures(features);
  model.classes = randomClasses(classes, static_cast<int>(features.size()), seed);
  return model;
}

/// Features at the configured support and two others, one of them no cube, and every quantity of
/// columns, some at several radii.
inline std::vector<std::string> wideFeatures() {
  return {"cbrt_scatter",  "log_points@2",     "normal_angle@2", "spread_angle@5x1",
          "log_height@3",  "log_height@9",     "mean_offset",    "log_ground_height@4",
          "log_fill@5",    "log_fill@2",       "sqrt_height@9",  "horizontal_ratio@5x1",
          "level_surface", "upright_linear@2", "cbrt_linear"};
}

}  // namespace ladar_perception::test
