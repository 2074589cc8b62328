// SPDX-License-Identifier: BSD-3-Clause
// Crusts for the tests of fronts: of a grid, and of points that lie on a known surface.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/fronts.h"
#include "ladar_perception/resample/grid_points.h"
#include "ladar_perception/resample/surface_fit.h"
#include "ladar_perception/resample/voxel_pyramid.h"

namespace ladar_perception::test {

/// A plane of nx * ny cells one cell apart, each the neighbour of the eight around it. The cell at
/// (0, 0) lies at the origin. Where `is_crust` says no there is none.
inline Crust gridCrust(
    int nx, int ny, const std::function<bool(int, int)>& is_crust = [](int, int) { return true; }) {
  std::vector<std::pair<uint64_t, Eigen::Vector3f>> cells;
  for (int y = 0; y < ny; ++y) {
    for (int x = 0; x < nx; ++x) {
      const Eigen::Vector3f p(static_cast<float>(x), static_cast<float>(y), 0.0F);
      if (is_crust(x, y)) cells.emplace_back(cellKey(p + Eigen::Vector3f::Constant(0.5F)), p);
    }
  }
  std::sort(cells.begin(), cells.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  Crust crust;
  std::vector<uint32_t> at(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny), kNoIndex);
  const auto slot = [nx](int x, int y) { return static_cast<std::size_t>(y * nx + x); };
  for (const auto& [key, p] : cells) {
    at[slot(static_cast<int>(p.x()), static_cast<int>(p.y()))] =
        static_cast<uint32_t>(crust.size());
    crust.keys.push_back(key);
    crust.positions.push_back(p);
  }
  crust.normals.assign(crust.size(), Eigen::Vector3f::UnitZ());
  crust.slowness.assign(crust.size(), 1.0F);
  crust.levels.assign(crust.size(), 0);
  crust.first_neighbor.push_back(0);
  for (const Eigen::Vector3f& p : crust.positions) {
    for (int step = 0; step < 9; ++step) {
      const int x = static_cast<int>(p.x()) + step % 3 - 1;
      const int y = static_cast<int>(p.y()) + step / 3 - 1;
      if (step == 4 || x < 0 || x >= nx || y < 0 || y >= ny) continue;
      if (at[slot(x, y)] != kNoIndex) crust.neighbors.push_back(at[slot(x, y)]);
    }
    crust.first_neighbor.push_back(static_cast<uint32_t>(crust.neighbors.size()));
  }
  return crust;
}

/// The surfel crust of points given in cells, seen from `sensor`.
inline Crust surfelCrust(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& sensor,
                         int threads = 1) {
  GridFrame frame;
  frame.origin_m = gridOrigin(points, frame.cell_m);
  const GridPoints grid = sortIntoGrid(points, frame);
  const VoxelPyramid pyramid(grid, {}, kBridgeLevels + 1);
  ThreadPool pool(threads);
  return makeSurfelCrust(pyramid, frame, {}, frame.toCells(sensor).cast<float>(), &pool);
}

inline Eigen::Vector3d placeOf(const Crust& crust, std::size_t cell) {
  return crust.frame.toMetres(crust.positions[cell]);
}

/// The cell whose place is nearest.
inline uint32_t cellNear(const Crust& crust, const Eigen::Vector3d& place) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < crust.size(); ++i) {
    if ((placeOf(crust, i) - place).norm() < (placeOf(crust, nearest) - place).norm()) nearest = i;
  }
  return static_cast<uint32_t>(nearest);
}

/// Arrival times of fronts from the places of cells, one after the other.
template <typename Metric>
std::vector<double> arrivalTimes(const Crust& crust, const std::vector<uint32_t>& sources) {
  FrontField field(crust);
  Fronts<Metric> fronts(&field);
  for (const uint32_t source : sources) fronts.insert(source, crust.positions[source]);
  std::vector<double> times;
  for (const FrontField::Arrival& arrival : field.arrivals) times.push_back(arrival.time);
  return times;
}

}  // namespace ladar_perception::test
