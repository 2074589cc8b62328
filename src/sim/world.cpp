// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/world.h"

#include <stdexcept>

#include "scene_builder.h"

namespace ladar_perception::sim {

const std::vector<std::string>& sceneNames() {
  static const std::vector<std::string> names = {"flat_ground", "forest", "tall_grass",
                                                 "campus",      "street", "scrubland"};
  return names;
}

World makeWorld(const std::string& scene_name, uint64_t seed) {
  if (scene_name == "flat_ground") return makeFlatGround(seed);
  if (scene_name == "forest") return makeForest(seed);
  if (scene_name == "tall_grass") return makeTallGrass(seed);
  if (scene_name == "campus") return makeCampus(seed);
  if (scene_name == "street") return makeStreet(seed);
  if (scene_name == "scrubland") return makeScrubland(seed);
  std::string known;
  for (const std::string& name : sceneNames()) known += (known.empty() ? "" : ", ") + name;
  throw std::invalid_argument("scene '" + scene_name + "' is unknown, expected one of " + known);
}

}  // namespace ladar_perception::sim
