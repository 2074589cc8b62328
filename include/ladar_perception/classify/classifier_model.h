// SPDX-License-Identifier: BSD-3-Clause
// What was learned: classes, their mixtures, and what they were learned on; and its YAML file.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "ladar_perception/classify/gaussian_mixture.h"
#include "ladar_perception/saliency/features.h"

namespace ladar_perception {

/// The label of points and voxels nothing can be said about.
constexpr uint8_t kUnknownLabel = 0;
constexpr uint32_t kUnknownColor = 0x808080;
/// Labels 1 to 16 are classes.
constexpr std::size_t kMaxClasses = 16;

struct ModelClass {
  std::string name;
  uint32_t rgb = 0;    ///< 0x00RRGGBB
  double prior = 1.0;  ///< relative, any positive number; all equal for maximum likelihood
  std::vector<GaussianComponent> mixture;
};

/// What turns likelihoods into probabilities that come true as often as they say: features of one
/// support volume depend on one another more than a mixture knows, so bare posteriors are too sure,
/// and mean posteriors of a neighbourhood favour what is bulky. Empty lists of offsets are zeros.
struct Calibration {
  static constexpr int kMaxSmoothingRadius = 12;

  /// A class's probability is proportional to prior (likelihood)^(1 / temperature) e^offset.
  double temperature = 1.0;
  std::vector<double> offsets;  ///< by class

  /// The same with smoothing: proportional to the product, to the power of an exponent each, of the
  /// voxel's posterior at `temperature` (without offsets) and of the means of the neighbours'
  /// posteriors in cubes of these radii, times e^offset.
  struct Smoothing {
    double temperature = 2.0;
    std::vector<int> radii_voxels = {4, 12};
    std::vector<double> exponents = {0.2, 0.5, 1.0};  ///< of the voxel's own, then by radius
    std::vector<double> offsets;                      ///< by class
  };
  Smoothing smoothing;
};

/// A classifier as it is kept in a file. The label of classes[i] is i + 1.
struct ClassifierModel {
  std::vector<ModelClass> classes;
  std::vector<Feature> features;
  double voxel_size_m = 0.0;
  int support_radius_voxels = 0;
  std::string support_kernel = "box";
  Calibration calibration;
  /// Support volumes whose best log-likelihood is lower are unknown; -inf to label them all.
  double unknown_log_likelihood = -std::numeric_limits<double>::infinity();
  /// Where it comes from: what was simulated or recorded, counts, seeds. For people.
  std::map<std::string, std::string> provenance;

  /// "unknown" or the class's name.
  std::string labelName(uint8_t label) const;
  uint32_t labelColor(uint8_t label) const;
};

/// Reads a model file. Throws std::runtime_error with file, line and what was expected if a key is
/// missing, unknown or of the wrong kind, or a mixture is none.
ClassifierModel loadClassifierModel(const std::string& path);
/// The same from text; `path` is what messages call it.
ClassifierModel parseClassifierModel(const std::string& text, const std::string& path);
/// Writes the model as YAML; throws std::runtime_error if the file cannot be written.
void saveClassifierModel(const ClassifierModel& model, const std::string& path);
std::string formatClassifierModel(const ClassifierModel& model);

/// Why a model learned for other voxels or another support volume must not be used, or "".
std::string modelMisfit(const ClassifierModel& model, double voxel_size_m,
                        int support_radius_voxels, const std::string& support_kernel = "box");

}  // namespace ladar_perception
