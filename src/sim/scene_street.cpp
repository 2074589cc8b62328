// SPDX-License-Identifier: BSD-3-Clause
// A street through a town on hills: houses and blocks behind gardens, trees, wires, parked cars.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "scene_builder.h"
#include "street_plan.h"
#include "structures.h"
#include "vegetation.h"

namespace ladar_perception::sim {
namespace {

constexpr double kPi = 3.141592653589793;

StreetStock fillStock(SceneBuilder* builder) {
  StreetStock stock;
  for (int i = 0; i < kCarShapes; ++i) {
    for (int k = 0; k < 2; ++k) {
      stock.cars.push_back(
          builder->addModel(makeCar(static_cast<CarShape>(i), &builder->random())));
    }
  }
  stock.trees = addVariants(5, builder, [](Random* random) {
    TreeStyle style;
    style.height_m = random->uniform(9.0, 14.5);
    style.trunk_radius_m = style.height_m * random->uniform(0.014, 0.028);
    style.bare_m = random->uniform(2.9, 3.8);
    style.crown_radius_m = style.height_m * random->uniform(0.26, 0.40);
    style.branches = 12 + random->below(7);
    style.leaves_per_m3 = random->uniform(250.0, 700.0);
    return makeCrownTree(style, random);
  });
  stock.young_trees = addVariants(3, builder, [](Random* random) {
    TreeStyle style;
    style.height_m = random->uniform(4.5, 7.0);
    style.trunk_radius_m = random->uniform(0.05, 0.09);
    style.bare_m = random->uniform(1.5, 2.1);
    style.crown_radius_m = style.height_m * random->uniform(0.2, 0.32);
    style.branches = 8 + random->below(5);
    style.leaf_radius_m = 0.035;
    return makeCrownTree(style, random);
  });
  stock.conifers = addVariants(2, builder, [](Random* random) {
    return makeConifer(random->uniform(3.0, 7.0), 0.1, random);
  });
  stock.bushes = addVariants(6, builder, [](Random* random) {
    const double height = random->uniform(0.5, 1.7);
    return makeBush(height, height * random->uniform(0.45, 0.85), random);
  });
  stock.flowers = addVariants(
      3, builder, [](Random* random) { return makeFern(random->uniform(0.2, 0.4), random); });
  stock.tufts = addVariants(3, builder, [](Random* random) {
    return makeGrassTuft(random->uniform(0.10, 0.28), 0.25, 34, 0.2, random);
  });
  return stock;
}

void addKerbs(const StreetSection& section, SceneBuilder* builder) {
  const double length = builder->circuit().length();
  for (double s = 0.0; s < length; s += 1.0) {
    for (const double side : {-1.0, 1.0}) {
      const double low = std::fmod(s + 11.0 * side + 11.0, 37.0) < 4.0 ? 0.11 : 0.0;  // driveways
      const Eigen::Vector2d p = builder->circuit().beside(s, side * (section.kerb_m + 0.05));
      const Eigen::Vector3d road =
          builder->at(builder->circuit().beside(s, side * (section.kerb_m - 0.3)));
      builder->fixed().push_back(makeBox({p.x(), p.y(), road.z() - 0.08 - low}, {1.06, 0.18, 0.44},
                                         builder->circuit().heading(s), Material::kKerb));
    }
  }
}

void addTrafficAndVerge(const StreetSection& section, const StreetStock& stock,
                        SceneBuilder* builder) {
  Random& random = builder->random();
  const double length = builder->circuit().length();
  const uint32_t lamp = builder->addModel(makeLampPost(7.5));
  const uint32_t sign = builder->addModel(makeSignPost());
  const std::array<uint32_t, 4> small = {
      builder->addModel(makeHydrant()), builder->addModel(makeLitterBin()),
      builder->addModel(makeParkingMeter()), builder->addModel(makeBench())};
  for (const double side : {-1.0, 1.0}) {
    for (double s = 3.0; s < length - 3.0; s += random.uniform(5.4, 9.0)) {
      // Rows of cars and stretches without.
      if (valueNoise(s / 25.0, 3.0 * side, 77) < -0.15) continue;
      const double turn = (side > 0.0 ? kPi : 0.0) + random.normal(0.0, 0.02);
      placeBeside(anyOf(stock.cars, builder), s, side * (section.cars_m + random.normal(0.0, 0.08)),
                  turn, 2.4, builder);
    }
    for (double s = 11.0 + 9.0 * side; s < length - 5.0; s += random.uniform(24.0, 34.0)) {
      placeBeside(lamp, s, side * (section.kerb_m + 0.5), -0.5 * kPi * side, 0.6, builder);
    }
    for (double s = 5.0; s < length - 5.0; s += random.uniform(8.0, 22.0)) {
      const bool is_sign = random.chance(0.6);
      const uint32_t model = is_sign ? sign : small[random.below(4)];
      const double yaw = (side > 0.0 ? 0.0 : kPi);
      placeBeside(model, s, side * (section.kerb_m + 0.6), yaw, 0.5, builder);
    }
    for (double s = 2.0; s < length; s += random.uniform(7.0, 15.0)) {
      if (valueNoise(s / 40.0, 9.0 * side, 78) < -0.2) continue;
      const bool young = random.chance(0.3);
      plant(anyOf(young ? stock.young_trees : stock.trees, builder), s,
            side * (section.kerb_m + 0.95), 0.5, random.uniform(0.9, 1.15), builder);
    }
  }
}

/// A utility pole of a street and the direction across it.
struct Pole {
  Eigen::Vector3d foot;
  Eigen::Vector3d across;

  Eigen::Vector3d at(double z, double y) const {
    return foot + y * across + z * Eigen::Vector3d::UnitZ();
  }
};

std::vector<Pole> addPoles(double left_m, double height_m, SceneBuilder* builder) {
  Random& random = builder->random();
  const double length = builder->circuit().length();
  const auto kinds = addVariants(4, builder, [&](Random* maker) {
    UtilityPoleStyle style;
    style.height_m = height_m;
    style.radius_m = maker->uniform(0.13, 0.20);
    style.cross_arms = 1 + maker->below(2);
    style.transformer = maker->chance(0.4);
    style.lamp_arm_m = maker->chance(0.5) ? 1.8 : 0.0;
    return makeStreetPole(style);
  });
  std::vector<Pole> poles;
  for (double s = 6.0; s < 0.92 * length; s += random.uniform(24.0, 34.0)) {
    placeBeside(anyOf(kinds, builder), s, left_m, left_m > 0.0 ? kPi : 0.0, 0.6, builder);
    const double h = builder->circuit().heading(s);
    poles.push_back({builder->at(builder->circuit().beside(s, left_m)),
                     Eigen::Vector3d(-std::sin(h), std::cos(h), 0.0)});
    if (!random.chance(0.25)) continue;
    const Eigen::Vector2d peg = builder->circuit().beside(s + 3.0, left_m);
    builder->hangWire(poles.back().at(0.7 * height_m, 0.0), builder->at(peg), 0.0, 0.008);
  }
  return poles;
}

/// Single wires on the cross-arms, bundles below them, and lines from the poles to the houses.
void addWires(const StreetPlan& plan, double side, double height_m, SceneBuilder* builder) {
  Random& random = builder->random();
  const double left = side * (plan.section.kerb_m + 0.45);
  const std::vector<Pole> poles = addPoles(left, height_m, builder);
  struct Wire {
    double z;
    double y;
    double radius_m;
    double sag_m;
  };
  std::vector<Wire> wires;
  const int singles = 2 + random.below(3);
  for (int i = 0; i < singles; ++i) {
    wires.push_back({height_m + 0.15, 1.8 * i / (singles - 1) - 0.9, 0.006, 0.5});
  }
  const double mains_m = random.uniform(6.8, 8.0);
  const double phone_m = random.uniform(5.0, 6.4);
  const auto addBundle = [&](double z, int count) {
    for (int i = 0; i < count; ++i) {
      const double up = z + random.normal(0.0, 0.06);
      const double beside = random.normal(0.0, 0.13);
      const double radius = random.uniform(0.006, 0.026);
      wires.push_back({up, beside, radius, random.uniform(0.3, 0.9)});
    }
  };
  addBundle(mains_m, 2 + random.below(3));
  addBundle(phone_m, 2 + random.below(5));
  if (random.chance(0.5)) addBundle(phone_m - 0.9, 1 + random.below(2));
  for (std::size_t i = 0; i + 1 < poles.size(); ++i) {
    for (const Wire& wire : wires) {
      // Slack differs from span to span.
      const double sag = wire.sag_m * random.uniform(0.8, 1.2);
      builder->hangWire(poles[i].at(wire.z, wire.y), poles[i + 1].at(wire.z, wire.y), sag,
                        wire.radius_m);
    }
  }
  for (const Lot& lot : plan.lots) {
    if (lot.kind != LotKind::kHouse || poles.empty()) continue;
    const Eigen::Vector3d house =
        builder->at(builder->circuit().beside(lot.middle(), lot.side * (lot.setback_m + 2.2)), 5.2);
    const auto nearest =
        std::min_element(poles.begin(), poles.end(), [&](const Pole& a, const Pole& b) {
          return (a.foot - house).squaredNorm() < (b.foot - house).squaredNorm();
        });
    if ((nearest->foot - house).norm() > 30.0) continue;
    builder->hangWire(nearest->at(mains_m, 0.1), house, 0.4, 0.010);
  }
}

}  // namespace

World makeStreet(uint64_t seed) {
  const StreetPlan plan = makeStreetPlan(seed);
  Random random(streamSeed(seed, {6}));
  const double hills_m = random.uniform(1.5, 6.0);
  const GroundStyle style{
      {{hills_m, 60.0, 1.0}, {0.10, 9.0, 0.0}, {0.03, 1.1, 0.1}},
      [&plan](double track_m, double noise) { return plan.ground(track_m, noise); },
      [&plan](const TrackPlace& place) { return plan.profile(place); }};
  SceneBuilder builder(plan.shape, style, seed);
  const StreetStock stock = fillStock(&builder);
  addWires(plan, random.chance(0.5) ? 1.0 : -1.0, random.uniform(9.0, 12.0), &builder);
  addTrafficAndVerge(plan.section, stock, &builder);
  buildLots(plan, stock, &builder);
  addKerbs(plan.section, &builder);
  builder.scatter({stock.trees, 60, 0.8, 1.2, 3.0, 22.0});
  builder.scatter({stock.bushes, 120, 0.6, 1.2, 0.8, plan.section.garden_m + 0.5});
  builder.scatter({stock.tufts, 9000, 0.6, 1.3, 0.0, plan.section.garden_m + 0.3, 30.0, 7.0});
  return builder.finish();
}

}  // namespace ladar_perception::sim
