// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/features.h"

#include <algorithm>
#include <cmath>

#include "ladar_perception/util/block_math.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

constexpr int kSize = SaliencyBlock::kSize;

LADAR_INLINE void cubeRoots(const float* __restrict__ x, float* __restrict__ values) {
  for (int i = 0; i < kSize; ++i) values[i] = block_math::cubeRoot(x[i]);
}

LADAR_INLINE void anglesToVertical(const float (&direction)[3][kSize], float* __restrict__ values) {
  for (int i = 0; i < kSize; ++i) {
    const float x = direction[0][i];
    const float y = direction[1][i];
    values[i] = block_math::angleToVertical(std::sqrt(x * x + y * y), direction[2][i]);
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

float featureValue(Feature feature, const SaliencyF& saliency) {
  SaliencyBlock block = {};
  block.set(0, saliency);
  float values[kSize];
  featureValues(feature, block, values);
  return values[0];
}

void featureValues(Feature feature, const SaliencyBlock& block, float* values) {
  dispatch([&]() LADAR_INLINE_LAMBDA {
    switch (feature) {
      case Feature::kScatter:
        std::copy_n(block.scatter, kSize, values);
        break;
      case Feature::kSurface:
        std::copy_n(block.surface, kSize, values);
        break;
      case Feature::kLinear:
        std::copy_n(block.linear, kSize, values);
        break;
      case Feature::kCbrtScatter:
        cubeRoots(block.scatter, values);
        break;
      case Feature::kCbrtSurface:
        cubeRoots(block.surface, values);
        break;
      case Feature::kCbrtLinear:
        cubeRoots(block.linear, values);
        break;
      case Feature::kNormalAngle:
        anglesToVertical(block.normal, values);
        break;
      case Feature::kTangentAngle:
        anglesToVertical(block.tangent, values);
        break;
    }
  });
}

}  // namespace ladar_perception
