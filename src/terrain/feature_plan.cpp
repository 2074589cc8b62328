// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/terrain/feature_plan.h"

#include <algorithm>

namespace ladar_perception {

FeaturePlan::FeaturePlan(const std::vector<Feature>& features) {
  for (const Feature& feature : features) {
    if (feature.isOfConfiguredSupport()) {
      source.push_back(0);
    } else if (isOfColumns(feature.quantity)) {
      const ColumnLayer wanted(columnQuantity(feature.quantity), feature.box.radius_xy);
      auto it = std::find_if(layers.begin(), layers.end(), [&](const ColumnLayer& layer) {
        return layer.quantity() == wanted.quantity() && layer.radius() == wanted.radius();
      });
      if (it == layers.end()) it = layers.insert(it, wanted);
      source.push_back(static_cast<int>(it - layers.begin()));
    } else {
      auto it = std::find(boxes.begin(), boxes.end(), feature.box);
      if (it == boxes.end()) it = boxes.insert(it, feature.box);
      source.push_back(1 + static_cast<int>(it - boxes.begin()));
    }
  }
}

int FeaturePlan::reach(const BoxStack& configured) const {
  int reach = configured[0].box.radius_xy;
  for (const SupportBox& box : boxes) reach = std::max(reach, box.radius_xy);
  return reach;
}

uint32_t FeaturePlan::maxPointsPerVoxel(const BoxStack& configured) const {
  uint32_t most = ladar_perception::maxPointsPerVoxel(configured);
  for (const SupportBox& box : boxes) {
    most = std::min(most, ladar_perception::maxPointsPerVoxel({{box, 1}}));
  }
  return most;
}

}  // namespace ladar_perception
