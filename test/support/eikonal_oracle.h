// SPDX-License-Identifier: BSD-3-Clause
// Arrival times of fronts as an oracle: the fast marching of Cole, Harrison, Newman (Algorithm 1
// and equation 7) taken literally, on a full grid, and times that are known in closed form.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace ladar_perception::test {

/// A grid of nx * ny * nz cells, x the fastest; nz = 1 is a plane.
struct RegularGrid {
  int nx = 1;
  int ny = 1;
  int nz = 1;
  double spacing_m = 1.0;

  std::size_t size() const {
    return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) *
           static_cast<std::size_t>(nz);
  }
  std::size_t index(int i, int j, int k = 0) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(nx) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(ny) * static_cast<std::size_t>(k));
  }
  std::array<int, 3> cell(std::size_t index) const {
    const auto n = static_cast<int>(index);
    return {n % nx, n / nx % ny, n / (nx * ny)};
  }
  Eigen::Vector3d center(std::size_t index) const {
    const std::array<int, 3> c = cell(index);
    return spacing_m * Eigen::Vector3d(c[0], c[1], c[2]);
  }
};

/// Marches fronts from cells whose time is 0 through a grid in which each cell has a speed.
class EikonalOracle {
 public:
  /// Speeds in m/s; a cell whose speed is 0 does not belong to the crust.
  EikonalOracle(const RegularGrid& grid, std::vector<double> speeds)
      : grid_(grid), speeds_(std::move(speeds)) {}

  /// Arrival times in s, infinite where no front comes.
  std::vector<double> march(const std::vector<std::size_t>& sources) {
    times_.assign(grid_.size(), kFar);
    dead_.assign(grid_.size(), false);
    for (const std::size_t source : sources) activate(source, 0.0);
    while (!heap_.empty()) {
      const auto [time, cell] = heap_.top();
      heap_.pop();
      if (dead_[cell]) continue;  // pushed again with a lower time, which came first
      dead_[cell] = true;
      for (int axis = 0; axis < 3; ++axis) {
        for (const int step : {-1, 1}) updateNeighbour(cell, axis, step);
      }
    }
    return times_;
  }

 private:
  using Entry = std::pair<double, std::size_t>;
  static constexpr double kFar = std::numeric_limits<double>::infinity();
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  void activate(std::size_t cell, double time) {
    times_[cell] = time;
    heap_.emplace(time, cell);
  }

  void updateNeighbour(std::size_t cell, int axis, int step) {
    const std::size_t next = neighbour(cell, axis, step);
    if (next == kNone || dead_[next] || speeds_[next] <= 0.0) return;
    const double time = solve(next);
    if (time < times_[next]) activate(next, time);
  }

  std::size_t neighbour(std::size_t cell, int axis, int step) const {
    const std::array<int, 3> size = {grid_.nx, grid_.ny, grid_.nz};
    std::array<int, 3> c = grid_.cell(cell);
    const auto a = static_cast<std::size_t>(axis);
    c[a] += step;
    if (c[a] < 0 || c[a] >= size[a]) return kNone;
    return grid_.index(c[0], c[1], c[2]);
  }

  /// T of equation 7: along each axis the lower neighbour counts, if it is lower than T.
  double solve(std::size_t cell) const {
    std::array<double, 3> lower{};
    for (int axis = 0; axis < 3; ++axis) {
      double& least = lower[static_cast<std::size_t>(axis)];
      least = kFar;
      for (const int step : {-1, 1}) {
        const std::size_t next = neighbour(cell, axis, step);
        if (next != kNone) least = std::min(least, times_[next]);
      }
    }
    std::sort(lower.begin(), lower.end());
    const double slowness = grid_.spacing_m / speeds_[cell];
    double time = lower[0] + slowness;
    double sum = lower[0];
    double squares = lower[0] * lower[0];
    for (std::size_t n = 1; n < 3 && lower[n] < time; ++n) {
      // (n+1) T^2 - 2 sum T + squares = slowness^2
      sum += lower[n];
      squares += lower[n] * lower[n];
      const double count = static_cast<double>(n + 1);
      const double root = sum * sum - count * (squares - slowness * slowness);
      time = (sum + std::sqrt(std::max(0.0, root))) / count;
    }
    return time;
  }

  RegularGrid grid_;
  std::vector<double> speeds_;
  std::vector<double> times_;
  std::vector<bool> dead_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap_;
};

/// Distance along a sphere (great circle) around the origin; the points need not lie on it.
inline double sphereDistance(double radius_m, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return radius_m * std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Distance along the corner of the half-planes z = 0, y >= 0 and y = 0, z >= 0, which meet in the
/// x axis: the straight line when one is turned into the plane of the other.
inline double cornerDistance(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double across = (a.y() - a.z()) - (b.y() - b.z());
  return std::hypot(a.x() - b.x(), across);
}

/// Time from a to b in a plane or in space where the speed is speed_at_origin + gradient * x > 0.
inline double linearSpeedTime(double speed_at_origin, double gradient, const Eigen::Vector3d& a,
                              const Eigen::Vector3d& b) {
  const double speed_a = speed_at_origin + gradient * a.x();
  const double speed_b = speed_at_origin + gradient * b.x();
  const double squared = gradient * gradient * (a - b).squaredNorm();
  // acosh(1 + 2 y^2) = 2 asinh(y), which keeps its digits where the two are near each other.
  return 2.0 * std::asinh(0.5 * std::sqrt(squared / (speed_a * speed_b))) / std::abs(gradient);
}

}  // namespace ladar_perception::test
