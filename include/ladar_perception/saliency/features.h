// SPDX-License-Identifier: BSD-3-Clause
// The features a classifier can be learned on, by name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ladar_perception/saliency/saliency.h"

namespace ladar_perception {

/// A number computed from a support volume's saliency.
enum class Feature {
  kScatter,
  kSurface,
  kLinear,
  kCbrtScatter,
  kCbrtSurface,
  kCbrtLinear,
  kNormalAngle,
  kTangentAngle,
};

/// Name, unit and meaning of a feature, for model files and documentation.
struct FeatureInfo {
  Feature feature;
  const char* name;
  const char* unit;
  const char* meaning;
};

/// Every feature there is.
const std::vector<FeatureInfo>& allFeatures();
/// The feature of that name, or nothing.
std::optional<Feature> featureFromName(const std::string& name);
const char* featureName(Feature feature);
/// Value of a feature; what it is for undefined saliency is not to be used. Roots and angles are
/// good to 3e-7.
float featureValue(Feature feature, const SaliencyF& saliency);
/// The same, bit by bit, for a block: SaliencyBlock::kSize values.
void featureValues(Feature feature, const SaliencyBlock& block, float* values);

}  // namespace ladar_perception
