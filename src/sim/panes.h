// SPDX-License-Identifier: BSD-3-Clause
// Light that goes on through glass.
#pragma once

#include "ladar_perception/sim/random.h"
#include "ladar_perception/sim/scene.h"

namespace ladar_perception::sim {

/// What a ray ends on: `cast(ray, limit_m)` gives the Hit of what it meets, and of panes a share of
/// the rays goes on. The hit's range counts from the ray's origin, whose direction has unit length.
template <typename Cast>
Hit castThroughPanes(const Ray& ray, double limit_m, Cast&& cast, Random* random) {
  constexpr int kMaxPanes = 4;
  constexpr double kPaneM = 0.02;
  double passed_m = 0.0;
  for (int pane = 0; pane < kMaxPanes; ++pane) {
    Hit hit = cast(Ray{ray.origin + passed_m * ray.direction, ray.direction}, limit_m - passed_m);
    if (!hit.valid()) return hit;
    hit.range += passed_m;
    const double transmission = propertiesOf(hit.material).transmission;
    if (transmission == 0.0 || !random->chance(transmission)) return hit;
    passed_m = hit.range + kPaneM;
  }
  return Hit();
}

}  // namespace ladar_perception::sim
