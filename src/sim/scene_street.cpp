// SPDX-License-Identifier: BSD-3-Clause
// A street through a town on hills: houses and blocks behind gardens, trees, wires, parked cars.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "scene_builder.h"
#include "structures.h"
#include "vegetation.h"

namespace ladar_perception::sim {
namespace {

constexpr double kPi = 3.141592653589793;
// Across the street, from its middle: cars park, kerb, verge, walkway, gardens.
constexpr double kCarsM = 4.2;
constexpr double kKerbM = 5.4;
constexpr double kWalkM = 6.9;
constexpr double kGardenM = 8.7;

enum class LotKind { kHouse, kBlock, kPark, kCarPark };

/// A piece of land along one side of the street.
struct Lot {
  double from_m;
  double to_m;
  double side;  ///< 1 left, -1 right
  LotKind kind;
  double rise_m;     ///< of the ground behind the walkway
  double run_m;      ///< over which it rises; a retaining wall if short
  double setback_m;  ///< of the front from the middle of the street

  double middle() const { return 0.5 * (from_m + to_m); }
  bool hasWall() const { return run_m < 0.5 && rise_m > 0.3; }
};

Lot makeLot(double from_m, double side, Random* random) {
  const double dice = random->uniform();
  Lot lot{};
  lot.from_m = from_m;
  lot.side = side;
  lot.kind = dice < 0.55   ? LotKind::kHouse
             : dice < 0.75 ? LotKind::kBlock
             : dice < 0.90 ? LotKind::kPark
                           : LotKind::kCarPark;
  const double width = lot.kind == LotKind::kHouse   ? random->uniform(11.0, 15.0)
                       : lot.kind == LotKind::kBlock ? random->uniform(22.0, 34.0)
                                                     : random->uniform(14.0, 24.0);
  lot.to_m = from_m + width;
  const bool is_raised = lot.kind == LotKind::kHouse || lot.kind == LotKind::kPark;
  lot.rise_m = is_raised ? std::max(0.0, random->uniform(-0.8, 2.4)) : 0.0;
  lot.run_m = random->chance(0.35) ? 0.3 : lot.rise_m / std::tan(random->uniform(0.3, 0.6)) + 0.5;
  lot.setback_m = lot.kind == LotKind::kBlock ? kGardenM + random->uniform(0.2, 2.5)
                                              : kGardenM + random->uniform(4.5, 8.0);
  return lot;
}

std::vector<Lot> layOut(double length_m, Random* random) {
  std::vector<Lot> lots;
  for (const double side : {-1.0, 1.0}) {
    for (double s = 0.0; s < length_m - 14.0; s = lots.back().to_m) {
      lots.push_back(makeLot(s, side, random));
    }
  }
  return lots;
}

/// Height over the layers of hills: camber, kerb, and the lots' banks.
double profileAt(const TrackPlace& place, const std::vector<Lot>& lots) {
  const double out = std::abs(place.left_m);
  if (out < kKerbM) return -0.025 * out;
  double height = -0.025 * kKerbM + 0.14;
  if (out < kGardenM) return height + 0.02 * (out - kKerbM);
  height += 0.02 * (kGardenM - kKerbM);
  for (const Lot& lot : lots) {
    if ((lot.side > 0.0) != (place.left_m > 0.0)) continue;
    const double inside = std::min(place.s_m - lot.from_m, lot.to_m - place.s_m);
    if (inside < -0.5) continue;
    // Neighbours of different height meet on a short slope; behind the houses all is level again.
    const double share = std::clamp(inside + 0.5, 0.0, 1.0) *
                         std::clamp((29.0 - out) / 8.0, 0.0, 1.0) *
                         std::clamp((out - kGardenM - 0.2) / lot.run_m, 0.0, 1.0);
    height += share * lot.rise_m;
  }
  return height;
}

Material groundAt(double track_m, double noise) {
  if (track_m < kKerbM) return Material::kAsphalt;
  if (track_m > kWalkM && track_m < kGardenM) return Material::kConcrete;
  if (track_m < kWalkM) return noise > 0.3 ? Material::kConcrete : Material::kLawn;
  return noise > 0.45 ? Material::kSoil : Material::kLawn;
}

/// Models that are put down many times.
struct Stock {
  std::vector<uint32_t> cars;
  std::vector<uint32_t> trees;
  std::vector<uint32_t> young_trees;
  std::vector<uint32_t> conifers;
  std::vector<uint32_t> bushes;
  std::vector<uint32_t> flowers;
  std::vector<uint32_t> tufts;
  std::vector<uint32_t> hedges;
};

uint32_t anyOf(const std::vector<uint32_t>& models, SceneBuilder* builder) {
  return models[builder->random().below(static_cast<int>(models.size()))];
}

Stock fillStock(SceneBuilder* builder) {
  Stock stock;
  for (int i = 0; i < kCarShapes; ++i) {
    for (int k = 0; k < 2; ++k) {
      stock.cars.push_back(
          builder->addModel(makeCar(static_cast<CarShape>(i), &builder->random())));
    }
  }
  stock.trees = addVariants(5, builder, [](Random* random) {
    TreeStyle style;
    style.height_m = random->uniform(9.0, 14.5);
    style.trunk_radius_m = style.height_m * random->uniform(0.012, 0.022);
    style.bare_m = random->uniform(2.2, 3.4);
    style.crown_radius_m = style.height_m * random->uniform(0.24, 0.36);
    style.branches = 10 + random->below(6);
    style.leaves_per_m3 = random->uniform(120.0, 320.0);
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

/// Puts a model beside the track if nothing is there yet.
void plant(uint32_t model, double s_m, double left_m, double claim_m, double scale,
           SceneBuilder* builder) {
  const Eigen::Vector2d p = builder->circuit().beside(s_m, left_m);
  const double yaw = builder->random().uniform(0.0, 2.0 * kPi);
  if (!builder->isFree(p, claim_m)) return;
  builder->place(model, p, yaw, scale);
  builder->claim(p, claim_m);
}

void claimBox(const Eigen::Vector2d& middle, double yaw_rad, double length_m, double width_m,
              SceneBuilder* builder) {
  const Eigen::Vector2d along(std::cos(yaw_rad), std::sin(yaw_rad));
  const Eigen::Vector2d across(-along.y(), along.x());
  for (double x = -0.5 * length_m; x <= 0.5 * length_m; x += 2.0) {
    for (double y = -0.5 * width_m; y <= 0.5 * width_m; y += 2.0) {
      builder->claim(middle + x * along + y * across, 1.6);
    }
  }
}

BuildingStyle styleOf(const Lot& lot, Random* random) {
  BuildingStyle style;
  const bool is_house = lot.kind == LotKind::kHouse;
  style.seed = random->bits();
  style.length_m = lot.to_m - lot.from_m - (is_house ? random->uniform(2.0, 4.0) : 1.0);
  style.width_m = is_house ? random->uniform(9.0, 12.0) : random->uniform(10.0, 14.0);
  style.floors = is_house ? 2 : 3 + random->below(5);
  style.wall = random->chance(0.6) ? Material::kBrick : Material::kPlaster;
  style.plinth_m = random->uniform(0.3, 0.9);
  style.floor_m = random->uniform(2.8, 3.6);
  style.bay_m = random->uniform(2.2, 4.2);
  style.window_width_m = style.bay_m * random->uniform(0.3, 0.65);
  style.sill_m = random->uniform(0.5, 1.0);
  style.lintel_m = style.floor_m - random->uniform(0.4, 0.8);
  style.recess_m = random->uniform(0.08, 0.32);
  style.ledge_m = random->chance(0.6) ? random->uniform(0.05, 0.25) : 0.0;
  style.pier_m = !is_house && random->chance(0.4) ? random->uniform(0.08, 0.35) : 0.0;
  style.blank_share = random->uniform(0.0, 0.35);
  style.oriel_share = random->chance(0.4) ? 0.35 : 0.0;
  style.gable_pitch_rad = is_house && random->chance(0.75) ? random->uniform(0.45, 0.8) : 0.0;
  style.porch_m = is_house && random->chance(0.65) ? random->uniform(1.6, 2.4) : 0.0;
  return style;
}

/// Steps from the walkway up to the door.
void addSteps(const Lot& lot, double front_m, double plinth_m, SceneBuilder* builder) {
  const double s = lot.middle() + 0.8;
  const auto stairsTo = [&](double out_m, double rise_m) {
    if (rise_m < 0.2) return;
    const Eigen::Vector2d p = builder->circuit().beside(s, lot.side * out_m);
    const double outward = builder->circuit().heading(s) + lot.side * 0.5 * kPi;
    builder->place(builder->addModel(makeStairs(1.5, rise_m)), p, outward);
    builder->claim(p, 1.6);
  };
  stairsTo(front_m, plinth_m);
  if (lot.hasWall()) stairsTo(kGardenM + 0.3, lot.rise_m);
}

/// The building of a lot, unless another is in the way (inside a bend). Returns whether it stands.
bool addHouse(const Lot& lot, SceneBuilder* builder) {
  const BuildingStyle style = styleOf(lot, &builder->random());
  const double s = lot.middle();
  const double out = lot.setback_m + style.porch_m + 0.5 * style.width_m;
  const Eigen::Vector2d p = builder->circuit().beside(s, lot.side * out);
  const double yaw = builder->circuit().heading(s) + (lot.side > 0.0 ? kPi : 0.0);
  for (const double x : {-0.5, 0.0, 0.5}) {
    for (const double y : {-0.5, 0.0, 0.5}) {
      const Eigen::Vector2d corner =
          p + Eigen::Rotation2Dd(yaw) * Eigen::Vector2d(x * style.length_m, y * style.width_m);
      const double track_m = builder->circuit().distanceTo(corner.x(), corner.y());
      if (!builder->isFree(corner, 1.0) || track_m < kGardenM) return false;
    }
  }
  builder->place(builder->addModel(makeBuilding(style)), p, yaw);
  addSteps(lot, lot.setback_m, style.plinth_m, builder);
  claimBox(p, yaw, style.length_m, style.width_m, builder);
  return true;
}

void addRetainingWall(const Lot& lot, SceneBuilder* builder) {
  if (!lot.hasWall()) return;
  for (double s = lot.from_m + 0.5; s < lot.to_m - 0.4; s += 1.0) {
    if (std::abs(s - lot.middle() - 0.8) < 1.3) continue;  // the steps
    const Eigen::Vector2d p = builder->circuit().beside(s, lot.side * (kGardenM + 0.25));
    const Eigen::Vector3d foot =
        builder->at(builder->circuit().beside(s, lot.side * (kGardenM - 0.2)));
    const double height = lot.rise_m + 0.15 + 0.03 * builder->random().uniform();
    builder->fixed().push_back(makeBox({p.x(), p.y(), foot.z() + 0.5 * height - 0.3},
                                       {1.06, 0.35, height + 0.6}, builder->circuit().heading(s),
                                       Material::kStoneWall));
  }
}

/// Hedge, bushes and beds between the walkway and the front.
void addGarden(const Lot& lot, const Stock& stock, SceneBuilder* builder) {
  Random& random = builder->random();
  const double top_m = kGardenM + lot.run_m + 0.4;
  const double hedge_dice = random.uniform();
  if (hedge_dice < 0.45) {
    const double height = random.uniform(0.5, 1.5);
    addHedgeAlongTrack(lot.from_m + 1.0, lot.to_m - 1.5, lot.side * (top_m + 0.5), height, builder);
  } else if (hedge_dice < 0.65) {
    const FenceKind kind = random.chance(0.5) ? FenceKind::kBoards : FenceKind::kRails;
    addFenceAlongTrack(lot.from_m + 0.5, lot.to_m - 0.5, lot.side * (kGardenM + 0.1), kind,
                       builder);
  }
  const double depth = std::max(0.5, lot.setback_m - kGardenM - 0.8);
  const auto bushes = static_cast<int>((lot.to_m - lot.from_m) * random.uniform(0.2, 0.9));
  for (int i = 0; i < bushes; ++i) {
    const double s = random.uniform(lot.from_m, lot.to_m);
    // Most stand before the walls, some on the bank.
    const double u = random.chance(0.6) ? random.uniform(0.75, 1.0) : random.uniform(0.1, 1.0);
    plant(anyOf(stock.bushes, builder), s, lot.side * (kGardenM + 0.5 + u * depth), 0.55,
          random.uniform(0.6, 1.2), builder);
  }
  for (int i = 0; i < 2 * bushes; ++i) {
    const double s = random.uniform(lot.from_m, lot.to_m);
    plant(anyOf(stock.flowers, builder), s, lot.side * (kGardenM + random.uniform(0.4, 3.0)), 0.2,
          random.uniform(0.6, 1.3), builder);
  }
  if (random.chance(0.6)) {
    const bool young = random.chance(0.5);
    plant(anyOf(young ? stock.young_trees : stock.conifers, builder),
          random.uniform(lot.from_m + 2.0, lot.to_m - 2.0), lot.side * (kGardenM + 0.6 * depth),
          1.0, random.uniform(0.7, 1.2), builder);
  }
}

void addPark(const Lot& lot, const Stock& stock, SceneBuilder* builder) {
  Random& random = builder->random();
  for (double s = lot.from_m + 2.0; s < lot.to_m - 1.0; s += random.uniform(2.5, 5.0)) {
    const double left = lot.side * random.uniform(kGardenM + 1.5, 24.0);
    const double dice = random.uniform();
    const auto& kind = dice < 0.6 ? stock.trees : dice < 0.8 ? stock.young_trees : stock.conifers;
    plant(anyOf(kind, builder), s, left, 1.6, random.uniform(0.75, 1.15), builder);
  }
  for (int i = 0; i < 14; ++i) {
    plant(anyOf(stock.bushes, builder), random.uniform(lot.from_m, lot.to_m),
          lot.side * random.uniform(kGardenM + 0.8, 22.0), 0.6, random.uniform(0.5, 1.3), builder);
  }
}

void addCarPark(const Lot& lot, const Stock& stock, SceneBuilder* builder) {
  Random& random = builder->random();
  for (const double out : {kGardenM + 3.5, kGardenM + 13.0}) {
    for (double s = lot.from_m + 2.0; s < lot.to_m - 1.5; s += 2.8) {
      const Eigen::Vector2d p = builder->circuit().beside(s, lot.side * out);
      if (random.chance(0.35) || !builder->isFree(p, 1.2)) continue;
      const double turn = 0.5 * kPi + (random.chance(0.5) ? kPi : 0.0) + random.normal(0.0, 0.03);
      placeBeside(anyOf(stock.cars, builder), s, lot.side * out, turn, 1.3, builder);
    }
  }
}

void addKerbs(SceneBuilder* builder) {
  const double length = builder->circuit().length();
  for (double s = 0.0; s < length; s += 1.0) {
    for (const double side : {-1.0, 1.0}) {
      const double low = std::fmod(s + 11.0 * side + 11.0, 37.0) < 4.0 ? 0.11 : 0.0;  // driveways
      const Eigen::Vector2d p = builder->circuit().beside(s, side * (kKerbM + 0.05));
      const Eigen::Vector3d road = builder->at(builder->circuit().beside(s, side * (kKerbM - 0.3)));
      builder->fixed().push_back(makeBox({p.x(), p.y(), road.z() - 0.08 - low}, {1.06, 0.18, 0.44},
                                         builder->circuit().heading(s), Material::kKerb));
    }
  }
}

void addTrafficAndVerge(const Stock& stock, SceneBuilder* builder) {
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
      placeBeside(anyOf(stock.cars, builder), s, side * (kCarsM + random.normal(0.0, 0.08)), turn,
                  2.4, builder);
    }
    for (double s = 11.0 + 9.0 * side; s < length - 5.0; s += random.uniform(24.0, 34.0)) {
      placeBeside(lamp, s, side * (kKerbM + 0.5), -0.5 * kPi * side, 0.6, builder);
    }
    for (double s = 5.0; s < length - 5.0; s += random.uniform(8.0, 22.0)) {
      const bool is_sign = random.chance(0.6);
      const uint32_t model = is_sign ? sign : small[random.below(4)];
      const double yaw = (side > 0.0 ? 0.0 : kPi);
      placeBeside(model, s, side * (kKerbM + 0.6), yaw, 0.5, builder);
    }
    for (double s = 2.0; s < length; s += random.uniform(7.0, 15.0)) {
      if (valueNoise(s / 40.0, 9.0 * side, 78) < -0.2) continue;
      const bool young = random.chance(0.3);
      plant(anyOf(young ? stock.young_trees : stock.trees, builder), s, side * (kKerbM + 0.95), 0.5,
            random.uniform(0.8, 1.1), builder);
    }
  }
}

/// Wires at two heights along the street, and lines from the poles to the houses.
void addWires(const std::vector<Lot>& lots, double side, double height_m, SceneBuilder* builder) {
  Random& random = builder->random();
  const uint32_t pole = builder->addModel(makeUtilityPole(height_m));
  const double length = builder->circuit().length();
  const double left = side * (kKerbM + 0.45);
  struct Pole {
    Eigen::Vector3d foot;
    Eigen::Vector3d across;

    Eigen::Vector3d at(double z, double y) const {
      return foot + y * across + z * Eigen::Vector3d::UnitZ();
    }
  };
  std::vector<Pole> poles;
  for (double s = 6.0; s < 0.92 * length; s += random.uniform(24.0, 34.0)) {
    placeBeside(pole, s, left, 0.0, 0.6, builder);
    const double h = builder->circuit().heading(s);
    poles.push_back({builder->at(builder->circuit().beside(s, left)),
                     Eigen::Vector3d(-std::sin(h), std::cos(h), 0.0)});
  }
  const double phone_m = random.uniform(5.0, 6.2);
  const double mains_m = random.uniform(6.6, 7.8);
  for (std::size_t i = 0; i + 1 < poles.size(); ++i) {
    const auto hang = [&](double z, double y, double sag_m, double radius_m) {
      builder->hangWire(poles[i].at(z, y), poles[i + 1].at(z, y), sag_m, radius_m);
    };
    for (const double y : {-0.9, 0.0, 0.9}) hang(height_m + 0.12, y, 0.5, 0.006);
    hang(mains_m, 0.12, 0.55, 0.016);
    hang(phone_m, 0.14, 0.5, 0.024);
    hang(phone_m + 0.28, 0.13, 0.45, 0.014);
    if (i % 3 != 2) hang(phone_m - 0.3, 0.12, 0.6, 0.018);
  }
  for (const Lot& lot : lots) {
    if (lot.kind != LotKind::kHouse || lot.side != side || poles.empty()) continue;
    const Eigen::Vector3d house =
        builder->at(builder->circuit().beside(lot.middle(), side * (lot.setback_m + 2.2)), 5.2);
    const auto nearest =
        std::min_element(poles.begin(), poles.end(), [&](const Pole& a, const Pole& b) {
          return (a.foot - house).squaredNorm() < (b.foot - house).squaredNorm();
        });
    if ((nearest->foot - house).norm() > 24.0) continue;
    builder->hangWire(nearest->at(mains_m, 0.1), house, 0.4, 0.010);
  }
}

}  // namespace

World makeStreet(uint64_t seed) {
  Random random(streamSeed(seed, {3}));
  CircuitShape shape;
  shape.radius_x_m = random.uniform(56.0, 64.0);
  shape.radius_y_m = random.uniform(42.0, 50.0);
  shape.squareness = random.uniform(2.4, 3.2);
  shape.wave3 = random.uniform(0.0, 0.05);
  shape.wave3_phase_rad = random.uniform(0.0, 2.0 * kPi);
  const std::vector<Lot> lots = layOut(Circuit(shape).length(), &random);
  const double hills_m = random.uniform(1.0, 4.5);
  const GroundStyle style{{{hills_m, 60.0, 1.0}, {0.10, 9.0, 0.0}, {0.03, 1.1, 0.1}},
                          groundAt,
                          [&lots](const TrackPlace& place) { return profileAt(place, lots); }};
  SceneBuilder builder(shape, style, seed);
  const Stock stock = fillStock(&builder);
  addWires(lots, random.chance(0.5) ? 1.0 : -1.0, random.uniform(9.0, 11.0), &builder);
  addTrafficAndVerge(stock, &builder);
  for (const Lot& lot : lots) {
    const bool has_house = lot.kind == LotKind::kHouse || lot.kind == LotKind::kBlock;
    if (has_house) addHouse(lot, &builder);
    addRetainingWall(lot, &builder);
  }
  for (const Lot& lot : lots) {
    if (lot.kind == LotKind::kHouse) addGarden(lot, stock, &builder);
    if (lot.kind == LotKind::kPark) addPark(lot, stock, &builder);
    if (lot.kind == LotKind::kCarPark) addCarPark(lot, stock, &builder);
  }
  addKerbs(&builder);
  builder.scatter({stock.trees, 60, 0.8, 1.2, 3.0, 22.0});
  builder.scatter({stock.bushes, 120, 0.6, 1.2, 0.8, kGardenM + 0.5});
  builder.scatter({stock.tufts, 9000, 0.6, 1.3, 0.0, kGardenM + 0.3, 30.0, 7.0});
  return builder.finish();
}

}  // namespace ladar_perception::sim
