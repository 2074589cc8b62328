// SPDX-License-Identifier: BSD-3-Clause
// The land along a street: its cross-section, its lots, and the height of its ground.
#pragma once

#include <vector>

#include "ladar_perception/sim/circuit.h"
#include "ladar_perception/sim/material.h"
#include "ladar_perception/sim/random.h"
#include "scene_builder.h"

namespace ladar_perception::sim {

/// Distances from the middle of the street at which things begin, on both sides.
struct StreetSection {
  double cars_m = 4.2;    ///< middle of the parked cars
  double kerb_m = 5.4;    ///< then the verge with trees and poles
  double walk_m = 6.9;    ///< then the walkway
  double garden_m = 8.7;  ///< then the lots
};

enum class LotKind { kHouse, kBlock, kPark, kCarPark };

/// A piece of land along one side of the street.
struct Lot {
  LotKind kind = LotKind::kHouse;
  double from_m = 0.0;
  double to_m = 0.0;
  double side = 1.0;       ///< 1 left, -1 right
  double rise_m = 0.0;     ///< of the ground behind the walkway
  double run_m = 0.5;      ///< over which it rises; a retaining wall if short
  double setback_m = 0.0;  ///< of the front from the middle of the street

  double middle() const { return 0.5 * (from_m + to_m); }
  bool hasWall() const { return run_m < 0.5 && rise_m > 0.3; }
};

struct StreetPlan {
  CircuitShape shape;
  StreetSection section;
  std::vector<Lot> lots;

  /// Height over the hills: camber, kerb, and the banks of the lots.
  double profile(const TrackPlace& place) const;
  Material ground(double track_m, double noise) const;
};

StreetPlan makeStreetPlan(uint64_t seed);

/// Models that are put down many times.
struct StreetStock {
  std::vector<uint32_t> cars;
  std::vector<uint32_t> trees;
  std::vector<uint32_t> young_trees;
  std::vector<uint32_t> conifers;
  std::vector<uint32_t> bushes;
  std::vector<uint32_t> flowers;
  std::vector<uint32_t> tufts;
};

uint32_t anyOf(const std::vector<uint32_t>& models, SceneBuilder* builder);

/// Puts a model beside the track, turned at random, if nothing is there yet.
void plant(uint32_t model, double s_m, double left_m, double claim_m, double scale,
           SceneBuilder* builder);

/// Buildings, retaining walls and steps first, then what grows and parks around them.
void buildLots(const StreetPlan& plan, const StreetStock& stock, SceneBuilder* builder);

}  // namespace ladar_perception::sim
