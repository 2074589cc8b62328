// SPDX-License-Identifier: BSD-3-Clause
#include "street_plan.h"

#include <algorithm>
#include <cmath>

namespace ladar_perception::sim {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kKerbHeightM = 0.14;
constexpr double kCamber = 0.025;

LotKind drawKind(Random* random) {
  const double dice = random->uniform();
  if (dice < 0.52) return LotKind::kHouse;
  if (dice < 0.74) return LotKind::kBlock;
  return dice < 0.90 ? LotKind::kPark : LotKind::kCarPark;
}

Lot makeLot(double from_m, double side, const StreetSection& section, Random* random) {
  Lot lot;
  lot.kind = drawKind(random);
  lot.from_m = from_m;
  lot.side = side;
  const bool is_house = lot.kind == LotKind::kHouse;
  const bool is_block = lot.kind == LotKind::kBlock;
  const double width = is_house   ? random->uniform(11.0, 15.0)
                       : is_block ? random->uniform(22.0, 34.0)
                                  : random->uniform(14.0, 24.0);
  lot.to_m = from_m + width;
  const bool is_raised = is_house || lot.kind == LotKind::kPark;
  lot.rise_m = is_raised ? std::max(0.0, random->uniform(-0.8, 2.4)) : 0.0;
  lot.run_m = random->chance(0.35) ? 0.3 : lot.rise_m / std::tan(random->uniform(0.3, 0.6)) + 0.5;
  lot.setback_m =
      section.garden_m + (is_block ? random->uniform(0.2, 7.0) : random->uniform(3.5, 9.0));
  return lot;
}

}  // namespace

StreetPlan makeStreetPlan(uint64_t seed) {
  Random random(streamSeed(seed, {3}));
  StreetPlan plan;
  plan.shape.radius_x_m = random.uniform(56.0, 64.0);
  plan.shape.radius_y_m = random.uniform(42.0, 50.0);
  plan.shape.squareness = random.uniform(2.4, 3.2);
  plan.shape.wave3 = random.uniform(0.0, 0.05);
  plan.shape.wave3_phase_rad = random.uniform(0.0, 2.0 * kPi);
  StreetSection& section = plan.section;
  const double wider_m = random.uniform(-0.8, 2.6);
  section.cars_m += wider_m;
  section.kerb_m += wider_m;
  section.walk_m = section.kerb_m + random.uniform(1.2, 2.2);
  section.garden_m = section.walk_m + random.uniform(1.4, 2.6);
  const double length = Circuit(plan.shape).length();
  for (const double side : {-1.0, 1.0}) {
    for (double s = 0.0; s < length - 14.0; s = plan.lots.back().to_m) {
      plan.lots.push_back(makeLot(s, side, section, &random));
    }
  }
  return plan;
}

double StreetPlan::profile(const TrackPlace& place) const {
  const double out = std::abs(place.left_m);
  if (out < section.kerb_m) return -kCamber * out;
  const double kerb = -kCamber * section.kerb_m + kKerbHeightM;
  if (out < section.garden_m) return kerb + 0.02 * (out - section.kerb_m);
  double height = kerb + 0.02 * (section.garden_m - section.kerb_m);
  for (const Lot& lot : lots) {
    if ((lot.side > 0.0) != (place.left_m > 0.0)) continue;
    const double inside = std::min(place.s_m - lot.from_m, lot.to_m - place.s_m);
    if (inside < -0.5) continue;
    // Neighbours of different height meet on a short slope; behind the houses all is level again.
    const double share = std::clamp(inside + 0.5, 0.0, 1.0) *
                         std::clamp((29.0 - out) / 8.0, 0.0, 1.0) *
                         std::clamp((out - section.garden_m - 0.2) / lot.run_m, 0.0, 1.0);
    height += share * lot.rise_m;
  }
  return height;
}

Material StreetPlan::ground(double track_m, double noise) const {
  if (track_m < section.kerb_m) return Material::kAsphalt;
  if (track_m < section.walk_m) return noise > 0.3 ? Material::kConcrete : Material::kLawn;
  if (track_m < section.garden_m) return Material::kConcrete;
  return noise > 0.45 ? Material::kSoil : Material::kLawn;
}

}  // namespace ladar_perception::sim
