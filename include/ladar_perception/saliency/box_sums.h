// SPDX-License-Identifier: BSD-3-Clause
// Sums of moments over the support volume of every occupied voxel.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Order of the occupied voxels in every per-voxel table: columns by ascending local y, then x,
/// then ascending z within a column.
struct VoxelOrder {
  std::vector<uint32_t> first_row;  ///< by ring column: row of the column's lowest voxel
  std::vector<uint32_t> row_begin;  ///< by local y, ny + 1 entries: first row of the slab
  std::size_t rows = 0;

  void update(const VoxelMap& map);
  /// Row of an inserted point's voxel.
  std::size_t rowOf(const VoxelMap& map, CellId cell) const {
    return first_row[map.columnOf(cell)] + map.rankOf(cell);
  }
  /// World indices of the voxels, by row.
  void listVoxels(const VoxelMap& map, std::vector<VoxelIndex>* voxels) const;
};

/// Sparse sliding sums: along y a plane of per-(x, z) column sums gains one slab of the map and
/// loses one, along x a line of per-z sums gains and loses one column of that plane, along z a sum
/// gains and loses one entry of that line; empty voxels cost nothing. The work per voxel does not
/// grow with the support volume (but for the first voxel of a run along z).
///
/// Sums are exact integers, so this equals the sum over the k^3 voxels bit by bit, k = 2 r + 1.
/// Every strategy has this shape: (map, order, pool, one sum per row).
class SlidingBoxSums {
 public:
  /// `support_radius_voxels` = r >= 0. Keeps buffers between calls.
  explicit SlidingBoxSums(int support_radius_voxels) : radius_(support_radius_voxels) {}

  /// Fills `sums`, one per row of `order`. The result is the same for any size of `pool`.
  void compute(const VoxelMap& map, const VoxelOrder& order, ThreadPool* pool,
               std::vector<Moments>* sums);
  std::size_t memoryBytes() const;

 private:
  /// What one thread slides through its slabs of y.
  struct Window {
    std::vector<Moments> plane;         // nx * stride, sums over y
    std::vector<uint64_t> plane_masks;  // nx * words, heights at which the plane may be non-zero
    std::vector<Moments> line;          // nz + 2 r, sums over y and x, padded with zeros
  };

  void computeSlabs(const VoxelMap& map, const VoxelOrder& order, int y_begin, int y_end,
                    Window* window, Moments* sums) const;
  void addSlab(const VoxelMap& map, int y, bool subtract, Window* window) const;
  void updatePlaneMasks(const VoxelMap& map, int y, Window* window) const;
  void slideAlongX(const VoxelMap& map, int y, Window* window, Moments** out) const;
  void addColumn(const VoxelMap& map, int x, bool subtract, Window* window) const;

  int radius_;
  std::vector<Window> windows_;  // one per thread
};

}  // namespace ladar_perception
