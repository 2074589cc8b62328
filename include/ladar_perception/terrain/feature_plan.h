// SPDX-License-Identifier: BSD-3-Clause
// What must be summed and looked up so that a model's features can be computed, and nothing else.
#pragma once

#include <vector>

#include "ladar_perception/map/column_layer.h"
#include "ladar_perception/saliency/box_stack.h"
#include "ladar_perception/saliency/features.h"

namespace ladar_perception {

struct FeaturePlan {
  explicit FeaturePlan(const std::vector<Feature>& features);

  /// Support volumes beside the configured one, each once.
  std::vector<SupportBox> boxes;
  /// Layers of columns, each once.
  std::vector<ColumnLayer> layers;
  /// By feature: of a support volume 0 for the configured one and 1 + i for boxes[i]; of columns i
  /// for layers[i].
  std::vector<int> source;

  /// How far a changed column changes features of others by its points, in columns.
  int reach(const BoxStack& configured) const;
  /// Points a voxel may hold so that all sums stay exact.
  uint32_t maxPointsPerVoxel(const BoxStack& configured) const;
};

}  // namespace ladar_perception
