// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ladar_perception/resample/voxel_pyramid.h"

namespace ladar_perception {

/// An elliptic piece of surface, fitted to the points of a voxel and the 26 around it. Lengths in
/// cells.
struct SurfaceFit {
  Eigen::Vector3f center = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< unit, towards the sensor
  Eigen::Vector3f major = Eigen::Vector3f::Zero();   ///< unit, along the longer semi-axis
  float semi_major = 0;
  float semi_minor = 0;
  /// Weight where pieces overlap: points it was fitted to, as far as more of them tell more, over
  /// the square of its voxel's edge in those of the base level.
  float trust = 1;
  float weight = 1;   ///< mean of the points' weights
  uint8_t level = 0;  ///< fitted to voxels of 2^level cells
  /// Ends of the piece, of which the two across the main axis of the normal count: where the next
  /// voxel has a piece of its own, pieces overlap a little only.
  Eigen::Vector3f low = Eigen::Vector3f::Constant(-kUnbounded);
  Eigen::Vector3f high = Eigen::Vector3f::Constant(kUnbounded);

  static constexpr float kUnbounded = 1e9F;

  bool operator==(const SurfaceFit& other) const;
};

/// Eigenvalues and the plane of summed points.
struct PlaneFit {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  Eigen::Vector3f major = Eigen::Vector3f::Zero();
  float l0 = 0, l1 = 0, l2 = 0;
};
/// Of at least one point.
PlaneFit fitPlane(const PointSums& sums);

/// Points a plane needs: with fewer its normal is a guess.
constexpr float kPlanePoints = 8;
/// Levels that gaps between points are bridged over: voxels sixteen times as wide.
constexpr int kBridgeLevels = 4;

/// What became of a voxel at one level.
enum class VoxelFate : uint8_t { kNotWanted, kSurface, kBridge, kLine, kOpen };

/// What fitSurface has found at each level from its own up, by voxel.
struct FitMemory {
  struct Level {
    std::vector<uint8_t> asked;   ///< what was wanted, and
    std::vector<uint8_t> wanted;  ///< what of it was not left out
    std::vector<SurfaceFit> fits;
    std::vector<VoxelFate> fates;
  };
  std::vector<Level> levels;
};

/// Pieces of surface for voxels of `level`, those with `wanted[i]` set (all if it is empty): each
/// by the first level, up to kBridgeLevels more, at which voxel and neighbours hold kPlanePoints.
/// Coarser levels must be planar, so that foliage is not bridged. A line (a scan ring, a wire)
/// stays one unless a coarser level finds the plane it lies in: a strip of ground if it lies, else
/// one that faces the sensor. A voxel left alone gets a piece of its own size, with the normal of
/// the line it is part of or facing the sensor; these come last, the others in the order of levels
/// and keys. `memory`, if given, is that of an earlier call with the same level and sensor, and
/// becomes that of this one: bricks are not fitted again if they and those around them are
/// `unchanged` (unchangedBricks, by level of the pyramid; none if it is empty).
std::vector<SurfaceFit> fitSurface(const VoxelPyramid& pyramid, int level,
                                   const std::vector<uint8_t>& wanted,
                                   const Eigen::Vector3f& sensor, ThreadPool* pool,
                                   const std::vector<std::vector<uint32_t>>& unchanged = {},
                                   FitMemory* memory = nullptr);

/// Sums over every wanted voxel of a level and its 26 neighbours, about its own brick's centre.
/// With `thin_out` a voxel of odd coordinates (by their sum) that lies side by side with four
/// wanted ones is left out, and no longer wanted: their pieces cover its place. Bricks that are
/// `known` (none if it is empty) get no sums, and what is wanted of them stays.
std::vector<PointSums> sumNeighborhoods(const VoxelLevel& level, int level_number, bool thin_out,
                                        std::vector<uint8_t>* wanted, ThreadPool* pool,
                                        const std::vector<uint32_t>& known = {});

}  // namespace ladar_perception
