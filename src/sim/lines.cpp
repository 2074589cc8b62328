// SPDX-License-Identifier: BSD-3-Clause
// Fences, hedges, cables and power lines: long things that follow the ground.
#include <algorithm>
#include <cmath>

#include "structures.h"

namespace ladar_perception::sim {
namespace {

constexpr double kFenceSpanM = 2.5;

void addSpan(const Eigen::Vector3d& from, const Eigen::Vector3d& to, FenceKind kind,
             SceneBuilder* builder) {
  const auto raised = [](Eigen::Vector3d p, double z) {
    p.z() += z;
    return p;
  };
  if (kind == FenceKind::kWire) {
    for (const double z : {0.35, 0.65, 0.95, 1.2}) {
      builder->hangWire(raised(from, z), raised(to, z), 0.02, 0.004, Material::kFenceWire);
    }
    return;
  }
  if (kind == FenceKind::kBoards) {
    const Eigen::Vector3d across = to - from;
    const double yaw = std::atan2(across.y(), across.x());
    for (double u = 0.03; u < 1.0; u += 0.05) {
      const Eigen::Vector3d p = raised(from + u * across, 0.62);
      builder->fixed().push_back(makeBox(p, {0.1, 0.02, 1.1}, yaw, Material::kPlank));
    }
    return;
  }
  for (const double z : {0.5, 1.0}) {
    builder->fixed().push_back(
        makeCapsule(raised(from, z), raised(to, z), 0.045, Material::kFenceRail));
  }
}

}  // namespace

void addFenceAlongTrack(double from_m, double to_m, double left_m, FenceKind kind,
                        SceneBuilder* builder) {
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (double s = from_m; s <= to_m; s += kFenceSpanM) {
    const Eigen::Vector2d p = builder->circuit().beside(s, left_m);
    const Eigen::Vector3d foot = builder->at(p);
    const double height = kind == FenceKind::kWire ? 1.3 : 1.15;
    const double radius = kind == FenceKind::kWire ? 0.05 : 0.075;
    builder->fixed().push_back(makeCylinder(foot - 0.4 * Eigen::Vector3d::UnitZ(),
                                            foot + height * Eigen::Vector3d::UnitZ(), radius,
                                            Material::kFencePost));
    builder->claim(p, 0.8 * kFenceSpanM);
    if (s > from_m) addSpan(last, foot, kind, builder);
    last = foot;
  }
}

void addPowerLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double span_m,
                  double height_m, SceneBuilder* builder) {
  const uint32_t pole = builder->addModel(makeUtilityPole(height_m));
  const Eigen::Vector2d along = (to - from).normalized();
  const double yaw = std::atan2(along.y(), along.x());
  const Eigen::Vector3d across(-along.y(), along.x(), 0.0);
  const double length = (to - from).norm();
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  bool first = true;
  for (double s = 0.0; s <= length; s += span_m) {
    Eigen::Vector2d p = from + s * along;
    // Move on until the pole leaves the track and whatever stands there alone.
    const auto blocked = [&] {
      return builder->circuit().distanceTo(p.x(), p.y()) < kClearHalfWidthM + 1.0 ||
             !builder->isFree(p, 0.3);
    };
    while (s < length && blocked()) p = from + (s += 1.0) * along;
    builder->place(pole, p, yaw);
    builder->claim(p, 1.0);
    const Eigen::Vector3d top = builder->at(p, height_m + 0.12);
    for (const double y : {-0.9, 0.0, 0.9}) {
      if (!first) builder->hangWire(last + y * across, top + y * across, 0.25, 0.008);
    }
    const Eigen::Vector3d cable(0.0, 0.0, -1.5);
    if (!first) builder->hangWire(last + cable, top + cable, 0.3, 0.014);
    last = top;
    first = false;
  }
}

void placeBeside(uint32_t model, double s_m, double left_m, double turn_rad, double claim_m,
                 SceneBuilder* builder) {
  const Eigen::Vector2d p = builder->circuit().beside(s_m, left_m);
  builder->place(model, p, builder->circuit().heading(s_m) + turn_rad);
  builder->claim(p, claim_m);
}

void addHedgeAlongTrack(double from_m, double to_m, double left_m, double height_m,
                        SceneBuilder* builder) {
  const auto hedges = addVariants(
      3, builder, [&](Random* random) { return makeHedge(2.0, 0.8, height_m, random); });
  for (double s = from_m; s < to_m; s += 1.95) {
    placeBeside(hedges[builder->random().below(3)], s, left_m, 0.0, 1.4, builder);
  }
}

void addCableAlongTrack(double from_m, double to_m, double left_m, double height_m,
                        SceneBuilder* builder) {
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (double s = from_m; s <= to_m; s += 9.0) {
    const Eigen::Vector2d p = builder->circuit().beside(s, left_m);
    const Eigen::Vector3d top = builder->at(p, height_m);
    builder->fixed().push_back(makeCylinder(builder->at(p, -0.4), top, 0.07, Material::kPost));
    builder->claim(p, 0.5);
    if (s > from_m) builder->hangWire(last, top, 0.15, 0.01);
    last = top;
  }
}

}  // namespace ladar_perception::sim
