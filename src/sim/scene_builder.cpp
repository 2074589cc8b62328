// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ladar_perception::sim {
namespace {

constexpr double kTwoPi = 6.283185307179586;
// The ladar sees 50 m from the track; its farthest point never needs ground beyond.
constexpr double kViewM = 53.0;

double halfSize(const Circuit& circuit) {
  double reach = 0.0;
  for (double s = 0.0; s < circuit.length(); s += 1.0) {
    reach = std::max(reach, circuit.position(s).cwiseAbs().maxCoeff());
  }
  return reach + kViewM;
}

HeightField makeGround(const Circuit& circuit, const GroundStyle& style, uint64_t seed) {
  const auto height = [&](double x, double y) {
    const double away = std::clamp((circuit.distanceTo(x, y) - 1.5) / 4.0, 0.0, 1.0);
    double sum = style.profile ? style.profile(circuit.placeOf(x, y)) : 0.0;
    uint64_t layer = 0;
    for (const Bumps& bumps : style.layers) {
      const double share = bumps.on_track + (1.0 - bumps.on_track) * away;
      sum += share * bumps.height_m *
             valueNoise(x / bumps.length_m, y / bumps.length_m, streamSeed(seed, {7, layer++}));
    }
    return sum;
  };
  const auto material = [&](double x, double y) {
    const double noise = valueNoise(x / 6.0, y / 6.0, streamSeed(seed, {8}));
    return style.material(circuit.distanceTo(x, y), noise);
  };
  return HeightField(halfSize(circuit), height, material);
}

}  // namespace

SceneBuilder::SceneBuilder(const CircuitShape& shape, const GroundStyle& style, uint64_t seed)
    : seed_(seed),
      random_(streamSeed(seed, {1})),
      circuit_(shape),
      half_size_m_(halfSize(circuit_)),
      scene_(makeGround(circuit_, style, seed)) {}

Eigen::Vector3d SceneBuilder::at(const Eigen::Vector2d& p_world, double above_m) const {
  return {p_world.x(), p_world.y(), ground(p_world.x(), p_world.y()) + above_m};
}

void SceneBuilder::place(uint32_t model, const Eigen::Vector2d& p_world, double yaw_rad,
                         double scale) {
  scene_.place(model, {at(p_world), yaw_rad, scale});
}

bool SceneBuilder::isFree(const Eigen::Vector2d& p_world, double radius_m) const {
  return std::none_of(claims_.begin(), claims_.end(), [&](const Claim& claim) {
    const double sum = claim.radius_m + radius_m;
    return (claim.p_world - p_world).squaredNorm() < sum * sum;
  });
}

void SceneBuilder::claim(const Eigen::Vector2d& p_world, double radius_m) {
  claims_.push_back({p_world, radius_m});
}

void SceneBuilder::scatter(const Scattering& scattering) {
  std::vector<double> reach;
  for (const uint32_t model : scattering.models) {
    reach.push_back(scene_.reachBelow(model, clear_height_m_ / scattering.min_scale));
  }
  const uint64_t patches = streamSeed(seed_, {9, random_.bits()});
  const auto models = static_cast<int>(scattering.models.size());
  for (int i = 0; i < scattering.count; ++i) {
    // The same draws for every try, so that one refusal does not move all that follow.
    const double x = random_.uniform(-half_size_m_, half_size_m_);
    const double y = random_.uniform(-half_size_m_, half_size_m_);
    const int kind = random_.below(models);
    const double scale = random_.uniform(scattering.min_scale, scattering.max_scale);
    const double yaw = random_.uniform(0.0, kTwoPi);
    const double luck = random_.uniform();
    const double track_m = circuit_.distanceTo(x, y);
    const double clear = kClearHalfWidthM + 0.4 + scale * reach[kind];
    if (track_m < std::max(clear, scattering.min_track_m)) continue;
    if (track_m > scattering.max_track_m) continue;
    if (scattering.patch_length_m > 0.0) {
      const double length = scattering.patch_length_m;
      if (luck > 0.5 + 0.9 * valueNoise(x / length, y / length, patches)) continue;
    }
    if (!isFree({x, y}, std::max(scattering.spacing_m, 0.1))) continue;
    if (scattering.spacing_m > 0.0) claim({x, y}, scattering.spacing_m);
    place(scattering.models[kind], {x, y}, yaw, scale);
  }
}

void SceneBuilder::hangWire(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double sag_m,
                            double radius_m, Material material) {
  const auto pieces = std::max(2, static_cast<int>((to - from).norm() / 1.5));
  Eigen::Vector3d last = from;
  for (int i = 1; i <= pieces; ++i) {
    const double u = static_cast<double>(i) / pieces;
    Eigen::Vector3d next = from + u * (to - from);
    next.z() -= 4.0 * sag_m * u * (1.0 - u);
    fixed_.push_back(makeCapsule(last, next, radius_m, material));
    last = next;
  }
}

World SceneBuilder::finish() {
  if (!fixed_.empty()) {
    const uint32_t model = scene_.addModel(std::move(fixed_));
    scene_.place(model, Placement());
  }
  scene_.finish();
  return {std::move(circuit_), std::move(scene_)};
}

}  // namespace ladar_perception::sim
