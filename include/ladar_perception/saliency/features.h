// SPDX-License-Identifier: BSD-3-Clause
// The features a classifier can be learned on, by name.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/map/column_layer.h"
#include "ladar_perception/saliency/box_sums.h"
#include "ladar_perception/saliency/saliency.h"

namespace ladar_perception {

/// What a feature measures. l0 <= l1 <= l2 are the eigenvalues of the scatter matrix, sh0 <= sh1
/// the standard deviations of its horizontal 2 x 2 part, sz the vertical one.
enum class Quantity {
  // Of the points in a support volume.
  kScatter,
  kSurface,
  kLinear,
  kCbrtScatter,
  kCbrtSurface,
  kCbrtLinear,
  kNormalAngle,
  kTangentAngle,
  kSpreadAngle,
  kHorizontalRatio,
  kScatterRatio,
  kThicknessRatio,
  kLevelSurface,
  kUprightSurface,
  kLevelLinear,
  kUprightLinear,
  kHorizontalMinor,
  kHorizontalMajor,
  kVerticalDeviation,
  kMeanOffset,
  kLogPoints,
  // Of the columns around a voxel.
  kLogHeight,
  kSqrtHeight,
  kLogGroundHeight,
  kLogFill,
};

/// Name, unit and meaning of a quantity, for model files and documentation.
struct QuantityInfo {
  Quantity quantity;
  const char* name;
  const char* unit;
  const char* meaning;
};

/// Every quantity there is.
const std::vector<QuantityInfo>& allQuantities();
const QuantityInfo& quantityInfo(Quantity quantity);
/// Whether it is of the columns around a voxel, not of a support volume.
bool isOfColumns(Quantity quantity);
/// The layer that a quantity of columns is computed from.
ColumnQuantity columnQuantity(Quantity quantity);

/// A quantity and where it is measured.
struct Feature {
  Quantity quantity = Quantity::kScatter;
  /// Support volume, {0, 0} for the one the map is configured for. Of a quantity of columns:
  /// radius_xy is how many columns away the square reaches, radius_z is 0.
  SupportBox box = {0, 0};

  bool operator==(const Feature& other) const {
    return quantity == other.quantity && box == other.box;
  }
  bool isOfConfiguredSupport() const { return !isOfColumns(quantity) && box == SupportBox{0, 0}; }
};

/// The feature of a name: a quantity's name; behind it `@R` for the cube of radius R voxels, or
/// `@RxZ` for the box of radius R along x and y and Z along z; quantities of columns need `@R`.
/// Throws std::invalid_argument that says what is wrong and what was expected.
Feature parseFeature(const std::string& name);
std::string featureName(const Feature& feature);

/// Features by the name of a set ("saliency", "standard", ...) or a list of names.
std::vector<Feature> parseFeatures(const std::vector<std::string>& names);
/// Named sets, for documentation and messages: name and the features' names.
struct FeatureSet {
  const char* name;
  const char* meaning;
  std::vector<std::string> features;
};
const std::vector<FeatureSet>& featureSets();

/// Values of a quantity of support volumes for a block: SaliencyBlock::kSize values. What it is for
/// undefined saliency is finite and not to be used. Roots, logarithms and angles are good to 3e-7.
void featureValues(Quantity quantity, const SaliencyBlock& block, float* values);
/// The same of a quantity of columns, from the block's heights over the layer in voxels (of
/// kLogFill: from the layer's values).
void columnFeatureValues(Quantity quantity, const int32_t* numbers, double voxel_size_m,
                         float* values);

}  // namespace ladar_perception
