// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/material.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "ladar_perception/sim/random.h"

namespace ladar_perception::sim {
namespace {

constexpr Truth kSurface = Truth::kSurface;
constexpr Truth kScatter = Truth::kScatter;
constexpr Truth kLinear = Truth::kLinear;

// Reflectivity at 905 nm: vegetation is bright, asphalt and rubber are dark, glass is a
// mirror that lets half of the rays pass.
constexpr std::array<MaterialProperties, static_cast<std::size_t>(Material::kCount)> kProperties = {
    {
        {Label::kGround, kSurface, 128, 104, 76, 0.30F, 0.0F, 0.14F},     // kSoil
        {Label::kGround, kSurface, 148, 126, 96, 0.32F, 0.0F, 0.12F},     // kTrack
        {Label::kGround, kSurface, 96, 78, 52, 0.30F, 0.0F, 0.22F},       // kForestFloor
        {Label::kGround, kSurface, 112, 118, 62, 0.38F, 0.0F, 0.20F},     // kMeadow
        {Label::kGround, kSurface, 86, 128, 56, 0.42F, 0.0F, 0.12F},      // kLawn
        {Label::kPavement, kSurface, 74, 74, 78, 0.17F, 0.0F, 0.08F},     // kAsphalt
        {Label::kPavement, kSurface, 164, 162, 154, 0.38F, 0.0F, 0.07F},  // kConcrete
        {Label::kPavement, kSurface, 164, 162, 154, 0.38F, 0.0F, 0.07F},  // kKerb
        {Label::kStep, kSurface, 164, 162, 154, 0.38F, 0.0F, 0.07F},      // kStep
        {Label::kRock, kSurface, 132, 128, 122, 0.35F, 0.0F, 0.14F},      // kRock
        {Label::kFacade, kSurface, 156, 84, 66, 0.34F, 0.0F, 0.12F},      // kBrick
        {Label::kFacade, kSurface, 212, 204, 186, 0.55F, 0.0F, 0.04F},    // kPlaster
        {Label::kFacade, kSurface, 164, 162, 154, 0.38F, 0.0F, 0.07F},    // kTrim
        {Label::kFacade, kSurface, 62, 78, 92, 0.03F, 0.55F, 0.15F},      // kGlass
        {Label::kFacade, kSurface, 92, 62, 44, 0.30F, 0.0F, 0.06F},       // kDoor
        {Label::kFacade, kSurface, 142, 104, 66, 0.38F, 0.0F, 0.10F},     // kWindowFrame
        {Label::kWall, kSurface, 132, 128, 122, 0.35F, 0.0F, 0.14F},      // kStoneWall
        {Label::kVehicle, kSurface, 150, 36, 40, 0.40F, 0.0F, 0.05F},     // kCarPaint
        {Label::kVehicle, kSurface, 62, 78, 92, 0.03F, 0.75F, 0.15F},     // kCarGlass
        {Label::kVehicle, kSurface, 32, 32, 34, 0.08F, 0.0F, 0.10F},      // kRubber
        {Label::kObject, kSurface, 142, 104, 66, 0.38F, 0.0F, 0.10F},     // kPlank
        {Label::kObject, kSurface, 212, 204, 186, 0.55F, 0.0F, 0.04F},    // kBoard
        {Label::kObject, kSurface, 120, 124, 122, 0.35F, 0.0F, 0.06F},    // kMetalBox
        {Label::kTrunk, kLinear, 92, 76, 60, 0.35F, 0.0F, 0.18F},         // kBark
        {Label::kTrunk, kLinear, 196, 192, 182, 0.50F, 0.0F, 0.16F},      // kBirchBark
        {Label::kBranch, kLinear, 102, 82, 62, 0.35F, 0.0F, 0.15F},       // kBranch
        {Label::kLog, kLinear, 104, 84, 64, 0.33F, 0.0F, 0.18F},          // kLog
        {Label::kPole, kLinear, 138, 112, 84, 0.38F, 0.0F, 0.12F},        // kPost
        {Label::kPole, kLinear, 140, 146, 150, 0.40F, 0.0F, 0.06F},       // kSteel
        {Label::kWire, kLinear, 58, 58, 60, 0.25F, 0.0F, 0.08F},          // kWire
        {Label::kFence, kLinear, 138, 112, 84, 0.38F, 0.0F, 0.12F},       // kFencePost
        {Label::kFence, kLinear, 138, 112, 84, 0.38F, 0.0F, 0.12F},       // kFenceRail
        {Label::kFence, kLinear, 58, 58, 60, 0.25F, 0.0F, 0.08F},         // kFenceWire
        {Label::kTube, kLinear, 140, 146, 150, 0.40F, 0.0F, 0.06F},       // kTube
        {Label::kTube, kLinear, 38, 74, 138, 0.35F, 0.0F, 0.20F},         // kBicycle
        {Label::kTwig, kScatter, 108, 90, 66, 0.35F, 0.0F, 0.15F},        // kTwig
        {Label::kFoliage, kScatter, 74, 122, 46, 0.50F, 0.0F, 0.28F},     // kLeaf
        {Label::kFoliage, kScatter, 46, 86, 50, 0.42F, 0.0F, 0.25F},      // kNeedle
        {Label::kShrub, kScatter, 74, 122, 46, 0.50F, 0.0F, 0.28F},       // kShrubLeaf
        {Label::kShrub, kScatter, 54, 100, 42, 0.48F, 0.0F, 0.22F},       // kHedgeLeaf
        {Label::kShrub, kScatter, 82, 136, 52, 0.48F, 0.0F, 0.22F},       // kFern
        {Label::kGrass, kScatter, 110, 148, 60, 0.48F, 0.0F, 0.22F},      // kGrass
        {Label::kGrass, kScatter, 182, 164, 104, 0.50F, 0.0F, 0.16F},     // kDryGrass
    }};

uint32_t channel(uint8_t base, double scale) {
  return static_cast<uint32_t>(std::clamp(base * scale, 0.0, 255.0));
}

}  // namespace

const MaterialProperties& propertiesOf(Material material) {
  return kProperties[static_cast<std::size_t>(material)];
}

uint32_t colourOf(Material material, uint64_t variant) {
  const MaterialProperties& look = propertiesOf(material);
  Random random(mixBits(variant));
  const double brightness = 1.0 + look.variation * random.uniform(-1.0, 1.0);
  // A little hue as well: warm and cool move red and blue apart.
  const double warmth = 0.3 * look.variation * random.uniform(-1.0, 1.0);
  return channel(look.red, brightness * (1.0 + warmth)) << 16 |
         channel(look.green, brightness) << 8 | channel(look.blue, brightness * (1.0 - warmth));
}

}  // namespace ladar_perception::sim
