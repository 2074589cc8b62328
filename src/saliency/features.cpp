// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/features.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ladar_perception {

const std::vector<FeatureInfo>& allFeatures() {
  static const std::vector<FeatureInfo> kFeatures = {
      {Feature::kScatter, "scatter", "m^2", "l0, how much the points fill space"},
      {Feature::kSurface, "surface", "m^2", "l1 - l0, how much they form a surface"},
      {Feature::kLinear, "linear", "m^2", "l2 - l1, how much they form a line"},
      // Cube roots spread the small values out, where a Gaussian cannot follow the raw ones.
      {Feature::kCbrtScatter, "cbrt_scatter", "m^(2/3)", "cube root of scatter"},
      {Feature::kCbrtSurface, "cbrt_surface", "m^(2/3)", "cube root of surface"},
      {Feature::kCbrtLinear, "cbrt_linear", "m^(2/3)", "cube root of linear"},
      {Feature::kNormalAngle, "normal_angle", "rad", "angle of the normal to the vertical"},
      {Feature::kTangentAngle, "tangent_angle", "rad", "angle of the tangent to the vertical"},
  };
  return kFeatures;
}

std::optional<Feature> featureFromName(const std::string& name) {
  for (const FeatureInfo& info : allFeatures()) {
    if (name == info.name) return info.feature;
  }
  return std::nullopt;
}

const char* featureName(Feature feature) {
  for (const FeatureInfo& info : allFeatures()) {
    if (feature == info.feature) return info.name;
  }
  return "";
}

float featureValue(Feature feature, const Saliency& saliency) {
  assert(saliency.defined);
  const auto verticalAngle = [](const Eigen::Vector3d& direction) {
    return static_cast<float>(std::acos(std::min(std::abs(direction.z()), 1.0)));
  };
  switch (feature) {
    case Feature::kScatter:
      return static_cast<float>(saliency.scatter);
    case Feature::kSurface:
      return static_cast<float>(saliency.surface);
    case Feature::kLinear:
      return static_cast<float>(saliency.linear);
    case Feature::kCbrtScatter:
      return static_cast<float>(std::cbrt(saliency.scatter));
    case Feature::kCbrtSurface:
      return static_cast<float>(std::cbrt(saliency.surface));
    case Feature::kCbrtLinear:
      return static_cast<float>(std::cbrt(saliency.linear));
    case Feature::kNormalAngle:
      return verticalAngle(saliency.normal);
    case Feature::kTangentAngle:
      return verticalAngle(saliency.tangent);
  }
  return 0.0F;
}

}  // namespace ladar_perception
