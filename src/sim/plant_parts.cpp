// SPDX-License-Identifier: BSD-3-Clause
#include "plant_parts.h"

#include <Eigen/Geometry>
#include <cmath>

namespace ladar_perception::sim {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kTwigM = 0.025;

}  // namespace

Eigen::Vector3d polar(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

Eigen::Vector3d randomDirection(Random* random) {
  const double z = random->uniform(-1.0, 1.0);
  return polar(random->uniform(0.0, kTwoPi), std::asin(z));
}

std::vector<Eigen::Vector3d> growLimb(const Limb& limb, Random* random,
                                      std::vector<Primitive>* parts) {
  std::vector<Eigen::Vector3d> joints = {limb.from};
  Eigen::Vector3d direction = limb.direction;
  for (int i = 0; i < limb.pieces; ++i) {
    const Eigen::Vector3d next = joints.back() + direction * (limb.length_m / limb.pieces);
    const double u = (i + 0.5) / limb.pieces;
    const double radius = (1.0 - u) * limb.radius_from_m + u * limb.radius_to_m;
    const bool is_twig = limb.material == Material::kBranch && radius < kTwigM;
    parts->push_back(
        makeCapsule(joints.back(), next, radius, is_twig ? Material::kTwig : limb.material));
    joints.push_back(next);
    direction += limb.wander * randomDirection(random) + limb.lift * Eigen::Vector3d::UnitZ();
    direction.normalize();
  }
  return joints;
}

void growClump(const Eigen::Vector3d& centre, double radius_m, int count, double leaf_radius_m,
               Material material, Random* random, std::vector<Primitive>* parts) {
  for (int i = 0; i < count; ++i) {
    const double distance = radius_m * std::sqrt(random->uniform());
    Eigen::Vector3d p = centre + distance * randomDirection(random);
    p.z() = centre.z() + 0.8 * (p.z() - centre.z());
    if (p.z() < 0.03) continue;  // under the ground
    const double size = leaf_radius_m * random->uniform(0.7, 1.3);
    parts->push_back(makeDisc(p, randomDirection(random), size, material));
  }
}

void growBlade(const Eigen::Vector3d& foot, const Eigen::Vector3d& lean, double height_m,
               double width_m, Material material, Random* random, std::vector<Primitive>* parts) {
  const Eigen::Vector3d side = 0.5 * width_m * polar(random->uniform(0.0, kTwoPi), 0.0);
  const Eigen::Vector3d bend =
      foot + 0.55 * height_m * Eigen::Vector3d::UnitZ() + 0.25 * height_m * lean;
  const Eigen::Vector3d tip = foot + height_m * Eigen::Vector3d::UnitZ() + 0.8 * height_m * lean;
  parts->push_back(makeTriangle(foot - side, foot + side, bend + side, material));
  parts->push_back(makeTriangle(foot - side, bend + side, bend - side, material));
  parts->push_back(makeTriangle(bend - side, bend + side, tip, material));
}

}  // namespace ladar_perception::sim
