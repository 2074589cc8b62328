// SPDX-License-Identifier: BSD-3-Clause
// From cells of several sizes to a crust: order and neighbourhood.
#pragma once

#include <vector>

#include "ladar_perception/resample/cell_blender.h"
#include "ladar_perception/resample/crust.h"

namespace ladar_perception {

/// Drops cells that lie inside a larger cell. `surfels` by level, each in the order of keys.
void dropCovered(std::vector<std::vector<Surfel>>* surfels);

/// Puts the cells of all levels into one order and links those that touch and are on one surface.
Crust linkCells(const GridFrame& frame, const std::vector<std::vector<Surfel>>& surfels,
                ThreadPool* pool);

}  // namespace ladar_perception
