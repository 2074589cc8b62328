// SPDX-License-Identifier: BSD-3-Clause
// Where the true surface is: for measuring the errors of what is computed from its scans.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ladar_perception/resample/sampling_quality.h"
#include "ladar_perception/sim/primitive.h"

namespace ladar_perception::sim {

/// A point of the surface of something.
struct SurfacePoint {
  double distance_m = kMiss;  ///< from where it was looked for
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  /// Unit length. Of discs and triangles, which have two sides, towards where it was looked for.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  uint32_t face = 0;  ///< PlanarFace::id if it lies on the side of a box, else 0
  Material material = Material::kSoil;

  bool valid() const { return distance_m < kMiss; }
};

/// One side of a placed box; its normal points outward.
struct PlanarFace {
  uint32_t id = 0;  ///< from 1, the same for the same scene and seed
  /// Sides in one plane that face the same way, of one model and material, have the same number:
  /// the pieces a wall is made of between its windows.
  uint32_t plane = 0;
  Rectangle rectangle;  ///< in the world
  Material material = Material::kSoil;
};

/// The point of the shape's surface that is nearest to `p`. Solids are hollow: a point inside is
/// nearest to a place of the shell.
Eigen::Vector3d nearestOnShape(const Primitive& primitive, const Eigen::Vector3d& p);

/// Side 0 to 5 of a box that a point of its surface lies on: +x -x +y -y +z -z of its own axes.
int sideOfBox(const Primitive& box, const Eigen::Vector3d& point);
/// The rectangle of a side, in the model.
Rectangle boxSide(const Primitive& box, int side);

}  // namespace ladar_perception::sim
