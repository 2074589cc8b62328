// SPDX-License-Identifier: BSD-3-Clause
// Cars as bodies lofted along their side view.
#include <array>
#include <cmath>

#include "structures.h"

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

/// Side view: heights of the body (up to the belt) and of the cabin above it along the car, as
/// shares of its length from the tail.
struct Station {
  double along;
  double belt_m;
  double top_m;  ///< equal to belt_m where there is no cabin
};

struct SideView {
  double length_m;
  double width_m;
  std::vector<Station> stations;
};

SideView sideView(CarShape shape) {
  switch (shape) {
    case CarShape::kSedan:
      return {4.6,
              1.78,
              {{0.0, 0.78, 0.78},
               {0.03, 0.95, 0.95},
               {0.17, 0.98, 0.98},
               {0.28, 0.96, 1.36},
               {0.40, 0.94, 1.44},
               {0.54, 0.92, 1.42},
               {0.69, 0.92, 0.94},
               {0.92, 0.78, 0.78},
               {1.0, 0.60, 0.60}}};
    case CarShape::kHatchback:
      return {4.0,
              1.72,
              {{0.0, 0.85, 0.85},
               {0.02, 1.00, 1.02},
               {0.10, 0.98, 1.40},
               {0.30, 0.96, 1.48},
               {0.52, 0.94, 1.46},
               {0.70, 0.94, 0.97},
               {0.93, 0.82, 0.82},
               {1.0, 0.62, 0.62}}};
    case CarShape::kOffRoader:
      return {4.7,
              1.88,
              {{0.0, 0.95, 0.95},
               {0.02, 1.12, 1.15},
               {0.06, 1.12, 1.74},
               {0.35, 1.10, 1.80},
               {0.58, 1.08, 1.76},
               {0.70, 1.08, 1.12},
               {0.95, 1.00, 1.00},
               {1.0, 0.72, 0.72}}};
    case CarShape::kVan:
      return {5.2,
              1.95,
              {{0.0, 1.20, 1.95},
               {0.02, 1.20, 2.05},
               {0.50, 1.20, 2.10},
               {0.76, 1.15, 2.02},
               {0.88, 1.12, 1.20},
               {0.98, 0.95, 0.95},
               {1.0, 0.65, 0.65}}};
    default:
      return {5.4,
              1.92,
              {{0.0, 0.98, 0.98},
               {0.38, 1.00, 1.00},
               {0.40, 1.02, 1.70},
               {0.55, 1.02, 1.76},
               {0.64, 1.02, 1.68},
               {0.72, 1.02, 1.06},
               {0.95, 0.95, 0.95},
               {1.0, 0.70, 0.70}}};
  }
}

/// Half of a section across the car, from the sill up to the middle of the roof.
constexpr int kSectionPoints = 6;
using Section = std::array<Vector3d, kSectionPoints>;

Section sectionAt(const SideView& view, const Station& station) {
  const double x = (station.along - 0.5) * view.length_m;
  // Bumpers are rounded seen from above.
  const double end = std::pow(std::abs(2.0 * station.along - 1.0), 6.0);
  const double half = 0.5 * view.width_m * (1.0 - 0.12 * end);
  const double cabin = station.top_m - station.belt_m;
  return {Vector3d(x, 0.94 * half, 0.20),
          Vector3d(x, half, 0.45),
          Vector3d(x, 0.99 * half, 0.75 * station.belt_m + 0.1),
          Vector3d(x, 0.94 * half, station.belt_m),
          Vector3d(x, (0.94 - 0.32 * cabin) * half, station.belt_m + 0.94 * cabin),
          Vector3d(x, 0.0, station.top_m + 0.03)};
}

void addQuad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
             Material material, Model* parts) {
  parts->push_back(makeTriangle(a, b, c, material));
  parts->push_back(makeTriangle(a, c, d, material));
}

Vector3d mirrored(const Vector3d& p) { return {p.x(), -p.y(), p.z()}; }

void addBody(const SideView& view, bool side_glass, Model* parts) {
  for (std::size_t i = 0; i + 1 < view.stations.size(); ++i) {
    const Station& from = view.stations[i];
    const Station& to = view.stations[i + 1];
    const Section a = sectionAt(view, from);
    const Section b = sectionAt(view, to);
    const double rise_from = from.top_m - from.belt_m;
    const double rise_to = to.top_m - to.belt_m;
    const bool is_screen = std::abs(rise_to - rise_from) > 0.25;
    const bool is_cabin = rise_from > 0.25 && rise_to > 0.25;
    for (int k = 0; k + 1 < kSectionPoints; ++k) {
      const bool is_roof = k == kSectionPoints - 2;
      const bool glass = is_roof ? is_screen : k == 3 && (is_cabin ? side_glass : is_screen);
      const Material material = glass ? Material::kCarGlass : Material::kCarPaint;
      addQuad(a[k], b[k], b[k + 1], a[k + 1], material, parts);
      addQuad(mirrored(a[k]), mirrored(b[k]), mirrored(b[k + 1]), mirrored(a[k + 1]), material,
              parts);
    }
  }
  for (const Station& station : {view.stations.front(), view.stations.back()}) {
    const Section s = sectionAt(view, station);
    for (int k = 0; k + 1 < kSectionPoints; ++k) {
      addQuad(s[k], mirrored(s[k]), mirrored(s[k + 1]), s[k + 1], Material::kCarPaint, parts);
    }
  }
}

/// Pillars between the windows, and seats behind them.
void addCabin(const SideView& view, Model* parts) {
  for (const Station& station : view.stations) {
    if (station.top_m - station.belt_m < 0.25) continue;
    const Section s = sectionAt(view, station);
    parts->push_back(makeCapsule(s[3], s[4], 0.04, Material::kCarPaint));
    parts->push_back(makeCapsule(mirrored(s[3]), mirrored(s[4]), 0.04, Material::kCarPaint));
    for (const double y : {-0.38, 0.38}) {
      parts->push_back(makeBox({s[3].x(), y, 0.85}, {0.15, 0.5, 0.85}, 0.0, Material::kRubber));
    }
  }
  const double middle = view.stations[view.stations.size() / 2].belt_m;
  parts->push_back(makeBox({0.0, 0.0, 0.5 * middle + 0.1}, {0.5 * view.length_m, 1.3, 0.6 * middle},
                           0.0, Material::kRubber));
}

}  // namespace

Model makeCar(CarShape shape, Random* random) {
  Model parts;
  SideView view = sideView(shape);
  view.length_m *= random->uniform(0.94, 1.06);
  view.width_m *= random->uniform(0.97, 1.03);
  const bool panel_van = shape == CarShape::kVan && random->chance(0.5);
  addBody(view, !panel_van, &parts);
  addCabin(view, &parts);
  const double wheel = shape == CarShape::kOffRoader || shape == CarShape::kPickUp ? 0.37 : 0.32;
  for (const double x : {-0.30 * view.length_m, 0.31 * view.length_m}) {
    for (const double side : {-1.0, 1.0}) {
      const double outer = side * (0.5 * view.width_m + 0.01);
      parts.push_back(makeCylinder({x, outer - 0.22 * side, wheel}, {x, outer, wheel}, wheel,
                                   Material::kRubber));
    }
  }
  for (const double side : {-1.0, 1.0}) {  // mirrors
    parts.push_back(makeBox({0.17 * view.length_m, side * (0.5 * view.width_m + 0.08), 1.0},
                            {0.1, 0.2, 0.14}, 0.0, Material::kCarPaint));
  }
  return parts;
}

}  // namespace ladar_perception::sim
