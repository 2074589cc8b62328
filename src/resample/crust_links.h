// SPDX-License-Identifier: BSD-3-Clause
// From cells of several sizes to a crust: order and neighbourhood.
#pragma once

#include <vector>

#include "ladar_perception/resample/cell_blender.h"
#include "ladar_perception/resample/crust.h"

namespace ladar_perception {

/// Drops cells that lie inside a larger cell. `surfels` by level, each in the order of keys.
void dropCovered(std::vector<std::vector<Surfel>>* surfels);

/// Puts the cells of all levels into one order and links those that touch. A test of planes and
/// normals would keep sheets apart that are nearer than two cells, but it would also cut surfaces
/// where noise bends them, and what is thinner than the spacing of samples needs none of its own.
Crust linkCells(const GridFrame& frame, const std::vector<std::vector<Surfel>>& surfels,
                ThreadPool* pool);

}  // namespace ladar_perception
