// SPDX-License-Identifier: BSD-3-Clause
#include "structures.h"

#include <array>
#include <cmath>

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

constexpr double kTwoPi = 6.283185307179586;

void addWheel(const Vector3d& hub, double radius_m, Model* parts) {
  constexpr int kPieces = 18;
  const auto rim = [&](int i) {
    const double a = kTwoPi * i / kPieces;
    return Vector3d(hub + radius_m * Vector3d(std::cos(a), 0.0, std::sin(a)));
  };
  for (int i = 0; i < kPieces; ++i) {
    parts->push_back(makeCapsule(rim(i), rim(i + 1), 0.018, Material::kBicycle));
    if (i % 3 == 0) parts->push_back(makeCapsule(hub, rim(i), 0.003, Material::kTube));
  }
}

}  // namespace

Model makeBicycle(Random* random) {
  Model parts;
  const Vector3d rear(-0.52, 0.0, 0.34);
  const Vector3d front(0.54, 0.0, 0.34);
  addWheel(rear, 0.32, &parts);
  addWheel(front, 0.32, &parts);
  const Vector3d pedals(-0.08, 0.0, 0.29);
  const Vector3d seat(-0.24, 0.0, 0.92);
  const Vector3d head(0.36, 0.0, 0.86);
  const Vector3d bars(0.33, 0.0, 1.02);
  const auto tube = [&](const Vector3d& from, const Vector3d& to, double radius_m) {
    parts.push_back(makeCapsule(from, to, radius_m, Material::kBicycle));
  };
  tube(pedals, seat, 0.017);
  tube(pedals, head, 0.019);
  tube(0.85 * seat + 0.15 * pedals, head, 0.017);
  tube(rear, pedals, 0.012);
  tube(rear, 0.85 * seat + 0.15 * pedals, 0.010);
  tube(front, head, 0.014);
  tube(head, bars, 0.014);
  const double turn = random->uniform(-0.4, 0.4);
  const Vector3d grip = 0.29 * Vector3d(std::sin(turn), std::cos(turn), 0.0);
  tube(bars - grip, bars + grip, 0.012);
  parts.push_back(
      makeBox(seat + Vector3d(0.0, 0.0, 0.03), {0.26, 0.14, 0.05}, 0.0, Material::kRubber));
  return parts;
}

Model makeBicycleStand(int places) {
  Model parts;
  for (int i = 0; i < places; ++i) {
    const double y = 0.75 * (i - 0.5 * (places - 1));
    const std::array<Vector3d, 4> bend = {Vector3d(-0.4, y, -0.2), Vector3d(-0.4, y, 0.75),
                                          Vector3d(0.4, y, 0.75), Vector3d(0.4, y, -0.2)};
    for (int k = 0; k < 3; ++k) {
      parts.push_back(makeCapsule(bend[k], bend[k + 1], 0.025, Material::kTube));
    }
  }
  return parts;
}

Model makeBench() {
  Model parts;
  for (const double x : {-0.16, 0.0, 0.16}) {
    parts.push_back(makeBox({x, 0.0, 0.45}, {0.12, 1.7, 0.04}, 0.0, Material::kPlank));
  }
  for (const double z : {0.62, 0.78}) {
    parts.push_back(makeBox({-0.27, 0.0, z}, {0.03, 1.7, 0.11}, 0.0, Material::kPlank));
  }
  for (const double y : {-0.7, 0.7}) {
    for (const double x : {-0.25, 0.2}) {
      parts.push_back(makeCapsule({x, y, -0.1}, {x, y, 0.43}, 0.025, Material::kTube));
    }
    parts.push_back(makeCapsule({-0.25, y, 0.4}, {-0.29, y, 0.84}, 0.02, Material::kTube));
  }
  return parts;
}

Model makeLampPost(double height_m) {
  const Vector3d top(0.0, 0.0, height_m);
  const Vector3d arm = top + Vector3d(0.9, 0.0, 0.15);
  return {makeCylinder({0.0, 0.0, -0.3}, {0.0, 0.0, 0.9}, 0.085, Material::kSteel),
          makeCylinder({0.0, 0.0, 0.9}, top, 0.055, Material::kSteel),
          makeCapsule(top, arm, 0.035, Material::kSteel),
          makeBox(arm, {0.5, 0.2, 0.1}, 0.0, Material::kSteel)};
}

Model makeUtilityPole(double height_m) {
  Model parts;
  const Vector3d arm(0.0, 1.0, 0.0);
  const Vector3d top(0.0, 0.0, height_m);
  parts.push_back(makeCylinder({0.0, 0.0, -0.8}, 0.5 * top, 0.14, Material::kPost));
  parts.push_back(makeCylinder(0.5 * top, top + Vector3d(0, 0, 0.2), 0.115, Material::kPost));
  parts.push_back(makeCapsule(top - arm, top + arm, 0.05, Material::kPost));
  for (const double y : {-0.9, 0.0, 0.9}) {
    const Vector3d foot = top + Vector3d(0.0, y, 0.0);
    parts.push_back(makeCapsule(foot, foot + Vector3d(0, 0, 0.15), 0.03, Material::kSteel));
  }
  return parts;
}

Model makeStreetPole(const UtilityPoleStyle& style) {
  Model parts;
  const double top = style.height_m + 0.4;
  const double thin = 0.7 * style.radius_m;
  constexpr int kPieces = 4;
  for (int i = 0; i < kPieces; ++i) {
    const double low = i == 0 ? -0.8 : top * i / kPieces;
    const double radius = style.radius_m + (thin - style.radius_m) * (i + 0.5) / kPieces;
    parts.push_back(
        makeCylinder({0, 0, low}, {0, 0, top * (i + 1) / kPieces}, radius, Material::kPost));
  }
  for (int arm = 0; arm < style.cross_arms; ++arm) {
    const double z = style.height_m - 0.9 * arm;
    parts.push_back(makeBox({thin + 0.05, 0.0, z}, {0.11, 2.2, 0.13}, 0.0, Material::kPost));
    for (const double y : {-0.9, -0.3, 0.3, 0.9}) {
      parts.push_back(
          makeCapsule({thin + 0.05, y, z}, {thin + 0.05, y, z + 0.2}, 0.04, Material::kPost));
    }
    for (const double y : {-0.6, 0.6}) {
      parts.push_back(makeCapsule({0.0, 0.0, z - 0.6}, {thin, y, z}, 0.02, Material::kSteel));
    }
  }
  if (style.transformer) {
    const double x = -thin - 0.3;
    const double z = style.height_m - 2.2;
    parts.push_back(makeCylinder({x, 0, z}, {x, 0, z + 1.0}, 0.25, Material::kMetalBox));
  }
  if (style.lamp_arm_m > 0.0) {
    const Vector3d root(0.0, 0.0, 7.0);
    const Vector3d head(0.0, style.lamp_arm_m, 7.7);
    parts.push_back(makeCapsule(root, head, 0.04, Material::kSteel));
    parts.push_back(makeBox(head, {0.22, 0.55, 0.14}, 0.0, Material::kMetalBox));
  }
  return parts;
}

Model makeHydrant() {
  return {makeCylinder({0.0, 0.0, -0.1}, {0.0, 0.0, 0.62}, 0.12, Material::kMetalBox),
          makeSphere({0.0, 0.0, 0.62}, 0.12, Material::kMetalBox),
          makeCapsule({0.0, -0.18, 0.45}, {0.0, 0.18, 0.45}, 0.06, Material::kMetalBox)};
}

Model makeLitterBin() {
  return {makeCylinder({0.0, 0.0, -0.1}, {0.0, 0.0, 0.95}, 0.28, Material::kMetalBox)};
}

Model makeParkingMeter() {
  return {makeCapsule({0.0, 0.0, -0.2}, {0.0, 0.0, 1.1}, 0.035, Material::kSteel),
          makeBox({0.0, 0.0, 1.25}, {0.12, 0.16, 0.3}, 0.0, Material::kMetalBox)};
}

Model makeSignPost() {
  return {makeCapsule({0.0, 0.0, -0.3}, {0.0, 0.0, 2.2}, 0.03, Material::kSteel),
          makeBox({0.04, 0.0, 1.95}, {0.01, 0.55, 0.55}, 0.0, Material::kBoard)};
}

Model makeStairs(double width_m, double rise_m) {
  Model parts;
  const auto steps = static_cast<int>(std::ceil(rise_m / 0.16));
  for (int i = 0; i < steps; ++i) {
    // Each step reaches down into the ground, so that slopes leave no gap.
    const double top = rise_m * (i + 1) / steps;
    parts.push_back(makeBox({0.3 * (i - steps) + 0.15, 0.0, 0.5 * (top - 0.5)},
                            {0.3, width_m, top + 0.5}, 0.0, Material::kStep));
  }
  const double foot = -0.3 * steps;
  for (const double y : {-0.5 * width_m + 0.05, 0.5 * width_m - 0.05}) {
    const Vector3d low(foot, y, 0.95);
    const Vector3d high(0.0, y, rise_m + 0.95);
    parts.push_back(makeCapsule(low, high, 0.022, Material::kTube));
    parts.push_back(makeCapsule(low - Vector3d(0, 0, 0.45), high - Vector3d(0, 0, 0.45), 0.015,
                                Material::kTube));
    parts.push_back(makeCapsule(low, low - Vector3d(0, 0, 1.1), 0.022, Material::kTube));
    parts.push_back(makeCapsule(high, high - Vector3d(0, 0, 0.95), 0.022, Material::kTube));
  }
  return parts;
}

}  // namespace ladar_perception::sim
