// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

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

/// Blends overlapping pieces of surface into cells of 2^level and returns the cells that the
/// blended planes go through, one per column along the plane's main axis, in the order of their
/// keys.
std::vector<Surfel> blendSurface(const std::vector<SurfaceFit>& pieces, int level,
                                 ThreadPool* pool);

}  // namespace ladar_perception
