// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/terrain/terrain_config.h"

#include <cmath>

namespace ladar_perception {
namespace {

constexpr int kMaxColumnsPerAxis = 4096;
constexpr int kMaxHeights = 1024;

/// Voxels that cover `size_m`; a size that is a multiple of the voxel, give or take rounding, is
/// covered by exactly that many.
double voxelsAcross(double size_m, double voxel_size_m) {
  return std::ceil(size_m / voxel_size_m - 1e-6);
}

}  // namespace

void TerrainConfig::addTo(ParamTable* table) {
  table->add("voxel_size_m", &voxel_size_m, kMinVoxelSize_m, 2.0, "m",
             "edge of a voxel; the model must have been learned at the same size");
  table->add("map_size_x_m", &map_size_x_m, 1.0, 400.0, "m",
             "extent of the map around the vehicle");
  table->add("map_size_y_m", &map_size_y_m, 1.0, 400.0, "m",
             "extent of the map around the vehicle");
  table->add("map_size_z_m", &map_size_z_m, 0.5, 100.0, "m", "height of the map");
  table->add("map_center_height_m", &map_center_height_m, -50.0, 50.0, "m",
             "height of the map's middle over the vehicle frame's origin");
  table->add("support_radius_voxels", &support_radius_voxels, 1, 6, "voxels",
             "r: features come from the (2 r + 1)^3 voxels around a voxel");
  table->add("support_kernel", &support_kernel,
             "weights in the support volume: box, all alike, or gaussian, falling to 1/4 at r");
  table->add("min_support_points", &min_support_points, 3, 1000, "points",
             "voxels with fewer points in their support volume are unknown");
  table->add("smooth_labels", &smooth_labels,
             "label voxels by the posteriors of their neighbours, too, as the model says");
  table->add("min_range_m", &min_range_m, 0.0, 100.0, "m",
             "nearer points are dropped: the vehicle itself, and invalid returns at 0");
  table->add("max_range_m", &max_range_m, 1.0, 1000.0, "m", "farther points are dropped");
  table->add("forget_after_s", &forget_after_s, 0.0, 86400.0, "s",
             "points older than this leave the map; 0 keeps them until it scrolls away");
  table->add("forget_after_scans", &forget_after_scans, 0, 1000000, "scans",
             "the same, counted in scans; at most one of the two is set");
  table->add("threads", &threads, 1, 64, "threads", "results are the same bits for any number");
}

std::vector<std::string> TerrainConfig::validate() const {
  std::vector<std::string> violations;
  const auto checkAxis = [&](const char* name, double size_m, int most) {
    const double voxels = voxelsAcross(size_m, voxel_size_m);
    if (voxels > most) {
      violations.push_back(std::string(name) + ": " + std::to_string(size_m) + " m are " +
                           std::to_string(static_cast<long>(voxels)) +
                           " voxels of voxel_size_m, expected at most " + std::to_string(most));
    }
  };
  checkAxis("map_size_x_m", map_size_x_m, kMaxColumnsPerAxis);
  checkAxis("map_size_y_m", map_size_y_m, kMaxColumnsPerAxis);
  checkAxis("map_size_z_m", map_size_z_m, kMaxHeights);
  if (violations.empty()) {
    const MapShape shape = mapShape();
    std::int64_t heights = 1;
    while (heights < shape.nz) heights *= 2;
    if (std::int64_t{shape.nx} * shape.ny * heights >= std::int64_t{kNoCell}) {
      violations.emplace_back(
          "map_size_*_m: more than 2^32 voxels (heights count as the next power of two)");
    }
  }
  if (min_range_m >= max_range_m) {
    violations.emplace_back("min_range_m: must be less than max_range_m");
  }
  if (support_kernel != "box" && support_kernel != "gaussian") {
    violations.push_back("support_kernel: '" + support_kernel + "', expected box or gaussian");
  }
  // Stamps count from 1970: over a much shorter lifetime their number is no 64-bit integer.
  if (forget_after_s > 0.0 && forget_after_s < 1e-3) {
    violations.emplace_back("forget_after_s: must be 0 or at least 0.001");
  }
  if (forget_after_s > 0.0 && forget_after_scans > 0) {
    violations.emplace_back("forget_after_s, forget_after_scans: only one of them may be set");
  }
  return violations;
}

MapShape TerrainConfig::mapShape() const {
  return {static_cast<int>(voxelsAcross(map_size_x_m, voxel_size_m)),
          static_cast<int>(voxelsAcross(map_size_y_m, voxel_size_m)),
          static_cast<int>(voxelsAcross(map_size_z_m, voxel_size_m))};
}

BoxStack TerrainConfig::supportStack() const {
  return support_kernel == "gaussian" ? gaussianBoxStack(support_radius_voxels)
                                      : BoxStack{{cube(support_radius_voxels), 1}};
}

}  // namespace ladar_perception
