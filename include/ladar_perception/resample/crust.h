// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/resample/cell_blender.h"
#include "ladar_perception/resample/grid_points.h"
#include "ladar_perception/resample/surface_fit.h"
#include "ladar_perception/resample/voxel_pyramid.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// The crust: grid cells that stand for the surface, and which of them are neighbours on it. In the
/// order of the Morton keys of the cells' places. Lengths in cells of the finest size.
struct Crust {
  GridFrame frame;
  std::vector<uint64_t> keys;              ///< ascending; of the cell's first cell of level 0
  std::vector<Eigen::Vector3f> positions;  ///< on the surface, not the middles of the cells
  std::vector<Eigen::Vector3f> normals;    ///< unit, towards the sensor
  std::vector<float> slowness;             ///< 1 / F of the front, F = weight^(-1/2)
  std::vector<uint8_t> levels;             ///< the cell's edge is 2^level
  std::vector<uint32_t> first_neighbor;    ///< of cell i, in `neighbors`; one entry more than cells
  std::vector<uint32_t> neighbors;

  std::size_t size() const { return positions.size(); }
  float edge(std::size_t cell) const { return static_cast<float>(1 << levels[cell]); }
  float weight(std::size_t cell) const { return slowness[cell] * slowness[cell]; }
  /// m^2, as far as a cell's share of the surface can be told from its normal.
  double area_m2() const;
};

/// What a surfel crust was made of, for the next one of more points in the same frame.
struct CrustMemory {
  std::vector<FitMemory> fits;      ///< by the level of cells
  std::vector<BlendMemory> blends;  ///< the same
};

/// A crust one cell deep: pieces of surface are blended into one plane per cell, and of the cells
/// in a column along the plane's main axis the one that the plane goes through is kept.
/// `cell_levels` gives each voxel of level 0 the size of cells wanted there (2^level; all 0 if
/// empty). `memory`, if given, is empty or that of an earlier crust with the same frame and sensor,
/// and becomes that of this one, where only what depends on a change is worked out: see fitSurface
/// for `unchanged`.
Crust makeSurfelCrust(const VoxelPyramid& pyramid, const GridFrame& frame,
                      const std::vector<uint8_t>& cell_levels, const Eigen::Vector3f& sensor,
                      ThreadPool* pool, const std::vector<std::vector<uint32_t>>& unchanged = {},
                      CrustMemory* memory = nullptr);

/// The paper's crust: all cells inside the union of ellipsoids, one fitted to every point and its
/// `neighbors` nearest ones. A few cells deep, and slow. Ellipsoids end at kLargestEllipsoidCells,
/// so that those of sparse places do not bridge what is apart. `weights` by source; empty means 1.
constexpr float kLargestEllipsoidCells = 8.0F;
Crust makeEllipsoidCrust(const GridPoints& points, const std::vector<float>& weights, int neighbors,
                         const Eigen::Vector3f& sensor, ThreadPool* pool);

}  // namespace ladar_perception
