// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "structures.h"

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

constexpr double kWallM = 0.35;
constexpr double kPi = 3.141592653589793;

int bayCount(double length_m, double bay_m) {
  return std::max(1, static_cast<int>(std::floor(length_m / bay_m)));
}

/// One side of a building: x along the wall from its left corner seen from outside, y outward,
/// z up from the ground.
struct Facade {
  Eigen::Vector2d corner;
  double yaw_rad;
  double length_m;
};

/// Adds boxes in the coordinates of a facade.
class FacadeWriter {
 public:
  FacadeWriter(const Facade& facade, Model* parts)
      : facade_(facade), turn_(facade.yaw_rad), parts_(parts) {}

  /// From (x0, z0) to (x1, z1), `thick_m` inward from `inset_m` behind the wall's face.
  void add(double x0, double x1, double z0, double z1, double inset_m, double thick_m,
           Material material) {
    const Eigen::Vector2d middle =
        facade_.corner + turn_ * Eigen::Vector2d(0.5 * (x0 + x1), -inset_m - 0.5 * thick_m);
    parts_->push_back(makeBox({middle.x(), middle.y(), 0.5 * (z0 + z1)},
                              {x1 - x0, thick_m, z1 - z0}, facade_.yaw_rad, material));
  }

 private:
  Facade facade_;
  Eigen::Rotation2Dd turn_;
  Model* parts_;
};

struct Opening {
  double width_m;
  double low_m;
  double high_m;
  double recess_m;
  Material fill;
};

/// A bay of wall from x0 to x1 and z0 to z1 with an opening in its middle.
void addBay(double x0, double x1, double z0, double z1, const Opening& opening, Material wall,
            FacadeWriter* writer) {
  const double left = 0.5 * (x0 + x1 - opening.width_m);
  const double right = left + opening.width_m;
  const double low = z0 + opening.low_m;
  const double high = z0 + opening.high_m;
  writer->add(x0, left, z0, z1, 0.0, kWallM, wall);
  writer->add(right, x1, z0, z1, 0.0, kWallM, wall);
  if (opening.low_m > 0.0) {
    writer->add(left, right, z0, low, 0.0, kWallM, wall);
    writer->add(left - 0.05, right + 0.05, low - 0.06, low, -0.06, 0.2, Material::kTrim);
  }
  writer->add(left, right, high, z1, 0.0, kWallM, wall);
  writer->add(left, right, low, high, opening.recess_m, 0.05, opening.fill);
  if (opening.fill == Material::kGlass) {  // a cross of frame bars
    const double middle = 0.5 * (left + right);
    const double inset = opening.recess_m - 0.03;
    writer->add(middle - 0.03, middle + 0.03, low, high, inset, 0.06, Material::kWindowFrame);
    const double bar = low + 0.6 * (high - low);
    writer->add(left, right, bar, bar + 0.06, inset, 0.06, Material::kWindowFrame);
  }
}

/// A bay whose window stands out of the wall as a box on brackets.
void addOriel(double x0, double x1, double z0, double z1, const Opening& opening, Material wall,
              FacadeWriter* writer) {
  constexpr double kOutM = 0.7;
  const double left = 0.5 * (x0 + x1) - 0.4 * (x1 - x0);
  const double right = 0.5 * (x0 + x1) + 0.4 * (x1 - x0);
  writer->add(x0, x1, z0, z1, 0.0, kWallM, wall);
  writer->add(left, right, z0 - 0.1, z0 + opening.low_m, -kOutM, kOutM, Material::kTrim);
  writer->add(left, right, z0 + opening.high_m, z1, -kOutM, kOutM, Material::kTrim);
  writer->add(left + 0.08, right - 0.08, z0 + opening.low_m, z0 + opening.high_m, -kOutM + 0.1,
              0.05, Material::kGlass);
  for (const double x : {left, 0.5 * (left + right) - 0.05, right - 0.1}) {
    writer->add(x, x + 0.1, z0, z1, -kOutM, 0.1, Material::kWindowFrame);
  }
}

void addCourses(const Facade& facade, const BuildingStyle& style, FacadeWriter* writer) {
  for (int floor = 1; floor <= style.floors && style.ledge_m > 0.0; ++floor) {
    const double z = style.plinth_m + style.floor_m * floor;
    const double out = floor == style.floors ? 2.0 * style.ledge_m : style.ledge_m;
    writer->add(-out, facade.length_m + out, z - 0.25, z, -out, out + 0.1, Material::kTrim);
  }
  const int bays = bayCount(facade.length_m, style.bay_m);
  const double top = style.plinth_m + style.floor_m * style.floors;
  for (int i = 0; i <= bays && style.pier_m > 0.0; ++i) {
    const double x = facade.length_m * i / bays;
    writer->add(x - 0.3, x + 0.3, style.plinth_m, top, -style.pier_m, style.pier_m + 0.1,
                style.wall);
  }
}

void addFacade(const Facade& facade, bool is_front, const BuildingStyle& style, Random* random,
               Model* parts) {
  const Opening window{style.window_width_m, style.sill_m, style.lintel_m, style.recess_m,
                       Material::kGlass};
  const Opening door{1.2, 0.0, 2.2, 0.28, Material::kDoor};
  FacadeWriter writer(facade, parts);
  // Down into the ground: buildings stand on slopes too.
  writer.add(-0.05, facade.length_m + 0.05, -2.5, style.plinth_m, -0.05, kWallM, Material::kTrim);
  const int bays = bayCount(facade.length_m, style.bay_m);
  const double bay = facade.length_m / bays;
  for (int floor = 0; floor < style.floors; ++floor) {
    const double low = style.plinth_m + style.floor_m * floor;
    for (int i = 0; i < bays; ++i) {
      const bool is_door = floor == 0 && i == bays / 2;
      const bool is_blank = random->chance(style.blank_share) && !is_door;
      const bool is_oriel = random->chance(style.oriel_share) && is_front && !is_door;
      if (is_blank) {
        writer.add(bay * i, bay * (i + 1), low, low + style.floor_m, 0.0, kWallM, style.wall);
      } else if (is_oriel) {
        addOriel(bay * i, bay * (i + 1), low, low + style.floor_m, window, style.wall, &writer);
      } else {
        addBay(bay * i, bay * (i + 1), low, low + style.floor_m, is_door ? door : window,
               style.wall, &writer);
      }
    }
  }
  addCourses(facade, style, &writer);
}

/// Roof over a ridge along x, with its gables.
void addGable(const BuildingStyle& style, Model* parts) {
  const double eaves = style.plinth_m + style.floor_m * style.floors;
  const double half = 0.5 * style.width_m;
  const double rise = half * std::tan(style.gable_pitch_rad);
  const double over = 0.5;  // the eaves stand out
  const double slope_m = (half + over) / std::cos(style.gable_pitch_rad);
  for (const double side : {-1.0, 1.0}) {
    const double y = side * 0.5 * (half + over);
    const double z = eaves + rise - std::abs(y) * std::tan(style.gable_pitch_rad);
    // Tilted about its own y, then turned so that its x axis points along world y.
    parts->push_back(makeBox({0.0, y, z + 0.08}, {slope_m, style.length_m + 2.0 * over, 0.14},
                             side * 0.5 * kPi, Material::kTrim, style.gable_pitch_rad));
    const double x = side * 0.5 * style.length_m;
    parts->push_back(
        makeTriangle({x, -half, eaves}, {x, half, eaves}, {x, 0.0, eaves + rise}, style.wall));
  }
}

/// Deck with steps, columns and a roof before the front.
void addPorch(const BuildingStyle& style, Model* parts) {
  const double front = 0.5 * style.width_m;
  const double width = 0.8 * style.length_m;
  const double deck = style.plinth_m;
  const double middle = front + 0.5 * style.porch_m;
  parts->push_back(makeBox({0.0, middle, 0.5 * (deck - 2.5)}, {width, style.porch_m, deck + 2.5},
                           0.0, Material::kTrim));
  parts->push_back(makeBox({0.0, middle, deck + 2.65}, {width + 0.4, style.porch_m + 0.4, 0.22},
                           0.0, Material::kTrim));
  const int columns = 2 + static_cast<int>(width / 3.0);
  for (int i = 0; i < columns; ++i) {
    const double x = (width - 0.3) * (static_cast<double>(i) / (columns - 1) - 0.5);
    const Eigen::Vector3d foot(x, front + style.porch_m - 0.15, deck);
    const Eigen::Vector3d head = foot + Eigen::Vector3d(0.0, 0.0, 2.6);
    parts->push_back(makeCylinder(foot, head, 0.09, Material::kPost));
    if (i == 0 || i == columns / 2) continue;  // the steps lead up there
    const Eigen::Vector3d last(foot.x() - (width - 0.3) / (columns - 1), foot.y(), deck);
    for (const double z : {0.15, 0.85}) {
      const Eigen::Vector3d up(0.0, 0.0, z);
      parts->push_back(makeCapsule(last + up, foot + up, 0.025, Material::kTube));
    }
    for (double u = 0.08; u < 1.0; u += 0.08) {
      const Eigen::Vector3d p = last + u * (foot - last);
      parts->push_back(makeCapsule(p + Eigen::Vector3d(0, 0, 0.15), p + Eigen::Vector3d(0, 0, 0.85),
                                   0.015, Material::kTube));
    }
  }
}

}  // namespace

double doorOffset(double facade_length_m, double bay_m) {
  const int bays = bayCount(facade_length_m, bay_m);
  return facade_length_m * ((bays / 2 + 0.5) / bays - 0.5);
}

Model makeBuilding(const BuildingStyle& style) {
  Model parts;
  Random random(streamSeed(style.seed, {11}));
  const double hx = 0.5 * style.length_m;
  const double hy = 0.5 * style.width_m;
  // y points outward, so each wall runs clockwise seen from above: corner, then yaw.
  const std::array<Facade, 4> facades = {{{{-hx, hy}, 0.0, style.length_m},
                                          {{hx, hy}, -0.5 * kPi, style.width_m},
                                          {{hx, -hy}, kPi, style.length_m},
                                          {{-hx, -hy}, 0.5 * kPi, style.width_m}}};
  for (const Facade& facade : facades) {
    addFacade(facade, &facade == &facades.front(), style, &random, &parts);
  }
  const double top = style.plinth_m + style.floor_m * style.floors;
  if (style.gable_pitch_rad > 0.0) {
    addGable(style, &parts);
  } else {
    parts.push_back(makeBox({0.0, 0.0, top + 0.15},
                            {style.length_m + 0.6, style.width_m + 0.6, 0.3}, 0.0,
                            Material::kTrim));
  }
  if (style.porch_m > 0.0) addPorch(style, &parts);
  // Dark inside: rays that slip past a frame end on a core instead of crossing the building.
  parts.push_back(makeBox({0.0, 0.0, 0.5 * top}, {style.length_m - 1.5, style.width_m - 1.5, top},
                          0.0, Material::kPlaster));
  return parts;
}

}  // namespace ladar_perception::sim
