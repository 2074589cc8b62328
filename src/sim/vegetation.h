// SPDX-License-Identifier: BSD-3-Clause
// Plants, each with its foot at the origin and z up. Sizes in metres.
#pragma once

#include <vector>

#include "ladar_perception/sim/primitive.h"
#include "ladar_perception/sim/random.h"

namespace ladar_perception::sim {

using Model = std::vector<Primitive>;

/// Trunk with taper, main branches from a quarter of the height, clumps of leaves at their ends.
Model makeBroadleaf(double height_m, double trunk_radius_m, Material bark, Random* random);
struct TreeStyle {
  double height_m = 11.0;
  double trunk_radius_m = 0.18;
  double bare_m = 2.8;  ///< trunk without branches
  double crown_radius_m = 3.5;
  int branches = 12;
  double leaves_per_m3 = 220.0;  ///< inside the clumps
  double leaf_radius_m = 0.05;
  Material bark = Material::kBark;
  Material leaf = Material::kLeaf;
};

/// Tree with a bare trunk and a crown of clumps, as they stand along streets and in parks.
Model makeCrownTree(const TreeStyle& style, Random* random);
/// Straight trunk, whorls of drooping branches with needles along them, dead ones below.
Model makeConifer(double height_m, double trunk_radius_m, Random* random);
/// Young tree: a thin stem and a few leaves.
Model makeSapling(double height_m, Random* random);
/// Stems from the ground, leaves from the ground up.
Model makeBush(double height_m, double radius_m, Random* random);
/// Leafless shrub.
Model makeDeadBush(double height_m, Random* random);
Model makeFern(double height_m, Random* random);
/// Blades that stand in a disc and lean outward.
Model makeGrassTuft(double height_m, double radius_m, int blades, double dry_share, Random* random);
/// Piece of a clipped hedge along x, `length_m` long, centred on the origin.
Model makeHedge(double length_m, double width_m, double height_m, Random* random);
/// Fallen trunk along x with broken branches.
Model makeLog(double length_m, double radius_m, Random* random);
Model makeStump(Random* random);
/// Heap of one to three boulders.
Model makeRock(double radius_m, Random* random);

}  // namespace ladar_perception::sim
