// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "structures.h"

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

constexpr double kFloorM = 3.2;
constexpr double kWallM = 0.35;

int bayCount(double length_m) { return static_cast<int>(std::floor(length_m / 3.0)); }

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
    writer->add(left, right, low + 0.9, low + 0.96, inset, 0.06, Material::kWindowFrame);
  }
}

void addFacade(const Facade& facade, const BuildingStyle& style, Model* parts) {
  const Opening window{1.5, 0.9, 2.4, 0.22, Material::kGlass};
  const Opening door{1.2, 0.0, 2.2, 0.28, Material::kDoor};
  FacadeWriter writer(facade, parts);
  // Down into the ground: buildings stand on slopes too.
  writer.add(-0.05, facade.length_m + 0.05, -1.5, style.plinth_m, -0.05, kWallM,
             Material::kTrim);
  const int bays = bayCount(facade.length_m);
  const double bay = facade.length_m / bays;
  for (int floor = 0; floor < style.floors; ++floor) {
    const double low = style.plinth_m + kFloorM * floor;
    for (int i = 0; i < bays; ++i) {
      const bool is_door = floor == 0 && i == bays / 2;
      addBay(bay * i, bay * (i + 1), low, low + kFloorM, is_door ? door : window, style.wall,
             &writer);
    }
  }
}

}  // namespace

double doorOffset(double facade_length_m) {
  const int bays = bayCount(facade_length_m);
  return facade_length_m * ((bays / 2 + 0.5) / bays - 0.5);
}

Model makeBuilding(const BuildingStyle& style) {
  constexpr double kQuarter = 1.5707963267948966;
  Model parts;
  const double hx = 0.5 * style.length_m;
  const double hy = 0.5 * style.width_m;
  // y points outward, so each wall runs clockwise seen from above: corner, then yaw.
  const std::array<Facade, 4> facades = {{{{-hx, hy}, 0.0, style.length_m},
                                          {{hx, hy}, -kQuarter, style.width_m},
                                          {{hx, -hy}, 2.0 * kQuarter, style.length_m},
                                          {{-hx, -hy}, kQuarter, style.width_m}}};
  for (const Facade& facade : facades) addFacade(facade, style, &parts);
  const double top = style.plinth_m + kFloorM * style.floors;
  parts.push_back(makeBox({0.0, 0.0, top + 0.15}, {style.length_m + 0.6, style.width_m + 0.6, 0.3},
                          0.0, Material::kTrim));
  // Dark inside: rays that slip past a frame end on a core instead of crossing the building.
  parts.push_back(makeBox({0.0, 0.0, 0.5 * top}, {style.length_m - 1.5, style.width_m - 1.5, top},
                          0.0, Material::kPlaster));
  return parts;
}

}  // namespace ladar_perception::sim
