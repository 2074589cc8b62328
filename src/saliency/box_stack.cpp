// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/box_stack.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ladar_perception {

BoxStack makeBoxStack(const std::vector<double>& weights, int levels) {
  assert(!weights.empty() && levels >= 1);
  assert(std::is_sorted(weights.rbegin(), weights.rend()) && weights.back() > 0.0);
  BoxStack stack;
  uint32_t below = 0;  // weight of the boxes so far
  for (int radius = static_cast<int>(weights.size()) - 1; radius >= 0; --radius) {
    const double level = std::round(weights[radius] / weights[0] * levels);
    const auto weight = std::max<uint32_t>(1, static_cast<uint32_t>(level));
    if (weight > below) stack.push_back({cube(radius), weight - below});
    below = weight;
  }
  return stack;
}

BoxStack gaussianBoxStack(int radius) {
  constexpr int kLevels = 4;
  const double sigma = 0.5 * radius;
  std::vector<double> weights;
  for (int d = 0; d <= radius; ++d) weights.push_back(std::exp(-0.5 * d * d / (sigma * sigma)));
  return makeBoxStack(weights, kLevels);
}

uint32_t weightAt(const BoxStack& stack, int distance) {
  uint32_t weight = 0;
  for (const WeightedBox& weighted : stack) {
    if (distance <= weighted.box.radius_xy && distance <= weighted.box.radius_z) {
      weight += weighted.weight;
    }
  }
  return weight;
}

uint32_t maxPointsPerVoxel(const BoxStack& stack) {
  // The sum of all |coordinates| stays below 2^31, each of them at most 128 k of the widest box.
  int64_t coordinate = 0;
  int64_t weighted_voxels = 0;
  for (const WeightedBox& weighted : stack) {
    const int64_t k_xy = 2 * weighted.box.radius_xy + 1;
    const int64_t k_z = 2 * weighted.box.radius_z + 1;
    coordinate = std::max(coordinate, kStepsPerVoxel / 2 * std::max(k_xy, k_z));
    weighted_voxels += weighted.weight * k_xy * k_xy * k_z;
  }
  return static_cast<uint32_t>((int64_t{1} << 31) / (coordinate * weighted_voxels));
}

}  // namespace ladar_perception
