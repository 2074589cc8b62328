// SPDX-License-Identifier: BSD-3-Clause
// Trees whose crowns are made of clumps with gaps between them.
#include <algorithm>
#include <cmath>

#include "plant_parts.h"
#include "vegetation.h"

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

constexpr double kTwoPi = 6.283185307179586;
constexpr double kGoldenAngle = 2.399963229728653;
constexpr double kRootM = 0.6;

/// Crown as an ellipsoid that branches end in.
struct Crown {
  Vector3d centre;
  double radius_m;
  double half_height_m;

  /// Share of the way to the surface, 1 on it.
  double share(const Vector3d& p) const {
    const Vector3d d = p - centre;
    return std::hypot(std::hypot(d.x(), d.y()) / radius_m, d.z() / half_height_m);
  }
};

/// Leaves around a twig: flattened heaps, the lower side nearly bare.
void growHeap(const Vector3d& centre, double radius_m, int leaves, double leaf_radius_m,
              Material leaf, Random* random, Model* parts) {
  for (int i = 0; i < leaves; ++i) {
    Vector3d offset = randomDirection(random) * radius_m * std::cbrt(random->uniform());
    offset.z() *= offset.z() > 0.0 ? 0.7 : 0.45;
    // Leaves lie more often than they stand.
    Vector3d normal = randomDirection(random);
    normal.z() *= 1.5;
    const double size = leaf_radius_m * random->uniform(0.7, 1.3);
    parts->push_back(makeDisc(centre + offset, normal, size, leaf));
  }
}

void growTwigs(const std::vector<Vector3d>& joints, const Crown& crown, const TreeStyle& style,
               Random* random, Model* parts) {
  const Vector3d along = (joints.back() - joints.front()).normalized();
  const int twigs = 4 + random->below(3);
  for (int i = 0; i < twigs; ++i) {
    const auto from = 1 + random->below(static_cast<int>(joints.size()) - 1);
    Limb twig;
    twig.from = joints[from];
    twig.direction =
        (along + 0.9 * randomDirection(random) + 0.15 * Vector3d::UnitZ()).normalized();
    twig.length_m = 0.22 * crown.radius_m * random->uniform(0.6, 1.2);
    twig.radius_from_m = 0.012;
    twig.radius_to_m = 0.005;
    twig.pieces = 2;
    const Vector3d end = growLimb(twig, random, parts).back();
    // The inside of a crown is in the dark.
    if (random->uniform() > crown.share(end) + 0.25) continue;
    const double radius = 0.10 * crown.radius_m * random->uniform(0.7, 1.4) + 0.15;
    const auto leaves = static_cast<int>(style.leaves_per_m3 * 2.0 * radius * radius * radius);
    growHeap(end, radius, leaves, style.leaf_radius_m, style.leaf, random, parts);
  }
}

void growMainBranch(const Vector3d& from, double azimuth_rad, double elevation_rad,
                    double radius_from_m, const Crown& crown, const TreeStyle& style,
                    Random* random, Model* parts) {
  Limb branch;
  branch.from = from;
  branch.direction = polar(azimuth_rad, elevation_rad);
  // Just into the skin of the crown.
  branch.length_m = 0.3;
  while (branch.length_m < 2.5 * crown.radius_m &&
         crown.share(from + branch.length_m * branch.direction) < 0.85) {
    branch.length_m += 0.2;
  }
  branch.radius_from_m = radius_from_m;
  branch.radius_to_m = 0.015;
  branch.wander = 0.16;
  branch.lift = 0.03;
  branch.pieces = 6;
  const std::vector<Vector3d> joints = growLimb(branch, random, parts);
  growTwigs({joints[4], joints[5], joints[6]}, crown, style, random, parts);
  const int side_branches = 4 + random->below(3);
  for (int i = 0; i < side_branches; ++i) {
    const int joint = 2 + random->below(4);
    Limb side = branch;
    side.from = joints[joint];
    side.direction = (branch.direction + 0.95 * randomDirection(random)).normalized();
    side.length_m = 0.45 * crown.radius_m * random->uniform(0.6, 1.2);
    side.radius_from_m = std::max(0.012, 0.4 * radius_from_m);
    side.radius_to_m = 0.008;
    side.pieces = 3;
    growTwigs(growLimb(side, random, parts), crown, style, random, parts);
  }
}

}  // namespace

Model makeCrownTree(const TreeStyle& style, Random* random) {
  Model parts;
  Limb trunk;
  trunk.from = {0.0, 0.0, -kRootM};
  trunk.direction = (Vector3d::UnitZ() + 0.05 * randomDirection(random)).normalized();
  trunk.length_m = 0.85 * style.height_m + kRootM;
  trunk.radius_from_m = style.trunk_radius_m;
  trunk.radius_to_m = 0.15 * style.trunk_radius_m;
  trunk.wander = 0.05;
  trunk.pieces = 12;
  trunk.material = style.bark;
  std::vector<Vector3d> joints = growLimb(trunk, random, &parts);
  // Above the first third of the crown the stem is one branch among others.
  const double fork_m = style.bare_m + 0.33 * (style.height_m - style.bare_m);
  for (Primitive& piece : parts) {
    if (std::min(piece.a.z(), piece.b.z()) < fork_m) continue;
    piece.material = piece.radius_m < 0.025F ? Material::kTwig : Material::kBranch;
  }
  const double half_height = 0.5 * (style.height_m - style.bare_m);
  const Crown crown{{joints[8].x(), joints[8].y(), style.bare_m + half_height},
                    style.crown_radius_m,
                    half_height};
  const double spin = random->uniform(0.0, kTwoPi);
  for (int i = 0; i < style.branches; ++i) {
    const double u = (i + random->uniform()) / style.branches;
    const double z = style.bare_m * 0.9 + u * 0.75 * (style.height_m - style.bare_m);
    const double along = std::clamp((z + kRootM) / trunk.length_m * trunk.pieces, 0.0, 11.99);
    const auto piece = static_cast<int>(along);
    const Vector3d from = joints[piece] + (along - piece) * (joints[piece + 1] - joints[piece]);
    const double elevation = random->uniform(0.15, 0.6) + 0.6 * u;
    growMainBranch(from, spin + kGoldenAngle * i, elevation,
                   (0.38 - 0.22 * u) * style.trunk_radius_m, crown, style, random, &parts);
  }
  return parts;
}

}  // namespace ladar_perception::sim
