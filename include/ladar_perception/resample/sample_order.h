// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ladar_perception {

/// A place and the slowness of fronts there. The distance of two is straight, times the mean
/// slowness.
struct WeightedPlace {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  float slowness = 1.0F;
};

struct PlaceOrder {
  std::vector<uint32_t> order;  ///< of the places
  /// For each place of the order, the greatest distance of a place or witness to the places up to
  /// with it.
  std::vector<float> covering;
  std::vector<float> covering_before;  ///< the same for each place of `before`
};

/// Orders places farthest first. `witnesses` are places that count as covered or not but are not
/// ordered; places of `before` come first, as they are. Places and witnesses should be in an order
/// that keeps near ones together, as Morton keys do: runs of them are passed over where a new place
/// cannot matter (bucketed farthest point sampling).
PlaceOrder orderFarthestFirst(const std::vector<WeightedPlace>& places,
                              const std::vector<WeightedPlace>& witnesses,
                              const std::vector<WeightedPlace>& before = {});

}  // namespace ladar_perception
