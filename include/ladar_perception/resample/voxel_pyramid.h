// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "ladar_perception/resample/grid_points.h"
#include "ladar_perception/resample/sparse_grid.h"
#include "ladar_perception/util/dispatch.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Sums over the points of a voxel, about the centre of the voxel's brick, in cells.
struct alignas(16) PointSums {
  float count = 0, x = 0, y = 0, z = 0;
  float xx = 0, xy = 0, xz = 0, yy = 0;
  float yz = 0, zz = 0, weight = 0, unused = 0;

  LADAR_INLINE void add(const Eigen::Vector3f& p, float point_weight);
  LADAR_INLINE void add(const PointSums& other);
  bool operator==(const PointSums& other) const;
  /// The same sums about a centre that lies at -`offset` from the one they are about.
  LADAR_INLINE PointSums movedBy(const Eigen::Vector3f& offset) const;
};

inline void PointSums::add(const Eigen::Vector3f& p, float point_weight) {
  count += 1.0F;
  x += p.x();
  y += p.y();
  z += p.z();
  xx += p.x() * p.x();
  xy += p.x() * p.y();
  xz += p.x() * p.z();
  yy += p.y() * p.y();
  yz += p.y() * p.z();
  zz += p.z() * p.z();
  weight += point_weight;
}

inline void PointSums::add(const PointSums& other) {
  using Part = Eigen::Map<Eigen::Array4f, Eigen::Aligned16>;
  using OtherPart = Eigen::Map<const Eigen::Array4f, Eigen::Aligned16>;
  Part(&count) += OtherPart(&other.count);
  Part(&xx) += OtherPart(&other.xx);
  Part(&yz) += OtherPart(&other.yz);
}

inline bool PointSums::operator==(const PointSums& o) const {
  return count == o.count && x == o.x && y == o.y && z == o.z && xx == o.xx && xy == o.xy &&
         xz == o.xz && yy == o.yy && yz == o.yz && zz == o.zz && weight == o.weight;
}

inline PointSums PointSums::movedBy(const Eigen::Vector3f& o) const {
  PointSums moved = *this;
  moved.x += count * o.x();
  moved.y += count * o.y();
  moved.z += count * o.z();
  moved.xx += o.x() * (x + moved.x);
  moved.xy += o.x() * y + o.y() * moved.x;
  moved.xz += o.x() * z + o.z() * moved.x;
  moved.yy += o.y() * (y + moved.y);
  moved.yz += o.y() * z + o.z() * moved.y;
  moved.zz += o.z() * (z + moved.z);
  return moved;
}

/// One size of voxel: edge 2^level cells.
struct VoxelLevel {
  SparseGrid grid;
  std::vector<PointSums> sums;
  std::vector<uint32_t> first_child;  ///< in the level below (level 0: among the points)
  std::vector<uint32_t> first_point;  ///< one entry more than voxels
};

/// Voxels that hold points, of every size from one cell up.
class VoxelPyramid {
 public:
  /// `weights` by source; empty means 1.
  VoxelPyramid(const GridPoints& points, const std::vector<float>& weights, int levels);

  int levels() const { return static_cast<int>(levels_.size()); }
  const VoxelLevel& level(int level) const { return levels_[static_cast<std::size_t>(level)]; }

 private:
  std::vector<VoxelLevel> levels_;
};

/// For every brick of `now` the number its first voxel has in `before`, if that brick has the same
/// voxels with the same sums there, else kNoIndex. Nor has one next to a brick that is gone.
std::vector<uint32_t> unchangedBricks(const VoxelLevel& now, const VoxelLevel& before);

/// Centre of a brick of voxels of 2^level cells, in cells from the origin.
inline Eigen::Vector3f brickCenter(uint64_t brick_key, int level) {
  return cubeCenter(brick_key, level + 2);
}

}  // namespace ladar_perception
