// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "ladar_perception/resample/voxel_pyramid.h"

namespace ladar_perception {

/// Columns of a quarter of a voxel's edge through the voxel and the 26 around it: a row along the
/// second axis across the columns, a bit of it along the first.
constexpr int kMaskEdge = 12;
using ColumnMask = std::array<uint32_t, kMaskEdge>;

/// The columns that hold points; `u` and `v` are the axes across them. `level` is at least 2.
ColumnMask columnsWithPoints(const VoxelPyramid& pyramid, int level, uint32_t voxel, int u, int v);

/// Fills what no free square of kOpenColumns columns' edge reaches. Such a square, nearly two
/// voxels wide, is a place that was not seen, like the ground around a sensor, and not a gap
/// between scan lines. What is beyond the mask counts as free.
constexpr int kOpenColumns = 7;
ColumnMask closeGaps(const ColumnMask& mask);

}  // namespace ladar_perception
