// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/features.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ladar_perception/saliency/box_stack.h"
#include "ladar_perception/util/block_math.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

constexpr int kSize = SaliencyBlock::kSize;
constexpr float kTiny = 1e-12F;  // m^2; a millionth of a metre squared
constexpr int kMaxColumnRadius = 100;
// Wider supports would let voxels hold fewer points than sensors bring.
constexpr uint32_t kLeastPointsPerVoxel = 200;
constexpr float kHeightOffset_m = 0.1F;  // so that the ground's heights are not spread out

/// values[i] = formula(i) for a block.
template <typename Formula>
LADAR_INLINE void fill(float* __restrict__ values, const Formula& formula) {
  for (int i = 0; i < kSize; ++i) values[i] = formula(i);
}

/// Greatest and least variance of the horizontal part of a scatter matrix.
struct Horizontal {
  float major;
  float minor;
};
LADAR_INLINE Horizontal horizontalOf(const SaliencyBlock& b, int i) {
  const float mean = 0.5F * (b.matrix.xx[i] + b.matrix.yy[i]);
  const float half = 0.5F * (b.matrix.xx[i] - b.matrix.yy[i]);
  const float root = std::sqrt(half * half + b.matrix.xy[i] * b.matrix.xy[i]);
  return {std::max(mean + root, 0.0F), std::max(mean - root, 0.0F)};
}

LADAR_INLINE float greatestSaliency(const SaliencyBlock& b, int i) {
  return std::max(std::max(b.scatter[i], std::max(b.surface[i], b.linear[i])), kTiny);
}

LADAR_INLINE float horizontalPart(const float (&direction)[3][kSize], int i) {
  return std::sqrt(direction[0][i] * direction[0][i] + direction[1][i] * direction[1][i]);
}

void shapeValues(Quantity quantity, const SaliencyBlock& b, float* values) {
  dispatch([&]() LADAR_INLINE_LAMBDA {
    switch (quantity) {
      case Quantity::kCbrtScatter:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA { return block_math::cubeRoot(b.scatter[i]); });
        break;
      case Quantity::kCbrtSurface:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA { return block_math::cubeRoot(b.surface[i]); });
        break;
      case Quantity::kCbrtLinear:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA { return block_math::cubeRoot(b.linear[i]); });
        break;
      case Quantity::kScatterRatio:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          const float l2 = b.scatter[i] + b.surface[i] + b.linear[i];
          return std::sqrt(b.scatter[i] / std::max(l2, kTiny));
        });
        break;
      case Quantity::kThicknessRatio:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return std::sqrt(b.scatter[i] / std::max(b.scatter[i] + b.surface[i], kTiny));
        });
        break;
      default:
        break;
    }
  });
}

void directionValues(Quantity quantity, const SaliencyBlock& b, float* values) {
  dispatch([&]() LADAR_INLINE_LAMBDA {
    switch (quantity) {
      case Quantity::kNormalAngle:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return block_math::angleToVertical(horizontalPart(b.normal, i), b.normal[2][i]);
        });
        break;
      case Quantity::kTangentAngle:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return block_math::angleToVertical(horizontalPart(b.tangent, i), b.tangent[2][i]);
        });
        break;
      case Quantity::kLevelSurface:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return std::abs(b.normal[2][i]) * b.surface[i] / greatestSaliency(b, i);
        });
        break;
      case Quantity::kUprightSurface:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return horizontalPart(b.normal, i) * b.surface[i] / greatestSaliency(b, i);
        });
        break;
      case Quantity::kLevelLinear:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return horizontalPart(b.tangent, i) * b.linear[i] / greatestSaliency(b, i);
        });
        break;
      case Quantity::kUprightLinear:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return std::abs(b.tangent[2][i]) * b.linear[i] / greatestSaliency(b, i);
        });
        break;
      default:
        break;
    }
  });
}

void spreadValues(Quantity quantity, const SaliencyBlock& b, float* values) {
  dispatch([&]() LADAR_INLINE_LAMBDA {
    switch (quantity) {
      case Quantity::kSpreadAngle:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          // Of a horizontal plane 0, of a vertical line 90 degrees.
          return block_math::angleToVertical(std::sqrt(std::max(b.matrix.zz[i], 0.0F)),
                                             std::sqrt(horizontalOf(b, i).major));
        });
        break;
      case Quantity::kHorizontalRatio:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          const Horizontal horizontal = horizontalOf(b, i);
          return std::sqrt(horizontal.minor / std::max(horizontal.major, kTiny));
        });
        break;
      case Quantity::kHorizontalMinor:
        fill(values,
             [&](int i) LADAR_INLINE_LAMBDA { return std::sqrt(horizontalOf(b, i).minor); });
        break;
      case Quantity::kHorizontalMajor:
        fill(values,
             [&](int i) LADAR_INLINE_LAMBDA { return std::sqrt(horizontalOf(b, i).major); });
        break;
      case Quantity::kVerticalDeviation:
        fill(values,
             [&](int i) LADAR_INLINE_LAMBDA { return std::sqrt(std::max(b.matrix.zz[i], 0.0F)); });
        break;
      case Quantity::kMeanOffset:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return std::sqrt(b.mean[0][i] * b.mean[0][i] + b.mean[1][i] * b.mean[1][i] +
                           b.mean[2][i] * b.mean[2][i]);
        });
        break;
      case Quantity::kLogPoints:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return block_math::logPositive(std::max(static_cast<float>(b.points[i]), 1.0F));
        });
        break;
      default:
        break;
    }
  });
}

int parseRadius(const std::string& name, const std::string& text) {
  const bool is_number = !text.empty() && text.size() <= 4 &&
                         text.find_first_not_of("0123456789") == std::string::npos;
  const int radius = is_number ? std::stoi(text) : 0;
  if (radius < 1) {
    throw std::invalid_argument("feature '" + name + "': '" + text +
                                "' is no radius, expected a whole number of voxels from 1");
  }
  return radius;
}

SupportBox parseBox(const std::string& name, const std::string& text, bool of_columns) {
  const std::size_t cross = text.find('x');
  if (of_columns) {
    const bool is_radius = !text.empty() && cross == std::string::npos;
    const int columns = is_radius ? parseRadius(name, text) : 0;
    if (columns >= 1 && columns <= kMaxColumnRadius) return {columns, 0};
    throw std::invalid_argument("feature '" + name +
                                "': what it measures needs '@' and a radius of 1 to " +
                                std::to_string(kMaxColumnRadius) + " columns, as in '@40'");
  }
  const int radius = parseRadius(name, text.substr(0, cross));
  const SupportBox box = {
      radius, cross == std::string::npos ? radius : parseRadius(name, text.substr(cross + 1))};
  if (box.radius_xy > 64 || box.radius_z > 64 ||
      maxPointsPerVoxel({{box, 1}}) < kLeastPointsPerVoxel) {
    throw std::invalid_argument("feature '" + name +
                                "': the support volume is too large, expected a cube of radius 8 "
                                "at most, or a box of about as many voxels");
  }
  return box;
}

}  // namespace

const std::vector<QuantityInfo>& allQuantities() {
  static const std::vector<QuantityInfo> kQuantities = {
      {Quantity::kScatter, "scatter", "m^2", "l0, how much the points fill space"},
      {Quantity::kSurface, "surface", "m^2", "l1 - l0, how much they form a surface"},
      {Quantity::kLinear, "linear", "m^2", "l2 - l1, how much they form a line"},
      // Cube roots spread the small values out, where a Gaussian cannot follow the raw ones.
      {Quantity::kCbrtScatter, "cbrt_scatter", "m^(2/3)", "cube root of scatter"},
      {Quantity::kCbrtSurface, "cbrt_surface", "m^(2/3)", "cube root of surface"},
      {Quantity::kCbrtLinear, "cbrt_linear", "m^(2/3)", "cube root of linear"},
      {Quantity::kNormalAngle, "normal_angle", "rad", "angle of the normal to the vertical"},
      {Quantity::kTangentAngle, "tangent_angle", "rad", "angle of the tangent to the vertical"},
      {Quantity::kSpreadAngle, "spread_angle", "rad",
       "arc tangent of sz / sh1: 0 for what lies level, pi/2 for what stands upright"},
      {Quantity::kHorizontalRatio, "horizontal_ratio", "1",
       "sh0 / sh1: 0 for walls and lines, 1 for what is round seen from above"},
      {Quantity::kScatterRatio, "scatter_ratio", "1", "sqrt(l0 / l2)"},
      {Quantity::kThicknessRatio, "thickness_ratio", "1", "sqrt(l0 / l1)"},
      {Quantity::kLevelSurface, "level_surface", "1",
       "|normal z| surface, over the greatest saliency"},
      {Quantity::kUprightSurface, "upright_surface", "1",
       "horizontal part of the normal times surface, over the greatest saliency"},
      {Quantity::kLevelLinear, "level_linear", "1",
       "horizontal part of the tangent times linear, over the greatest saliency"},
      {Quantity::kUprightLinear, "upright_linear", "1",
       "|tangent z| linear, over the greatest saliency"},
      {Quantity::kHorizontalMinor, "horizontal_minor", "m", "sh0"},
      {Quantity::kHorizontalMajor, "horizontal_major", "m", "sh1"},
      {Quantity::kVerticalDeviation, "vertical_deviation", "m", "sz"},
      {Quantity::kMeanOffset, "mean_offset", "m", "distance of the points' mean to the voxel"},
      {Quantity::kLogPoints, "log_points", "1", "logarithm of the number of points: density"},
      {Quantity::kLogHeight, "log_height", "1",
       "log((height + 0.1 m) / 1 m) over the lowest voxel of the square of columns"},
      {Quantity::kSqrtHeight, "sqrt_height", "m^(1/2)", "square root of the same height + 0.01 m"},
      {Quantity::kLogGroundHeight, "log_ground_height", "1",
       "log((height + 0.1 m) / 1 m) over the ground: an opening by the square of columns"},
      {Quantity::kLogFill, "log_fill", "1",
       "logarithm of the occupied voxels per occupied column of the square"},
  };
  return kQuantities;
}

const QuantityInfo& quantityInfo(Quantity quantity) {
  const auto& all = allQuantities();
  return *std::find_if(all.begin(), all.end(),
                       [&](const QuantityInfo& info) { return info.quantity == quantity; });
}

bool isOfColumns(Quantity quantity) {
  return quantity == Quantity::kLogHeight || quantity == Quantity::kSqrtHeight ||
         quantity == Quantity::kLogGroundHeight || quantity == Quantity::kLogFill;
}

ColumnQuantity columnQuantity(Quantity quantity) {
  if (quantity == Quantity::kLogFill) return ColumnQuantity::kFill;
  return quantity == Quantity::kLogGroundHeight ? ColumnQuantity::kGround : ColumnQuantity::kLowest;
}

Feature parseFeature(const std::string& name) {
  const std::size_t at = name.find('@');
  const std::string quantity = name.substr(0, at);
  for (const QuantityInfo& info : allQuantities()) {
    if (quantity != info.name) continue;
    const bool of_columns = isOfColumns(info.quantity);
    if (at == std::string::npos && !of_columns) return {info.quantity, {0, 0}};
    const std::string box = at == std::string::npos ? "" : name.substr(at + 1);
    return {info.quantity, parseBox(name, box, of_columns)};
  }
  std::string known;
  for (const QuantityInfo& info : allQuantities()) known += std::string(" ") + info.name;
  throw std::invalid_argument("unknown feature '" + name + "', known are:" + known);
}

std::string featureName(const Feature& feature) {
  std::string name = quantityInfo(feature.quantity).name;
  if (feature.isOfConfiguredSupport()) return name;
  name += "@" + std::to_string(feature.box.radius_xy);
  const bool is_cube = feature.box.radius_z == feature.box.radius_xy;
  if (isOfColumns(feature.quantity) || is_cube) return name;
  return name + "x" + std::to_string(feature.box.radius_z);
}

const std::vector<FeatureSet>& featureSets() {
  static const std::vector<FeatureSet> kSets = {
      {"saliency", "the three saliencies alone", {"cbrt_scatter", "cbrt_surface", "cbrt_linear"}},
      {"directions",
       "saliencies, and the angles of normal and tangent",
       {"cbrt_scatter", "cbrt_surface", "cbrt_linear", "normal_angle", "tangent_angle"}},
      {"standard",
       "shape, fill of the columns, and height over the ground near and far",
       {"spread_angle", "horizontal_ratio", "cbrt_surface", "scatter_ratio", "thickness_ratio",
        "normal_angle", "upright_surface", "log_fill@1", "log_fill@3", "log_ground_height@5",
        "log_height@10", "log_height@40"}},
      {"several_supports",
       "standard, and shape at two more sizes: thinner things, at half as much time again",
       {"standard", "spread_angle@4", "scatter_ratio@4", "spread_angle@8", "horizontal_ratio@8"}},
  };
  return kSets;
}

namespace {

/// The features that a name stands for; sets may have sets in them.
std::vector<std::string> membersOf(const std::string& name) {
  for (const FeatureSet& set : featureSets()) {
    if (name != set.name) continue;
    std::vector<std::string> members;
    for (const std::string& part : set.features) {
      for (std::string& member : membersOf(part)) members.push_back(std::move(member));
    }
    return members;
  }
  return {name};
}

}  // namespace

std::vector<Feature> parseFeatures(const std::vector<std::string>& names) {
  std::vector<Feature> features;
  for (const std::string& name : names) {
    for (const std::string& member : membersOf(name)) {
      features.push_back(parseFeature(member));
      if (std::count(features.begin(), features.end(), features.back()) > 1) {
        throw std::invalid_argument("feature '" + member + "' is there twice");
      }
    }
  }
  if (features.empty()) throw std::invalid_argument("no feature is named");
  return features;
}

void featureValues(Quantity quantity, const SaliencyBlock& block, float* values) {
  switch (quantity) {
    case Quantity::kScatter:
      std::copy_n(block.scatter, kSize, values);
      break;
    case Quantity::kSurface:
      std::copy_n(block.surface, kSize, values);
      break;
    case Quantity::kLinear:
      std::copy_n(block.linear, kSize, values);
      break;
    case Quantity::kCbrtScatter:
    case Quantity::kCbrtSurface:
    case Quantity::kCbrtLinear:
    case Quantity::kScatterRatio:
    case Quantity::kThicknessRatio:
      shapeValues(quantity, block, values);
      break;
    case Quantity::kNormalAngle:
    case Quantity::kTangentAngle:
    case Quantity::kLevelSurface:
    case Quantity::kUprightSurface:
    case Quantity::kLevelLinear:
    case Quantity::kUprightLinear:
      directionValues(quantity, block, values);
      break;
    default:
      spreadValues(quantity, block, values);
      break;
  }
}

void columnFeatureValues(Quantity quantity, const int32_t* numbers, double voxel_size_m,
                         float* values) {
  const auto voxel = static_cast<float>(voxel_size_m);
  dispatch([&]() LADAR_INLINE_LAMBDA {
    const auto height = [&](int i) LADAR_INLINE_LAMBDA {
      return static_cast<float>(std::max(numbers[i], 0)) * voxel;
    };
    switch (quantity) {
      case Quantity::kSqrtHeight:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA { return std::sqrt(height(i) + 0.01F); });
        break;
      case Quantity::kLogFill:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          const float fill = static_cast<float>(numbers[i]) * (1.0F / kFillUnit);
          return block_math::logPositive(std::max(fill, 1.0F));
        });
        break;
      default:
        fill(values, [&](int i) LADAR_INLINE_LAMBDA {
          return block_math::logPositive(height(i) + kHeightOffset_m);
        });
        break;
    }
  });
}

}  // namespace ladar_perception
