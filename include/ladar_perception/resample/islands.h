// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "ladar_perception/resample/grid_points.h"

namespace ladar_perception {

/// Islands of a cloud: cubes of 2^level cells that hold points and touch.
struct Islands {
  std::size_t kept = 0;
  std::size_t dropped = 0;
};

/// Drops the points of islands with fewer than `least_points`, unless all are so small, and of all
/// but the `most` largest (0: no limit): isolated points, as mixed pixels are, would get as many
/// samples as the surface of a wall between them.
Islands dropSmallIslands(int level, std::size_t least_points, std::size_t most, GridPoints* points);

/// Drops the points with no other within `radius` cells, which is at most a cube of 2^level cells
/// and at least the diagonal of half of one, and returns how many; none if they are more than
/// `most`: so many are not mixed pixels, but the way that cloud is.
std::size_t dropLonePoints(int level, float radius, std::size_t most, GridPoints* points);

}  // namespace ladar_perception
