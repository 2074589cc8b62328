// SPDX-License-Identifier: BSD-3-Clause
// What things are made of: true class, colour and reflectivity.
#pragma once

#include <cstdint>

namespace ladar_perception::sim {

/// True class of a point, as stored in the field `truth`.
enum class Truth : uint8_t {
  kNone = 0,     ///< no return, or a range mixed from things of two classes
  kSurface = 1,  ///< ground, rock, walls, car bodies
  kScatter = 2,  ///< leaves, grass
  kLinear = 3,   ///< trunks, branches, poles, wires, tubes
};

/// What a point belongs to, finer than Truth: the field `label`.
/// config/classes/simulated_three.yaml and simulated_five.yaml gather these numbers into the
/// classes that are learned.
enum class Label : uint16_t {
  kNone = 0,      ///< no return, or a range mixed from things of two classes
  kGround = 1,    ///< soil, forest floor, lawn and meadow between the blades
  kPavement = 2,  ///< road, walkway, kerb
  kStep = 3,      ///< stairs
  kRock = 4,
  kFacade = 5,  ///< walls of buildings with windows, doors, ledges and roofs
  kWall = 6,    ///< walls that stand alone or hold a bank
  kVehicle = 7,
  kObject = 8,  ///< other surfaces people made: benches, boards, boxes
  kTrunk = 9,
  kBranch = 10,
  kTwig = 11,     ///< thin wood inside crowns and bushes
  kPole = 12,     ///< utility poles with their cross-arms, lamp and sign posts, masts, stakes
  kWire = 13,     ///< power lines, cables, guy wires
  kFence = 14,    ///< posts, rails, pickets and wires of fences
  kTube = 15,     ///< railings, bicycles and their stands
  kLog = 16,      ///< fallen trunks, stumps
  kFoliage = 17,  ///< leaves and needles of trees
  kShrub = 18,    ///< leaves of bushes, hedges, ferns and flower beds
  kGrass = 19,    ///< blades
};

enum class Material : uint8_t {
  kSoil,
  kTrack,
  kForestFloor,
  kMeadow,
  kLawn,
  kAsphalt,
  kConcrete,
  kKerb,
  kStep,
  kRock,
  kBrick,
  kPlaster,
  kTrim,
  kGlass,
  kDoor,
  kWindowFrame,
  kStoneWall,
  kCarPaint,
  kCarGlass,
  kRubber,
  kPlank,
  kBoard,
  kMetalBox,
  kBark,
  kBirchBark,
  kBranch,
  kLog,
  kPost,
  kSteel,
  kWire,
  kFencePost,
  kFenceRail,
  kFenceWire,
  kTube,
  kBicycle,
  kTwig,
  kLeaf,
  kNeedle,
  kShrubLeaf,
  kHedgeLeaf,
  kFern,
  kGrass,
  kDryGrass,
  kCount,
};

struct MaterialProperties {
  Label label = Label::kNone;
  Truth truth = Truth::kNone;
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  /// Share of the light reflected at perpendicular incidence, 0..1.
  float reflectivity = 0.0F;
  /// Share of the rays that go on through it.
  float transmission = 0.0F;
  /// Half width of the brightness variation between places, as a share of the brightness.
  float variation = 0.0F;
};

const MaterialProperties& propertiesOf(Material material);

/// Colour 0x00RRGGBB of one place, leaf or stone of the material; `variant` names it.
uint32_t colourOf(Material material, uint64_t variant);

}  // namespace ladar_perception::sim
