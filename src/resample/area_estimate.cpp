// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/area_estimate.h"

#include <algorithm>
#include <cmath>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/surface_fit.h"

namespace ladar_perception {
namespace {

constexpr uint32_t kEnough = 4;
// A plane through a grid of cubes meets 1 to 1.7 of them for every one's face, and the least cubes
// with enough points leave gaps.
constexpr double kCubesPerFace = 0.985;
// Cubes up to so many cells wide are joined into a surface, those in thick places only if they are
// small: gaps are bridged by planes. Points in others get pieces of about 0.75 cells radius. All
// measured, on clouds of ladars and on planes.
constexpr double kWidestCells = 20.0;
constexpr double kWidestThickCells = 4.0;
constexpr double kThinCells = 0.5;
constexpr double kPieceCells = 1.8;
constexpr double kGroupsPerOctave = 4.0;
constexpr double kLeastWeight = 1e-9;
// Of a cube's edge: what is thinner is all alike.
constexpr double kThinnest = 1e-3;

/// Points of a cube: all of them, those with no smaller cube of enough points, and their weight.
struct CubeCount {
  uint64_t key;
  uint32_t points;
  uint32_t open;
  double open_weight;
};

/// Standard deviation of some points from their plane, in cells.
double thickness(const GridPoints& points, std::size_t first, std::size_t count) {
  const Eigen::Vector3f middle = points.positions[first + count / 2];
  PointSums sums;
  for (std::size_t i = first; i < first + count; ++i) sums.add(points.positions[i] - middle, 1.0F);
  return std::sqrt(std::max(double{fitPlane(sums).l0}, 0.0));
}

}  // namespace

AreaEstimate::AreaEstimate(const GridPoints& points, const std::vector<float>& weights,
                           std::size_t stride) {
  const double finer = 1.0 / std::sqrt(static_cast<double>(stride));
  std::vector<CubeCount> cubes;
  cubes.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cubes.empty() || cubes.back().key != points.keys[i])
      cubes.push_back({points.keys[i], 0, 0, 0.0});
    ++cubes.back().points;
    ++cubes.back().open;
    cubes.back().open_weight += weights.empty() ? 1.0 : double{weights[points.sources[i]]};
  }
  double edge_m = points.frame.cell_m;
  for (int level = 0; level < morton::kBitsPerAxis && !cubes.empty(); ++level, edge_m *= 2.0) {
    std::size_t kept = 0;
    bool open = false;
    std::size_t first_point = 0;
    for (std::size_t begin = 0, end = 0; begin < cubes.size(); begin = end) {
      // The cubes of one of the next level.
      CubeCount parent{cubes[begin].key >> 3, 0, 0, 0.0};
      bool closing = false;
      for (; end < cubes.size() && cubes[end].key >> 3 == parent.key; ++end) {
        parent.points += cubes[end].points;
        closing = closing || (cubes[end].points >= kEnough && cubes[end].open > 0);
      }
      const double thickness_m =
          closing ? points.frame.cell_m * thickness(points, first_point, parent.points) : 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        const CubeCount& cube = cubes[i];
        if (cube.points >= kEnough && cube.open > 0) {
          const double share = static_cast<double>(cube.open) / cube.points;
          const double weight = std::max(cube.open_weight / cube.open, kLeastWeight);
          add(edge_m * finer, thickness_m, share * stride, static_cast<double>(cube.open * stride),
              weight);
        } else {
          parent.open += cube.open;
          parent.open_weight += cube.open_weight;
        }
      }
      first_point += parent.points;
      open = open || parent.open > 0;
      cubes[kept++] = parent;
    }
    cubes.resize(kept);
    if (!open) break;
  }
}

void AreaEstimate::add(double edge_m, double thickness_m, double share, double points,
                       double weight) {
  const auto bin = [&](double length_m) {
    return static_cast<int>(std::floor(kGroupsPerOctave * std::log2(length_m * std::sqrt(weight))));
  };
  Group& group = groups_[{bin(edge_m), bin(std::max(thickness_m, kThinnest * edge_m))}];
  group.area_m2 += share * edge_m * edge_m * weight / kCubesPerFace;
  group.points += points;
}

double AreaEstimate::area_m2(double cell_m) const {
  double area_m2 = 0.0;
  for (const auto& [bins, group] : groups_) {
    // Cubes come in octaves, and gaps in all widths.
    const bool thin = bins.second / kGroupsPerOctave < std::log2(kThinCells * cell_m);
    const double widest_m = (thin ? kWidestCells : kWidestThickCells) * cell_m;
    const double octaves = bins.first / kGroupsPerOctave - std::log2(widest_m);
    const double joined = std::clamp(0.5 - octaves, 0.0, 1.0);
    const double apart_m2 = std::min(group.area_m2, group.points * kPieceCells * cell_m * cell_m);
    area_m2 += joined * group.area_m2 + (1.0 - joined) * apart_m2;
  }
  return area_m2;
}

}  // namespace ladar_perception
