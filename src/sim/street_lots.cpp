// SPDX-License-Identifier: BSD-3-Clause
// What stands on the lots of a street: buildings, walls and steps, gardens, parks, car parks.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "street_plan.h"
#include "structures.h"

namespace ladar_perception::sim {
namespace {

constexpr double kPi = 3.141592653589793;

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
void addSteps(const Lot& lot, const StreetSection& section, double front_m, double plinth_m,
              SceneBuilder* builder) {
  const double s = lot.middle() + 0.8;
  const auto stairsTo = [&](double out_m, double rise_m) {
    if (rise_m < 0.2) return;
    const Eigen::Vector2d p = builder->circuit().beside(s, lot.side * out_m);
    const double outward = builder->circuit().heading(s) + lot.side * 0.5 * kPi;
    builder->place(builder->addModel(makeStairs(1.5, rise_m)), p, outward);
    builder->claim(p, 1.6);
  };
  stairsTo(front_m, plinth_m);
  if (lot.hasWall()) stairsTo(section.garden_m + 0.3, lot.rise_m);
}

/// The building of a lot, unless another is in the way (inside a bend). Returns whether it stands.
bool addHouse(const Lot& lot, const StreetSection& section, SceneBuilder* builder) {
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
      if (!builder->isFree(corner, 1.0) || track_m < section.garden_m) return false;
    }
  }
  builder->place(builder->addModel(makeBuilding(style)), p, yaw);
  addSteps(lot, section, lot.setback_m, style.plinth_m, builder);
  claimBox(p, yaw, style.length_m, style.width_m, builder);
  return true;
}

void addRetainingWall(const Lot& lot, const StreetSection& section, SceneBuilder* builder) {
  if (!lot.hasWall()) return;
  for (double s = lot.from_m + 0.5; s < lot.to_m - 0.4; s += 1.0) {
    if (std::abs(s - lot.middle() - 0.8) < 1.3) continue;  // the steps
    const Eigen::Vector2d p = builder->circuit().beside(s, lot.side * (section.garden_m + 0.25));
    const Eigen::Vector3d foot =
        builder->at(builder->circuit().beside(s, lot.side * (section.garden_m - 0.2)));
    const double height = lot.rise_m + 0.15 + 0.03 * builder->random().uniform();
    builder->fixed().push_back(makeBox({p.x(), p.y(), foot.z() + 0.5 * height - 0.3},
                                       {1.06, 0.35, height + 0.6}, builder->circuit().heading(s),
                                       Material::kStoneWall));
  }
}

/// Hedge, bushes and beds between the walkway and the front.
void addGarden(const Lot& lot, const StreetSection& section, const StreetStock& stock,
               SceneBuilder* builder) {
  Random& random = builder->random();
  const double top_m = section.garden_m + lot.run_m + 0.4;
  const double hedge_dice = random.uniform();
  if (hedge_dice < 0.45) {
    const double height = random.uniform(0.5, 1.5);
    addHedgeAlongTrack(lot.from_m + 1.0, lot.to_m - 1.5, lot.side * (top_m + 0.5), height, builder);
  } else if (hedge_dice < 0.65) {
    const FenceKind kind = random.chance(0.5) ? FenceKind::kBoards : FenceKind::kRails;
    addFenceAlongTrack(lot.from_m + 0.5, lot.to_m - 0.5, lot.side * (section.garden_m + 0.1), kind,
                       builder);
  }
  const double depth = std::max(0.5, lot.setback_m - section.garden_m - 0.8);
  const auto bushes = static_cast<int>((lot.to_m - lot.from_m) * random.uniform(0.2, 0.9));
  for (int i = 0; i < bushes; ++i) {
    const double s = random.uniform(lot.from_m, lot.to_m);
    // Most stand before the walls, some on the bank.
    const double u = random.chance(0.6) ? random.uniform(0.75, 1.0) : random.uniform(0.1, 1.0);
    plant(anyOf(stock.bushes, builder), s, lot.side * (section.garden_m + 0.5 + u * depth), 0.55,
          random.uniform(0.6, 1.2), builder);
  }
  for (int i = 0; i < 2 * bushes; ++i) {
    const double s = random.uniform(lot.from_m, lot.to_m);
    plant(anyOf(stock.flowers, builder), s,
          lot.side * (section.garden_m + random.uniform(0.4, 3.0)), 0.2, random.uniform(0.6, 1.3),
          builder);
  }
  if (random.chance(0.6)) {
    const bool young = random.chance(0.5);
    plant(anyOf(young ? stock.young_trees : stock.conifers, builder),
          random.uniform(lot.from_m + 2.0, lot.to_m - 2.0),
          lot.side * (section.garden_m + 0.6 * depth), 1.0, random.uniform(0.7, 1.2), builder);
  }
}

void addPark(const Lot& lot, const StreetSection& section, const StreetStock& stock,
             SceneBuilder* builder) {
  Random& random = builder->random();
  for (double s = lot.from_m + 2.0; s < lot.to_m - 1.0; s += random.uniform(2.5, 5.0)) {
    const double left = lot.side * random.uniform(section.garden_m + 1.5, 24.0);
    const double dice = random.uniform();
    const auto& kind = dice < 0.6 ? stock.trees : dice < 0.8 ? stock.young_trees : stock.conifers;
    plant(anyOf(kind, builder), s, left, 1.6, random.uniform(0.75, 1.15), builder);
  }
  for (int i = 0; i < 14; ++i) {
    plant(anyOf(stock.bushes, builder), random.uniform(lot.from_m, lot.to_m),
          lot.side * random.uniform(section.garden_m + 0.8, 22.0), 0.6, random.uniform(0.5, 1.3),
          builder);
  }
}

void addCarPark(const Lot& lot, const StreetSection& section, const StreetStock& stock,
                SceneBuilder* builder) {
  Random& random = builder->random();
  for (const double out : {section.garden_m + 3.5, section.garden_m + 13.0}) {
    for (double s = lot.from_m + 2.0; s < lot.to_m - 1.5; s += 2.8) {
      const Eigen::Vector2d p = builder->circuit().beside(s, lot.side * out);
      if (random.chance(0.35) || !builder->isFree(p, 1.2)) continue;
      const double turn = 0.5 * kPi + (random.chance(0.5) ? kPi : 0.0) + random.normal(0.0, 0.03);
      placeBeside(anyOf(stock.cars, builder), s, lot.side * out, turn, 1.3, builder);
    }
  }
}

}  // namespace

uint32_t anyOf(const std::vector<uint32_t>& models, SceneBuilder* builder) {
  return models[builder->random().below(static_cast<int>(models.size()))];
}

void plant(uint32_t model, double s_m, double left_m, double claim_m, double scale,
           SceneBuilder* builder) {
  const Eigen::Vector2d p = builder->circuit().beside(s_m, left_m);
  const double yaw = builder->random().uniform(0.0, 2.0 * kPi);
  if (!builder->isFree(p, claim_m)) return;
  builder->place(model, p, yaw, scale);
  builder->claim(p, claim_m);
}

void buildLots(const StreetPlan& plan, const StreetStock& stock, SceneBuilder* builder) {
  for (const Lot& lot : plan.lots) {
    const bool has_house = lot.kind == LotKind::kHouse || lot.kind == LotKind::kBlock;
    if (has_house) addHouse(lot, plan.section, builder);
    addRetainingWall(lot, plan.section, builder);
  }
  for (const Lot& lot : plan.lots) {
    if (lot.kind == LotKind::kHouse) addGarden(lot, plan.section, stock, builder);
    if (lot.kind == LotKind::kPark) addPark(lot, plan.section, stock, builder);
    if (lot.kind == LotKind::kCarPark) addCarPark(lot, plan.section, stock, builder);
  }
}

}  // namespace ladar_perception::sim
