// SPDX-License-Identifier: BSD-3-Clause
// Open rough country: slopes, gullies and banks under low bushes and knee-high grass.
#include <algorithm>
#include <cmath>

#include "scene_builder.h"
#include "structures.h"
#include "vegetation.h"

namespace ladar_perception::sim {
namespace {

constexpr double kTwoPi = 6.283185307179586;

CircuitShape roughTrack(Random* random) {
  CircuitShape shape;
  shape.radius_x_m = random->uniform(50.0, 58.0);
  shape.radius_y_m = random->uniform(42.0, 50.0);
  shape.wave2 = random->uniform(0.03, 0.09);
  shape.wave3 = random->uniform(0.05, 0.10);
  shape.wave2_phase_rad = random->uniform(0.0, kTwoPi);
  shape.wave3_phase_rad = random->uniform(0.0, kTwoPi);
  return shape;
}

/// Gullies and banks that run beside the track and now and then across it.
double gulliesAndBanks(const TrackPlace& place, uint64_t seed) {
  const double out = std::abs(place.left_m);
  const uint64_t side = place.left_m > 0.0 ? 1 : 2;
  const auto noise = [&](uint64_t what, double length_m) {
    return valueNoise(place.s_m / length_m, static_cast<double>(side), streamSeed(seed, {4, what}));
  };
  // A ditch with sides of up to 45 degrees, at a distance that wanders.
  const double ditch_m = 6.0 + 2.5 * noise(0, 18.0);
  const double depth = std::max(0.0, 0.9 * noise(1, 14.0));
  const double across = (out - ditch_m) / 1.1;
  const double ditch = -depth * std::exp(-across * across);
  // A bank that rises or falls behind it, up to 3 m over 4 to 6 m.
  const double from_m = 7.5 + 2.0 * noise(2, 22.0);
  const double rise = 3.0 * noise(3, 26.0);
  const double u = std::clamp((out - from_m) / 5.0, 0.0, 1.0);
  const double fade = std::clamp((30.0 - out) / 10.0, 0.0, 1.0);
  return ditch + fade * rise * u * u * (3.0 - 2.0 * u);
}

void addBushes(SceneBuilder* builder) {
  const auto low = addVariants(6, builder, [](Random* random) {
    const double height = random->uniform(0.2, 0.6);
    return makeBush(height, height * random->uniform(0.7, 1.4), random);
  });
  const auto high = addVariants(6, builder, [](Random* random) {
    const double height = random->uniform(0.7, 1.5);
    return makeBush(height, height * random->uniform(0.45, 0.9), random);
  });
  const auto dead = addVariants(
      4, builder, [](Random* random) { return makeDeadBush(random->uniform(0.4, 1.3), random); });
  const auto ferns = addVariants(
      3, builder, [](Random* random) { return makeFern(random->uniform(0.15, 0.45), random); });
  builder->scatter({low, 5200, 0.7, 1.3, 0.0, 2.4, 50.0, 11.0});
  builder->scatter({high, 1500, 0.7, 1.1, 0.5, 2.6, 52.0, 16.0});
  builder->scatter({dead, 700, 0.6, 1.2, 0.4, 2.6});
  builder->scatter({ferns, 5000, 0.7, 1.3, 0.0, 2.4, 40.0, 8.0});
}

void addGrasses(SceneBuilder* builder) {
  const auto knee = addVariants(4, builder, [](Random* random) {
    const double height = random->uniform(0.3, 0.6);
    return makeGrassTuft(height, random->uniform(0.2, 0.35), 40, random->uniform(0.1, 0.8), random);
  });
  const auto turf = addVariants(3, builder, [](Random* random) {
    return makeGrassTuft(random->uniform(0.08, 0.2), 0.3, 40, 0.4, random);
  });
  builder->scatter({knee, 42000, 0.7, 1.2, 0.0, 1.8, 40.0, 9.0});
  builder->scatter({turf, 30000, 0.7, 1.3, 0.0, 1.6, 25.0, 6.0});
}

void addTrees(SceneBuilder* builder) {
  const auto slim = addVariants(4, builder, [](Random* random) {
    TreeStyle style;
    style.height_m = random->uniform(3.0, 6.5);
    style.trunk_radius_m = random->uniform(0.04, 0.09);
    style.bare_m = random->uniform(0.6, 1.8);
    style.crown_radius_m = style.height_m * random->uniform(0.16, 0.3);
    style.branches = 7 + random->below(5);
    style.leaves_per_m3 = random->uniform(80.0, 220.0);
    style.leaf_radius_m = 0.032;
    return makeCrownTree(style, random);
  });
  const auto saplings = addVariants(
      3, builder, [](Random* random) { return makeSapling(random->uniform(1.0, 2.4), random); });
  const auto bare = addVariants(2, builder, [](Random* random) {
    TreeStyle style;
    style.height_m = random->uniform(3.0, 6.0);
    style.trunk_radius_m = random->uniform(0.06, 0.12);
    style.bare_m = 1.0;
    style.crown_radius_m = 1.3;
    style.branches = 8;
    style.leaves_per_m3 = 0.0;
    return makeCrownTree(style, random);
  });
  builder->scatter({slim, 320, 0.8, 1.2, 1.2, 3.0});
  builder->scatter({bare, 110, 0.8, 1.2, 1.2, 3.0});
  builder->scatter({saplings, 700, 0.7, 1.3, 0.5, 2.8});
}

}  // namespace

World makeScrubland(uint64_t seed) {
  Random random(streamSeed(seed, {5}));
  const CircuitShape shape = roughTrack(&random);
  const GroundStyle style{{{6.5, 34.0, 1.0}, {0.9, 10.0, 0.8}, {0.22, 2.8, 0.35}, {0.05, 0.8, 0.5}},
                          [](double track_m, double noise) {
                            if (track_m < 1.2) return Material::kTrack;
                            return noise > 0.25 ? Material::kMeadow : Material::kSoil;
                          },
                          [seed](const TrackPlace& place) { return gulliesAndBanks(place, seed); }};
  SceneBuilder builder(shape, style, seed);
  builder.keepClear(2.0 * kClearHeightM);
  const double length = builder.circuit().length();
  const double fence = random.uniform(0.0, 0.3);
  addFenceAlongTrack(fence * length, (fence + 0.3) * length, random.uniform(3.5, 6.0),
                     FenceKind::kWire, &builder);
  addFenceAlongTrack(0.65 * length, 0.85 * length, -random.uniform(3.5, 6.0),
                     random.chance(0.5) ? FenceKind::kWire : FenceKind::kRails, &builder);
  addPowerLine({-90.0, random.uniform(-30.0, 30.0)}, {90.0, random.uniform(-30.0, 30.0)}, 20.0, 8.5,
               &builder);
  const auto rocks = addVariants(
      6, &builder, [](Random* maker) { return makeRock(maker->uniform(0.12, 0.9), maker); });
  const auto logs = addVariants(2, &builder, [](Random* maker) {
    const double log_m = maker->uniform(1.5, 4.0);
    return makeLog(log_m, maker->uniform(0.07, 0.16), maker);
  });
  builder.scatter({rocks, 900, 0.5, 1.2, 0.5, 2.6});
  builder.scatter({logs, 90, 0.8, 1.1, 1.2, 2.6});
  addTrees(&builder);
  addBushes(&builder);
  addGrasses(&builder);
  return builder.finish();
}

}  // namespace ladar_perception::sim
