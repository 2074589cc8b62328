// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ladar_perception/resample/radix_sort.h"
#include "ladar_perception/resample/surface_fit.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// A cell the surface goes through.
struct Surfel {
  uint64_t key = 0;                                    ///< Morton key among cells of its level
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< on the surface, cells from the origin
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float slowness = 1.0F;
};

/// Pieces of surface, and the cells they were blended into, tile by tile.
struct BlendMemory {
  struct Tile {
    uint64_t key = 0;
    std::size_t first_entry = 0;
    std::size_t first_surfel = 0;
  };
  std::vector<SurfaceFit> pieces;
  std::vector<KeyedIndex> entries;  ///< key of a tile and index of a piece that reaches it
  std::vector<Tile> tiles;          ///< in the order of keys; the last is an end
  std::vector<Surfel> surfels;
};

/// Blends overlapping pieces of surface into cells of 2^level. `memory` is empty or that of an
/// earlier call for the same level, and becomes that of this one: tiles that the same pieces reach
/// as before are not blended again. Its surfels are the cells that the blended planes go through,
/// one per column along the plane's main axis, in the order of their keys.
void blendSurface(std::vector<SurfaceFit> pieces, int level, ThreadPool* pool, BlendMemory* memory);

}  // namespace ladar_perception
