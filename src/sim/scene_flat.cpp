// SPDX-License-Identifier: BSD-3-Clause
// Nearly flat ground with fences, hedges and power lines.
#include <cmath>

#include "scene_builder.h"
#include "structures.h"
#include "vegetation.h"

namespace ladar_perception::sim {
namespace {

constexpr double kPi = 3.141592653589793;

/// A mast held by guy wires, in the open.
void addMast(const Eigen::Vector2d& p_world, SceneBuilder* builder) {
  const Eigen::Vector3d top = builder->at(p_world, 6.0);
  builder->fixed().push_back(makeCylinder(builder->at(p_world, -0.3), top, 0.06, Material::kSteel));
  for (int i = 0; i < 3; ++i) {
    const double a = 2.0 * kPi * i / 3.0;
    const Eigen::Vector2d peg = p_world + 3.5 * Eigen::Vector2d(std::cos(a), std::sin(a));
    for (const double z : {3.0, 5.6}) {
      builder->hangWire(builder->at(p_world, z), builder->at(peg), 0.03, 0.006);
    }
  }
  builder->claim(p_world, 4.0);
}

}  // namespace

World makeFlatGround(uint64_t seed) {
  const GroundStyle style{{{0.25, 60.0, 1.0}, {0.04, 8.0, 1.0}, {0.025, 0.8, 0.6}},
                          [](double track_m, double noise) {
                            if (track_m < 1.4) return Material::kTrack;
                            return noise > 0.1 ? Material::kMeadow : Material::kSoil;
                          }};
  SceneBuilder builder({55.0, 45.0}, style, seed);
  const double length = builder.circuit().length();
  addFenceAlongTrack(0.0, 0.35 * length, -8.0, FenceKind::kWire, &builder);
  addFenceAlongTrack(0.55 * length, 0.75 * length, 6.0, FenceKind::kRails, &builder);
  addHedgeAlongTrack(0.40 * length, 0.52 * length, -7.0, 1.3, &builder);
  addHedgeAlongTrack(0.05 * length, 0.12 * length, 9.0, 1.8, &builder);
  addCableAlongTrack(0.62 * length, 0.95 * length, -6.0, 2.4, &builder);
  addPowerLine({75.0, -95.0}, {40.0, 95.0}, 26.0, 5.2, &builder);
  addPowerLine({-95.0, 14.0}, {95.0, 22.0}, 24.0, 4.6, &builder);
  addMast({30.0, -8.0}, &builder);
  addMast({-20.0, -24.0}, &builder);
  const auto rocks = addVariants(
      4, &builder, [](Random* random) { return makeRock(random->uniform(0.2, 0.6), random); });
  const auto dead = addVariants(
      2, &builder, [](Random* random) { return makeDeadBush(random->uniform(0.7, 1.3), random); });
  const auto trees = addVariants(2, &builder, [](Random* random) {
    return makeBroadleaf(random->uniform(5.0, 8.0), 0.14, Material::kBark, random);
  });
  const auto tufts = addVariants(3, &builder, [](Random* random) {
    return makeGrassTuft(random->uniform(0.15, 0.35), 0.2, 30, 0.4, random);
  });
  const auto bushes = addVariants(4, &builder, [](Random* random) {
    const double height = random->uniform(0.7, 1.6);
    return makeBush(height, height * random->uniform(0.5, 0.8), random);
  });
  builder.scatter({trees, 40, 0.8, 1.2, 3.0, 6.0});
  builder.scatter({rocks, 220, 0.6, 1.3, 0.9, 2.6});
  builder.scatter({bushes, 260, 0.6, 1.2, 0.9, 2.8});
  builder.scatter({dead, 120, 0.6, 1.2, 0.7, 2.8});
  builder.scatter({tufts, 5000, 0.6, 1.3, 0.0, 3.0, 45.0, 14.0});
  return builder.finish();
}

}  // namespace ladar_perception::sim
