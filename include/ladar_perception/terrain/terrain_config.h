// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/params/param_table.h"
#include "ladar_perception/saliency/box_stack.h"

namespace ladar_perception {

/// Configuration of a TerrainPipeline.
struct TerrainConfig {
  double voxel_size_m = 0.1;
  double map_size_x_m = 20.0;
  double map_size_y_m = 20.0;
  double map_size_z_m = 3.0;
  double map_center_height_m = 0.5;
  int support_radius_voxels = 6;
  std::string support_kernel = "box";
  int min_support_points = 3;
  bool smooth_labels = true;
  double min_range_m = 0.5;
  double max_range_m = 100.0;
  double forget_after_s = 0.0;
  int forget_after_scans = 0;
  int threads = 1;

  /// Names, ranges, units and meanings of the fields above.
  void addTo(ParamTable* table);
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;
  MapShape mapShape() const;
  /// The support volume: one box, or the stack that stands for the kernel.
  BoxStack supportStack() const;
};

}  // namespace ladar_perception
