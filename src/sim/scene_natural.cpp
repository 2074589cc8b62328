// SPDX-License-Identifier: BSD-3-Clause
// Forest and meadow with tall grass.
#include "scene_builder.h"
#include "vegetation.h"

namespace ladar_perception::sim {
namespace {

constexpr double kTwoPi = 6.283185307179586;

CircuitShape windingTrack(uint64_t seed) {
  Random random(streamSeed(seed, {2}));
  CircuitShape shape;
  shape.radius_x_m = random.uniform(52.0, 58.0);
  shape.radius_y_m = random.uniform(44.0, 50.0);
  shape.wave2 = random.uniform(0.04, 0.10);
  shape.wave3 = random.uniform(0.05, 0.11);
  shape.wave2_phase_rad = random.uniform(0.0, kTwoPi);
  shape.wave3_phase_rad = random.uniform(0.0, kTwoPi);
  return shape;
}

void addForestTrees(SceneBuilder* builder) {
  const auto broad = addVariants(4, builder, [](Random* random) {
    const Material bark = random->chance(0.3) ? Material::kBirchBark : Material::kBark;
    const double height = random->uniform(7.0, 13.0);
    return makeBroadleaf(height, height * random->uniform(0.014, 0.022), bark, random);
  });
  const auto conifers = addVariants(3, builder, [](Random* random) {
    const double height = random->uniform(7.0, 13.0);
    return makeConifer(height, height * random->uniform(0.013, 0.018), random);
  });
  const auto saplings = addVariants(
      4, builder, [](Random* random) { return makeSapling(random->uniform(1.4, 3.2), random); });
  builder->scatter({broad, 1100, 0.75, 1.3, 1.9, 2.6});
  builder->scatter({conifers, 700, 0.75, 1.3, 1.9, 2.6, 52.0, 30.0});
  builder->scatter({saplings, 1800, 0.7, 1.3, 0.5, 2.6});
}

void addUndergrowth(SceneBuilder* builder) {
  const auto bushes = addVariants(4, builder, [](Random* random) {
    const double height = random->uniform(0.8, 1.8);
    return makeBush(height, height * random->uniform(0.5, 0.8), random);
  });
  const auto dead = addVariants(
      3, builder, [](Random* random) { return makeDeadBush(random->uniform(0.8, 1.6), random); });
  const auto ferns = addVariants(
      3, builder, [](Random* random) { return makeFern(random->uniform(0.3, 0.6), random); });
  const auto tufts = addVariants(3, builder, [](Random* random) {
    return makeGrassTuft(random->uniform(0.2, 0.4), 0.2, 26, 0.3, random);
  });
  builder->scatter({bushes, 1500, 0.7, 1.2, 0.5, 2.6, 52.0, 18.0});
  builder->scatter({dead, 450, 0.7, 1.2, 0.4, 2.6});
  builder->scatter({ferns, 12000, 0.7, 1.3, 0.0, 2.2, 40.0, 9.0});
  builder->scatter({tufts, 20000, 0.7, 1.3, 0.0, 1.8, 35.0, 7.0});
}

void addGrass(SceneBuilder* builder) {
  const auto tufts = addVariants(6, builder, [](Random* random) {
    const double height = random->uniform(0.55, 1.0);
    const double radius = random->uniform(0.2, 0.35);
    return makeGrassTuft(height, radius, 44, random->uniform(0.1, 0.7), random);
  });
  const auto low = addVariants(3, builder, [](Random* random) {
    return makeGrassTuft(random->uniform(0.25, 0.4), 0.3, 40, 0.4, random);
  });
  builder->scatter({tufts, 90000, 0.7, 1.1, 0.0, 1.8, 45.0, 13.0});
  builder->scatter({low, 60000, 0.7, 1.2, 0.0, 1.6, 30.0});
}

}  // namespace

World makeForest(uint64_t seed) {
  const GroundStyle style{{{3.0, 45.0, 1.0}, {0.5, 11.0, 0.7}, {0.14, 2.6, 0.25}, {0.04, 0.7, 0.4}},
                          [](double track_m, double noise) {
                            if (track_m < 1.3) return Material::kTrack;
                            return noise > 0.35 ? Material::kMeadow : Material::kForestFloor;
                          }};
  SceneBuilder builder(windingTrack(seed), style, seed);
  const auto logs = addVariants(3, &builder, [](Random* random) {
    const double length = random->uniform(2.5, 6.0);
    return makeLog(length, random->uniform(0.1, 0.22), random);
  });
  const auto stumps = addVariants(3, &builder, [](Random* random) { return makeStump(random); });
  const auto rocks = addVariants(
      3, &builder, [](Random* random) { return makeRock(random->uniform(0.3, 0.7), random); });
  builder.scatter({logs, 220, 0.8, 1.1, 1.5, 2.6});
  builder.scatter({stumps, 250, 0.8, 1.2, 0.5, 2.6});
  builder.scatter({rocks, 220, 0.5, 1.3, 0.8, 2.6});
  addForestTrees(&builder);
  addUndergrowth(&builder);
  return builder.finish();
}

World makeTallGrass(uint64_t seed) {
  const GroundStyle style{{{2.0, 55.0, 1.0}, {0.35, 9.0, 0.7}, {0.10, 2.0, 0.3}, {0.03, 0.7, 0.5}},
                          [](double track_m, double noise) {
                            if (track_m < 1.2) return Material::kTrack;
                            return noise > 0.2 ? Material::kSoil : Material::kMeadow;
                          }};
  SceneBuilder builder(windingTrack(seed), style, seed);
  const auto trees = addVariants(2, &builder, [](Random* random) {
    return makeBroadleaf(random->uniform(6.0, 9.0), 0.16, Material::kBark, random);
  });
  const auto saplings = addVariants(
      3, &builder, [](Random* random) { return makeSapling(random->uniform(1.2, 2.6), random); });
  const auto bushes = addVariants(3, &builder, [](Random* random) {
    const double height = random->uniform(0.9, 1.7);
    return makeBush(height, height * random->uniform(0.5, 0.9), random);
  });
  const auto dead = addVariants(
      2, &builder, [](Random* random) { return makeDeadBush(random->uniform(0.9, 1.6), random); });
  const auto stakes = addVariants(1, &builder, [](Random*) {
    return Model{makeCylinder({0, 0, -0.4}, {0, 0, 1.6}, 0.045, Material::kPost)};
  });
  const auto rocks = addVariants(
      3, &builder, [](Random* random) { return makeRock(random->uniform(0.3, 0.8), random); });
  builder.scatter({trees, 110, 0.8, 1.2, 3.0, 3.0});
  builder.scatter({saplings, 350, 0.8, 1.3, 0.8, 2.6});
  builder.scatter({bushes, 260, 0.7, 1.2, 0.9, 2.6});
  builder.scatter({dead, 200, 0.7, 1.2, 0.5, 2.6});
  builder.scatter({stakes, 300, 0.8, 1.2, 0.3, 2.6});
  builder.scatter({rocks, 160, 0.6, 1.3, 0.9, 2.6});
  addGrass(&builder);
  return builder.finish();
}

}  // namespace ladar_perception::sim
