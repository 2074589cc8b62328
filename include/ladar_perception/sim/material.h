// SPDX-License-Identifier: BSD-3-Clause
// What things are made of: true class, colour and reflectivity.
#pragma once

#include <cstdint>

namespace ladar_perception::sim {

/// True class of a point, as stored in the field `truth`.
enum class Truth : uint8_t {
  kNone = 0,     ///< no return, or a range mixed from two things
  kSurface = 1,  ///< ground, rock, walls, car bodies
  kScatter = 2,  ///< leaves, grass
  kLinear = 3,   ///< trunks, branches, poles, wires, tubes
};

enum class Material : uint8_t {
  kSoil,
  kTrack,
  kForestFloor,
  kMeadow,
  kLawn,
  kAsphalt,
  kConcrete,
  kRock,
  kBrick,
  kPlaster,
  kGlass,
  kDoor,
  kCarPaint,
  kRubber,
  kPlank,
  kBark,
  kBirchBark,
  kBranch,
  kLog,
  kPost,
  kSteel,
  kWire,
  kBicycle,
  kTwig,
  kLeaf,
  kNeedle,
  kHedgeLeaf,
  kFern,
  kGrass,
  kDryGrass,
  kCount,
};

struct MaterialProperties {
  Truth truth = Truth::kNone;
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  /// Share of the light reflected at perpendicular incidence, 0..1.
  float reflectivity = 0.0F;
  /// Half width of the brightness variation between places, as a share of the brightness.
  float variation = 0.0F;
};

const MaterialProperties& propertiesOf(Material material);

/// Colour 0x00RRGGBB of one place, leaf or stone of the material; `variant` names it.
uint32_t colourOf(Material material, uint64_t variant);

}  // namespace ladar_perception::sim
