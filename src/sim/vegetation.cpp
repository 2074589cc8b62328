// SPDX-License-Identifier: BSD-3-Clause
#include "vegetation.h"

#include <algorithm>
#include <cmath>

#include "plant_parts.h"

namespace ladar_perception::sim {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kGoldenAngle = 2.399963229728653;
// Trunks reach below the ground: a tree on a slope has its foot at one height only.
constexpr double kRootM = 0.6;

/// A branch with two to four side branches, leaves around the outer joints of all of them.
void growLeafyBranch(const Limb& branch, double leafiness, Random* random, Model* parts) {
  const std::vector<Eigen::Vector3d> joints = growLimb(branch, random, parts);
  const double clump = 0.16 * branch.length_m + 0.18;
  const auto leaves = static_cast<int>(leafiness * (40.0 + 30.0 * branch.length_m));
  growClump(joints.back(), clump, leaves, 0.035, Material::kLeaf, random, parts);
  const int twigs = 2 + random->below(3);
  for (int i = 0; i < twigs; ++i) {
    Limb twig = branch;
    twig.from = joints[1 + random->below(branch.pieces)];
    twig.direction = (branch.direction + 0.9 * randomDirection(random)).normalized();
    twig.length_m = branch.length_m * random->uniform(0.25, 0.5);
    twig.radius_from_m = 0.5 * branch.radius_to_m + 0.004;
    twig.radius_to_m = 0.005;
    twig.pieces = 2;
    const Eigen::Vector3d end = growLimb(twig, random, parts).back();
    growClump(end, 0.8 * clump, leaves, 0.032, Material::kLeaf, random, parts);
  }
}

void growBlades(int count, double radius_m, double height_m, double width_m, double dry_share,
                Random* random, Model* parts) {
  for (int i = 0; i < count; ++i) {
    const double out = std::sqrt(random->uniform());
    const double azimuth = random->uniform(0.0, kTwoPi);
    const Eigen::Vector3d foot = radius_m * out * polar(azimuth, 0.0);
    const double turned = azimuth + random->normal(0.0, 0.7);
    const Eigen::Vector3d lean = (0.5 * out + random->uniform(0.0, 0.4)) * polar(turned, 0.0);
    const double height = height_m * random->uniform(0.45, 1.0);
    const Material material = random->chance(dry_share) ? Material::kDryGrass : Material::kGrass;
    growBlade(foot, lean, height, width_m * random->uniform(0.6, 1.3), material, random, parts);
  }
}

}  // namespace

Model makeBroadleaf(double height_m, double trunk_radius_m, Material bark, Random* random) {
  Model parts;
  Limb trunk;
  trunk.from = {0.0, 0.0, -kRootM};
  trunk.direction = (Eigen::Vector3d::UnitZ() + 0.07 * randomDirection(random)).normalized();
  trunk.length_m = 0.9 * height_m + kRootM;
  trunk.radius_from_m = trunk_radius_m;
  trunk.radius_to_m = 0.25 * trunk_radius_m;
  trunk.wander = 0.05;
  trunk.pieces = 9;
  trunk.material = bark;
  const std::vector<Eigen::Vector3d> joints = growLimb(trunk, random, &parts);
  const auto branches = static_cast<int>(8.0 + height_m);
  const double spin = random->uniform(0.0, kTwoPi);
  for (int i = 0; i < branches; ++i) {
    const double u = 0.22 + 0.78 * (i + random->uniform()) / branches;
    const double along = u * trunk.pieces;
    const int piece = std::min(static_cast<int>(along), trunk.pieces - 1);
    Limb branch;
    branch.from = joints[piece] + (along - piece) * (joints[piece + 1] - joints[piece]);
    branch.direction = polar(spin + kGoldenAngle * i, random->uniform(0.1, 0.5) + 0.5 * u);
    branch.length_m = (0.30 - 0.18 * u) * height_m * random->uniform(0.7, 1.2);
    branch.radius_from_m = (0.35 - 0.15 * u) * trunk_radius_m;
    branch.radius_to_m = 0.012;
    branch.wander = 0.25;
    branch.lift = 0.05;
    // The lowest branches stand in the shade and carry little.
    growLeafyBranch(branch, u < 0.35 ? 0.4 : 1.0, random, &parts);
  }
  return parts;
}

Model makeConifer(double height_m, double trunk_radius_m, Random* random) {
  Model parts;
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  growLimb(
      {-kRootM * up, up, height_m + kRootM, trunk_radius_m, 0.02, 0.015, 0.0, 8, Material::kBark},
      random, &parts);
  for (double z = 0.5; z < height_m - 0.3; z += random->uniform(0.3, 0.5)) {
    const double reach = 0.26 * (height_m - z) * (z < 0.15 * height_m ? 0.5 : 1.0);
    const bool dead = z < 0.2 * height_m;
    const int whorl = 4 + random->below(3);
    const double spin = random->uniform(0.0, kTwoPi);
    for (int i = 0; i < whorl; ++i) {
      const double azimuth = spin + kTwoPi * i / whorl + random->uniform(-0.2, 0.2);
      Limb branch{z * up,
                  polar(azimuth, random->uniform(-0.2, 0.15)),
                  reach * random->uniform(0.7, 1.1),
                  0.02,
                  0.006,
                  0.1,
                  -0.05,
                  4};
      const std::vector<Eigen::Vector3d> joints = growLimb(branch, random, &parts);
      for (int k = 1; k <= branch.pieces && !dead; ++k) {
        growClump(joints[k], 0.08 + 0.12 * branch.length_m, 16, 0.026, Material::kNeedle, random,
                  &parts);
      }
    }
  }
  return parts;
}

Model makeSapling(double height_m, Random* random) {
  Model parts;
  Limb stem{{0.0, 0.0, -0.2},
            polar(random->uniform(0.0, kTwoPi), 1.45),
            height_m + 0.2,
            0.012 + 0.007 * height_m,
            0.006,
            0.08,
            0.0,
            5,
            Material::kBark};
  const std::vector<Eigen::Vector3d> joints = growLimb(stem, random, &parts);
  const int branches = 4 + random->below(5);
  for (int i = 0; i < branches; ++i) {
    Limb branch{joints[2 + random->below(4)],
                polar(kGoldenAngle * i, random->uniform(0.2, 0.9)),
                0.25 * height_m * random->uniform(0.6, 1.2),
                0.008,
                0.004,
                0.2,
                0.0,
                2};
    const Eigen::Vector3d end = growLimb(branch, random, &parts).back();
    growClump(end, 0.1 + 0.06 * height_m, 22, 0.03, Material::kLeaf, random, &parts);
  }
  return parts;
}

Model makeBush(double height_m, double radius_m, Random* random) {
  Model parts;
  const int stems = 7 + random->below(6);
  for (int i = 0; i < stems; ++i) {
    const double out = std::sqrt((i + 0.5) / stems);
    const Eigen::Vector3d tip =
        polar(kGoldenAngle * i, 0.0) * radius_m * out +
        Eigen::Vector3d::UnitZ() * height_m * random->uniform(0.6, 1.0) * (1.0 - 0.4 * out);
    Limb stem{{0.0, 0.0, -0.1}, tip.normalized(), tip.norm(), 0.012, 0.005, 0.12, 0.0, 4,
              Material::kTwig};
    const std::vector<Eigen::Vector3d> joints = growLimb(stem, random, &parts);
    for (int k = 1; k <= stem.pieces; ++k) {
      growClump(joints[k], 0.30 * radius_m + 0.08, 34, 0.03, Material::kShrubLeaf, random, &parts);
    }
  }
  return parts;
}

Model makeDeadBush(double height_m, Random* random) {
  Model parts;
  const int stems = 5 + random->below(4);
  for (int i = 0; i < stems; ++i) {
    Limb stem{{0.0, 0.0, -0.1},
              polar(kGoldenAngle * i, random->uniform(0.7, 1.4)),
              height_m * random->uniform(0.7, 1.1),
              0.02,
              0.008,
              0.2,
              0.0,
              3};
    const std::vector<Eigen::Vector3d> joints = growLimb(stem, random, &parts);
    for (int k = 1; k <= 3; ++k) {
      Limb twig{joints[k],
                (stem.direction + randomDirection(random)).normalized(),
                0.35 * height_m,
                0.008,
                0.004,
                0.2,
                0.0,
                2,
                Material::kTwig};
      growLimb(twig, random, &parts);
    }
  }
  return parts;
}

Model makeFern(double height_m, Random* random) {
  Model parts;
  const int fronds = 9 + random->below(5);
  for (int i = 0; i < fronds; ++i) {
    Limb frond{{0.0, 0.0, 0.0}, polar(kGoldenAngle * i, random->uniform(0.6, 1.3)),
               1.3 * height_m,  0.004,
               0.003,           0.1,
               -0.22,           4,
               Material::kFern};
    const std::vector<Eigen::Vector3d> joints = growLimb(frond, random, &parts);
    for (int k = 1; k <= frond.pieces; ++k) {
      growClump(joints[k], 0.05 + 0.1 * height_m, 9, 0.026, Material::kFern, random, &parts);
    }
  }
  return parts;
}

Model makeGrassTuft(double height_m, double radius_m, int blades, double dry_share,
                    Random* random) {
  Model parts;
  growBlades(blades, radius_m, height_m, 0.011, dry_share, random, &parts);
  return parts;
}

Model makeHedge(double length_m, double width_m, double height_m, Random* random) {
  Model parts;
  for (double x = -0.5 * length_m + 0.2; x < 0.5 * length_m; x += 0.4) {
    Limb stem{{x, 0.0, -0.2},
              polar(random->uniform(0.0, kTwoPi), 1.35),
              0.9 * height_m,
              0.02,
              0.008,
              0.15,
              0.0,
              4,
              Material::kTwig};
    growLimb(stem, random, &parts);
  }
  const auto leaves = static_cast<int>(1300.0 * length_m * width_m * height_m);
  for (int i = 0; i < leaves; ++i) {
    // Clipped: flat sides on the average, ragged leaf by leaf; denser towards the light.
    const double side = random->chance(0.5) ? 0.5 : -0.5;
    const double depth = side * std::pow(random->uniform(), 0.6);
    const double x = random->uniform(-0.5, 0.5) * (length_m + 0.1);
    const double y = width_m * depth + random->normal(0.0, 0.03);
    const double clipped = height_m * std::pow(random->uniform(), 0.8);
    const double z = clipped + random->normal(0.0, 0.03);
    const double size = random->uniform(0.025, 0.042);
    const Eigen::Vector3d normal = randomDirection(random);
    if (z > 0.03) parts.push_back(makeDisc({x, y, z}, normal, size, Material::kHedgeLeaf));
  }
  return parts;
}

Model makeLog(double length_m, double radius_m, Random* random) {
  Model parts;
  const double half = 0.5 * length_m;
  const double z = 0.8 * radius_m;
  parts.push_back(makeCylinder({-half, 0.0, z}, {half, 0.0, z + 0.1}, radius_m, Material::kLog));
  for (int i = 0; i < 5; ++i) {
    const double azimuth = random->uniform(0.0, kTwoPi);
    Limb branch{{random->uniform(-0.2, 1.0) * half, 0.0, z},
                polar(azimuth, random->uniform(0.1, 1.2)),
                random->uniform(0.5, 1.4),
                0.12 * radius_m + 0.01,
                0.008,
                0.15,
                0.0,
                3};
    growLimb(branch, random, &parts);
  }
  return parts;
}

Model makeStump(Random* random) {
  const double radius = random->uniform(0.12, 0.28);
  return {makeCylinder({0.0, 0.0, -0.3}, {0.02, 0.01, random->uniform(0.25, 0.6)}, radius,
                       Material::kLog)};
}

Model makeRock(double radius_m, Random* random) {
  Model parts;
  const int count = 1 + random->below(3);
  for (int i = 0; i < count; ++i) {
    const double radius = radius_m * random->uniform(0.6, 1.0);
    const Eigen::Vector3d p = polar(random->uniform(0.0, kTwoPi), 0.0) * (i * 0.8 * radius_m);
    const double sunk = radius * random->uniform(0.1, 0.5);
    parts.push_back(makeSphere(p - sunk * Eigen::Vector3d::UnitZ(), radius, Material::kRock));
    const double yaw = random->uniform(0.0, kTwoPi);
    const double size = 1.25 * radius;
    parts.push_back(makeBox(p - 0.3 * sunk * Eigen::Vector3d::UnitZ(), {1.3 * size, size, size},
                            yaw, Material::kRock, 0.3));
  }
  return parts;
}

}  // namespace ladar_perception::sim
