// SPDX-License-Identifier: BSD-3-Clause
// Things people put down. Models have their foot at the origin, x forward, z up; sizes in metres.
#pragma once

#include <vector>

#include "ladar_perception/sim/primitive.h"
#include "ladar_perception/sim/random.h"
#include "scene_builder.h"
#include "vegetation.h"

namespace ladar_perception::sim {

/// Frame of tubes, wheels as rings of thin capsules.
Model makeBicycle(Random* random);
/// Bent tubes that bicycles lean on, `places` of them along y.
Model makeBicycleStand(int places);
Model makeBench();
Model makeLampPost(double height_m);
/// Pole with a cross-arm along y; wires hang from +-0.9 m at
/// `height_m`.
Model makeUtilityPole(double height_m);
struct UtilityPoleStyle {
  double height_m = 10.0;
  double radius_m = 0.16;
  int cross_arms = 1;
  bool transformer = false;
  double lamp_arm_m = 0.0;  ///< 0: none
};

/// Pole of a street, with arms along y, the lamp towards +y; wires hang at `height_m` + 0.15 from
/// the topmost.
Model makeStreetPole(const UtilityPoleStyle& style);
Model makeSignPost();
Model makeHydrant();
Model makeLitterBin();
Model makeParkingMeter();
enum class CarShape { kSedan, kHatchback, kOffRoader, kVan, kPickUp };
constexpr int kCarShapes = 5;

/// Body lofted along its side view, windows that let light through, seats behind them.
Model makeCar(CarShape shape, Random* random);

/// Straight stairs that rise towards +x to `rise_m`, with a railing on both sides.
Model makeStairs(double width_m, double rise_m);

struct BuildingStyle {
  double length_m = 30.0;  ///< along x
  double width_m = 14.0;   ///< along y
  int floors = 2;
  Material wall = Material::kBrick;
  double plinth_m = 0.6;  ///< ground floor above the ground
  double floor_m = 3.2;
  double bay_m = 3.0;  ///< about; bays fill a wall evenly
  double window_width_m = 1.5;
  double sill_m = 0.9;
  double lintel_m = 2.4;
  double recess_m = 0.22;
  double ledge_m = 0.0;          ///< how far a course of stones stands out between floors
  double pier_m = 0.0;           ///< how far piers between the bays stand out
  double blank_share = 0.0;      ///< bays without a window
  double oriel_share = 0.0;      ///< bays of the front whose windows stand out as a box
  double gable_pitch_rad = 0.0;  ///< 0: flat roof with an edge that stands out
  double porch_m = 0.0;          ///< depth of a roofed porch before the front, 0: none
  uint64_t seed = 0;             ///< which bays are blank
};

/// Walls with recessed windows and doors on all sides, a flat or pitched roof, nothing inside. The
/// front faces +y.
Model makeBuilding(const BuildingStyle& style);

/// Where the door of a facade is, along it from its middle.
double doorOffset(double facade_length_m, double bay_m);

/// Places a model beside the track, facing along it turned by `turn_rad`, and claims its ground.
void placeBeside(uint32_t model, double s_m, double left_m, double turn_rad, double claim_m,
                 SceneBuilder* builder);

/// Clipped hedge between two arc lengths.
void addHedgeAlongTrack(double from_m, double to_m, double left_m, double height_m,
                        SceneBuilder* builder);

/// Cable on short poles between two arc lengths.
void addCableAlongTrack(double from_m, double to_m, double left_m, double height_m,
                        SceneBuilder* builder);

enum class FenceKind { kWire, kRails, kBoards };

/// Fence from arc length `from_m` to `to_m`, `left_m` beside the track; claims its ground.
void addFenceAlongTrack(double from_m, double to_m, double left_m, FenceKind kind,
                        SceneBuilder* builder);

/// Utility poles on a straight line with three wires and a lower cable between them. Spans are
/// stretched where a pole would stand on the track.
void addPowerLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double span_m,
                  double height_m, SceneBuilder* builder);

}  // namespace ladar_perception::sim
