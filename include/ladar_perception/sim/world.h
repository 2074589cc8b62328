// SPDX-License-Identifier: BSD-3-Clause
// The scenes by name, each with the track that leads through it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/sim/circuit.h"
#include "ladar_perception/sim/scene.h"

namespace ladar_perception::sim {

/// Nothing but grass stands closer than this to the track's centre line, up to kClearHeightM.
constexpr double kClearHalfWidthM = 2.0;
constexpr double kClearHeightM = 2.6;

struct World {
  Circuit circuit;
  Scene scene;
};

/// "flat_ground", "forest", "tall_grass", "campus", "street", "scrubland".
const std::vector<std::string>& sceneNames();

/// Builds a scene; the same name and seed give the same world. Throws std::invalid_argument for a
/// name that is not in sceneNames().
World makeWorld(const std::string& scene_name, uint64_t seed);

}  // namespace ladar_perception::sim
