// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "ladar_perception/resample/grid_points.h"

namespace ladar_perception {

/// How much surface points lie on, told from the points alone, as a first guess at the size of
/// cells. Every point stands for its part of the least cube, of 2^l cells of the grid it comes in,
/// that holds four points. How many of the sparse ones are on a surface depends on the cells that
/// look for it: a crust bridges gaps of some cells where points lie in a plane, and gives what is
/// farther apart a piece each.
class AreaEstimate {
 public:
  /// Areas count times the points' weights (by source; empty means 1), and places of weight w are
  /// looked at by cells w^(-1/2) times as large. Every point is one of `stride`.
  AreaEstimate(const GridPoints& points, const std::vector<float>& weights, std::size_t stride = 1);

  /// m^2 in the crust of cells with that edge.
  double area_m2(double cell_m) const;

 private:
  /// Points of cubes that are looked at alike.
  struct Group {
    double area_m2 = 0.0;
    double points = 0.0;
  };
  void add(double edge_m, double thickness_m, double share, double points, double weight);

  /// By parts of octaves of a cube's edge and of the thickness around it, both times weight^(1/2).
  std::map<std::pair<int, int>, Group> groups_;
};

}  // namespace ladar_perception
