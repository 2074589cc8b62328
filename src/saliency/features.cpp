// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/features.h"

#include <algorithm>
#include <cassert>

#include "ladar_perception/util/block_math.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

enum class Mapping { kNone, kCubeRoot, kAngle };

Mapping mappingOf(Feature feature) {
  switch (feature) {
    case Feature::kCbrtScatter:
    case Feature::kCbrtSurface:
    case Feature::kCbrtLinear:
      return Mapping::kCubeRoot;
    case Feature::kNormalAngle:
    case Feature::kTangentAngle:
      return Mapping::kAngle;
    default:
      return Mapping::kNone;
  }
}

LADAR_VECTOR_DISPATCH
void mapBlock(Mapping mapping, const double* __restrict__ raw, float* __restrict__ mapped) {
  if (mapping == Mapping::kCubeRoot) {
    for (int i = 0; i < kSaliencyBlock; ++i) {
      mapped[i] = block_math::cubeRoot(static_cast<float>(raw[i]));
    }
  } else if (mapping == Mapping::kAngle) {
    for (int i = 0; i < kSaliencyBlock; ++i) mapped[i] = block_math::acosAbsolute(raw[i]);
  } else {
    for (int i = 0; i < kSaliencyBlock; ++i) mapped[i] = static_cast<float>(raw[i]);
  }
}

}  // namespace

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
  float value = 0.0F;
  featureValues(feature, &saliency, 1, &value);
  return value;
}

void featureValues(Feature feature, const Saliency* saliency, int count, float* values) {
  assert(count <= kSaliencyBlock);
  double raw[kSaliencyBlock] = {};
  const auto gather = [&](auto&& member) {
    for (int i = 0; i < count; ++i) raw[i] = member(saliency[i]);
  };
  switch (feature) {
    case Feature::kScatter:
    case Feature::kCbrtScatter:
      gather([](const Saliency& s) { return s.scatter; });
      break;
    case Feature::kSurface:
    case Feature::kCbrtSurface:
      gather([](const Saliency& s) { return s.surface; });
      break;
    case Feature::kLinear:
    case Feature::kCbrtLinear:
      gather([](const Saliency& s) { return s.linear; });
      break;
    case Feature::kNormalAngle:
      gather([](const Saliency& s) { return s.defined ? s.normal.z() : 1.0; });
      break;
    case Feature::kTangentAngle:
      gather([](const Saliency& s) { return s.defined ? s.tangent.z() : 1.0; });
      break;
  }
  float mapped[kSaliencyBlock];
  mapBlock(mappingOf(feature), raw, mapped);
  std::copy(mapped, mapped + count, values);
}

}  // namespace ladar_perception
