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

// Reflectivity at 905 nm: vegetation is bright, asphalt and rubber are dark, glass is a mirror.
constexpr std::array<MaterialProperties, static_cast<std::size_t>(Material::kCount)> kProperties = {
    {
        {kSurface, 128, 104, 76, 0.30F, 0.14F},   // kSoil
        {kSurface, 148, 126, 96, 0.32F, 0.12F},   // kTrack
        {kSurface, 96, 78, 52, 0.30F, 0.22F},     // kForestFloor
        {kSurface, 112, 118, 62, 0.38F, 0.20F},   // kMeadow
        {kSurface, 86, 128, 56, 0.42F, 0.12F},    // kLawn
        {kSurface, 74, 74, 78, 0.17F, 0.08F},     // kAsphalt
        {kSurface, 164, 162, 154, 0.38F, 0.07F},  // kConcrete
        {kSurface, 132, 128, 122, 0.35F, 0.14F},  // kRock
        {kSurface, 156, 84, 66, 0.34F, 0.12F},    // kBrick
        {kSurface, 212, 204, 186, 0.55F, 0.04F},  // kPlaster
        {kSurface, 62, 78, 92, 0.03F, 0.15F},     // kGlass
        {kSurface, 92, 62, 44, 0.30F, 0.06F},     // kDoor
        {kSurface, 150, 36, 40, 0.40F, 0.05F},    // kCarPaint
        {kSurface, 32, 32, 34, 0.08F, 0.10F},     // kRubber
        {kSurface, 142, 104, 66, 0.38F, 0.10F},   // kPlank
        {kLinear, 92, 76, 60, 0.35F, 0.18F},      // kBark
        {kLinear, 196, 192, 182, 0.50F, 0.16F},   // kBirchBark
        {kLinear, 102, 82, 62, 0.35F, 0.15F},     // kBranch
        {kLinear, 104, 84, 64, 0.33F, 0.18F},     // kLog
        {kLinear, 138, 112, 84, 0.38F, 0.12F},    // kPost
        {kLinear, 140, 146, 150, 0.40F, 0.06F},   // kSteel
        {kLinear, 58, 58, 60, 0.25F, 0.08F},      // kWire
        {kLinear, 38, 74, 138, 0.35F, 0.20F},     // kBicycle
        {kScatter, 108, 90, 66, 0.35F, 0.15F},    // kTwig
        {kScatter, 74, 122, 46, 0.50F, 0.28F},    // kLeaf
        {kScatter, 46, 86, 50, 0.42F, 0.25F},     // kNeedle
        {kScatter, 54, 100, 42, 0.48F, 0.22F},    // kHedgeLeaf
        {kScatter, 82, 136, 52, 0.48F, 0.22F},    // kFern
        {kScatter, 110, 148, 60, 0.48F, 0.22F},   // kGrass
        {kScatter, 182, 164, 104, 0.50F, 0.16F},  // kDryGrass
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
