// SPDX-License-Identifier: BSD-3-Clause
// Limbs, leaves and blades, the parts of every plant.
#pragma once

#include <vector>

#include "ladar_perception/sim/primitive.h"
#include "ladar_perception/sim/random.h"

namespace ladar_perception::sim {

/// Chain of capsules that wanders and tapers. Branches become twigs below a radius of 2.5 cm: who
/// labels a crown by hand takes them for a part of the foliage.
struct Limb {
  Eigen::Vector3d from;
  Eigen::Vector3d direction;  ///< unit length
  double length_m = 1.0;
  double radius_from_m = 0.05;
  double radius_to_m = 0.02;
  double wander = 0.1;  ///< random change of direction per piece
  double lift = 0.0;    ///< change of the direction's z per piece; negative droops
  int pieces = 3;
  Material material = Material::kBranch;
};

Eigen::Vector3d randomDirection(Random* random);
Eigen::Vector3d polar(double azimuth_rad, double elevation_rad);

/// Appends the limb; returns its joints, first to last (pieces + 1 points).
std::vector<Eigen::Vector3d> growLimb(const Limb& limb, Random* random,
                                      std::vector<Primitive>* parts);

/// Appends `count` leaves of 3 to 8 cm, thinning out with the distance from the centre.
void growClump(const Eigen::Vector3d& centre, double radius_m, int count, double leaf_radius_m,
               Material material, Random* random, std::vector<Primitive>* parts);

/// Appends a blade of grass that bends towards `lean`.
void growBlade(const Eigen::Vector3d& foot, const Eigen::Vector3d& lean, double height_m,
               double width_m, Material material, Random* random, std::vector<Primitive>* parts);

}  // namespace ladar_perception::sim
