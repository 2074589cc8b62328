// SPDX-License-Identifier: BSD-3-Clause
// A block of buildings with a street around it.
#include <Eigen/Geometry>
#include <cmath>

#include "scene_builder.h"
#include "structures.h"
#include "vegetation.h"

namespace ladar_perception::sim {
namespace {

constexpr double kPi = 3.141592653589793;

struct Site {
  BuildingStyle style;
  Eigen::Vector2d p_world;
  double yaw_rad;
};

/// Stairs to the door of each side.
void addEntrances(const Site& site, SceneBuilder* builder) {
  const uint32_t stairs = builder->addModel(makeStairs(1.8, site.style.plinth_m));
  for (int side = 0; side < 4; ++side) {
    const bool along_x = side % 2 == 0;
    const double length = along_x ? site.style.width_m : site.style.length_m;
    const double reach = 0.5 * (along_x ? site.style.length_m : site.style.width_m);
    const double outward_rad = site.yaw_rad + 0.5 * kPi * side;
    const Eigen::Vector2d door =
        site.p_world + Eigen::Rotation2D<double>(outward_rad) *
                           Eigen::Vector2d(reach + 0.05, -doorOffset(length, site.style.bay_m));
    builder->place(stairs, door, outward_rad + kPi);
    builder->claim(door, 2.5);
  }
}

void addCampusBuildings(SceneBuilder* builder) {
  const std::vector<Site> sites = {{{36.0, 15.0, 2, Material::kBrick, 0.64}, {-13.0, 6.0}, 0.0},
                                   {{14.0, 30.0, 2, Material::kPlaster, 0.48}, {25.0, -2.0}, 0.05},
                                   {{44.0, 14.0, 3, Material::kPlaster, 0.64}, {6.0, 57.0}, 0.0},
                                   {{16.0, 36.0, 2, Material::kBrick, 0.32}, {-73.0, -6.0}, -0.08},
                                   {{30.0, 16.0, 2, Material::kBrick, 0.64}, {20.0, -58.0}, 0.1}};
  for (const Site& site : sites) {
    builder->place(builder->addModel(makeBuilding(site.style)), site.p_world, site.yaw_rad);
    const Eigen::Rotation2D<double> turn(site.yaw_rad);
    const Eigen::Vector2d half(0.5 * site.style.length_m, 0.5 * site.style.width_m);
    for (double x = -half.x(); x <= half.x(); x += 3.0) {
      for (double y = -half.y(); y <= half.y(); y += 3.0) {
        builder->claim(site.p_world + turn * Eigen::Vector2d(x, y), 3.0);
      }
    }
    addEntrances(site, builder);
  }
}

void addKerbs(SceneBuilder* builder) {
  const double length = builder->circuit().length();
  for (double s = 0.0; s < length; s += 1.0) {
    for (const double left : {-3.3, 3.3}) {
      if (std::fmod(s, 40.0) < 5.0) continue;  // driveways
      const Eigen::Vector2d p = builder->circuit().beside(s, left);
      builder->fixed().push_back(makeBox(builder->at(p, -0.07), {1.06, 0.16, 0.42},
                                         builder->circuit().heading(s), Material::kKerb));
    }
  }
}

void addStreetFurniture(SceneBuilder* builder) {
  const double length = builder->circuit().length();
  const uint32_t lamp = builder->addModel(makeLampPost(4.6));
  const uint32_t sign = builder->addModel(makeSignPost());
  const uint32_t bench = builder->addModel(makeBench());
  const uint32_t stand = builder->addModel(makeBicycleStand(5));
  const auto bicycles = addVariants(3, builder, [](Random* random) { return makeBicycle(random); });
  for (double s = 6.0; s < length; s += 19.0) placeBeside(lamp, s, 4.1, -0.5 * kPi, 0.5, builder);
  for (double s = 14.0; s < length; s += 45.0) placeBeside(sign, s, -4.0, kPi, 0.5, builder);
  for (double s = 22.0; s < length; s += 38.0) placeBeside(bench, s, 8.2, -0.5 * kPi, 1.2, builder);
  for (double s = 32.0; s < length; s += 60.0) {
    placeBeside(stand, s, -6.8, 0.5 * kPi, 2.4, builder);
    for (int i = 0; i < 4; ++i) {
      const double along = 0.75 * (i - 2) + 0.25;
      placeBeside(bicycles[i % 3], s + along, -6.8 + 0.1 * (i % 2), 0.5 * kPi, 0.3, builder);
    }
  }
}

void addParkedCars(SceneBuilder* builder) {
  const auto cars = addVariants(4, builder, [](Random* random) {
    return makeCar(static_cast<CarShape>(random->below(kCarShapes)), random);
  });
  const double length = builder->circuit().length();
  for (double s = 70.0; s < length - 20.0; s += 6.2) {
    if (!builder->random().chance(0.5)) continue;
    if (std::fmod(s, 90.0) > 45.0) continue;
    if (!builder->isFree(builder->circuit().beside(s, -4.6), 1.2)) continue;
    placeBeside(cars[builder->random().below(4)], s, -4.6, 0.0, 2.6, builder);
  }
}

void addCampusGreen(SceneBuilder* builder) {
  const auto trees = addVariants(3, builder, [](Random* random) {
    const double height = random->uniform(5.5, 9.0);
    return makeBroadleaf(height, random->uniform(0.1, 0.19), Material::kBark, random);
  });
  const auto conifers = addVariants(2, builder, [](Random* random) {
    return makeConifer(random->uniform(4.0, 7.0), 0.1, random);
  });
  const auto tufts = addVariants(3, builder, [](Random* random) {
    return makeGrassTuft(random->uniform(0.15, 0.35), 0.2, 30, 0.2, random);
  });
  const auto bushes = addVariants(4, builder, [](Random* random) {
    const double height = random->uniform(0.7, 1.6);
    return makeBush(height, height * random->uniform(0.5, 0.8), random);
  });
  builder->scatter({trees, 260, 0.8, 1.2, 2.6, 4.6});
  builder->scatter({conifers, 90, 0.8, 1.2, 2.0, 4.6});
  builder->scatter({bushes, 260, 0.7, 1.1, 0.8, 4.2, 52.0, 20.0});
  builder->scatter({tufts, 9000, 0.6, 1.2, 0.0, 8.5, 40.0, 10.0});
}

}  // namespace

World makeCampus(uint64_t seed) {
  const GroundStyle style{{{0.5, 60.0, 1.0}, {0.06, 7.0, 0.1}, {0.015, 0.8, 0.1}},
                          [](double track_m, double) {
                            if (track_m < 3.3) return Material::kAsphalt;
                            if (track_m < 3.7) return Material::kConcrete;
                            if (track_m > 5.8 && track_m < 7.8) return Material::kConcrete;
                            return Material::kLawn;
                          }};
  SceneBuilder builder({50.0, 36.0, 3.0}, style, seed);
  const double length = builder.circuit().length();
  addCampusBuildings(&builder);
  addKerbs(&builder);
  addStreetFurniture(&builder);
  addParkedCars(&builder);
  addHedgeAlongTrack(0.02 * length, 0.10 * length, -9.0, 1.2, &builder);
  addHedgeAlongTrack(0.55 * length, 0.66 * length, 9.5, 0.9, &builder);
  addCableAlongTrack(0.30 * length, 0.60 * length, -9.2, 3.2, &builder);
  addPowerLine({-88.0, -52.0}, {88.0, -46.0}, 22.0, 4.8, &builder);
  addFenceAlongTrack(0.70 * length, 0.82 * length, -9.5, FenceKind::kRails, &builder);
  addCampusGreen(&builder);
  return builder.finish();
}

}  // namespace ladar_perception::sim
