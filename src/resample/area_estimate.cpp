// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/area_estimate.h"

#include <algorithm>
#include <cmath>

#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

constexpr uint32_t kEnough = 4;
// A plane through a grid of cubes meets 1 to 1.7 of them for every one's face, and the least cubes
// with enough points leave gaps: measured on clouds of ladars and on planes.
constexpr double kCubesPerFace = 1.1;
// Points with fewer than four of them in a cube of so many cells are not joined into a surface, but
// get pieces of about 0.75 cells radius: measured, too.
constexpr double kWidestCells = 15.0;
constexpr double kPieceCells = 1.8;
constexpr double kGroupsPerOctave = 4.0;
constexpr double kLeastWeight = 1e-9;

/// Points of a cube: all of them, those with no smaller cube of enough points, and their weight.
struct CubeCount {
  uint64_t key;
  uint32_t points;
  uint32_t open;
  double open_weight;
};

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
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      CubeCount cube = cubes[i];
      if (cube.points >= kEnough && cube.open > 0) {
        const double share = static_cast<double>(cube.open) / cube.points;
        const double weight = std::max(cube.open_weight / cube.open, kLeastWeight);
        add(edge_m * finer, share * stride, static_cast<double>(cube.open * stride), weight);
        cube.open = 0;
        cube.open_weight = 0.0;
      }
      open = open || cube.open > 0;
      cube.key >>= 3;
      if (kept > 0 && cubes[kept - 1].key == cube.key) {
        cubes[kept - 1].points += cube.points;
        cubes[kept - 1].open += cube.open;
        cubes[kept - 1].open_weight += cube.open_weight;
      } else {
        cubes[kept++] = cube;
      }
    }
    cubes.resize(kept);
    if (!open) break;
  }
}

void AreaEstimate::add(double edge_m, double share, double points, double weight) {
  const double seen_m = edge_m * std::sqrt(weight);
  Group& group = groups_[static_cast<int>(std::floor(kGroupsPerOctave * std::log2(seen_m)))];
  group.area_m2 += share * edge_m * edge_m * weight / kCubesPerFace;
  group.points += points;
}

double AreaEstimate::area_m2(double cell_m) const {
  double area_m2 = 0.0;
  for (const auto& [group_number, group] : groups_) {
    // Cubes come in octaves, and gaps in all widths.
    const double octaves = group_number / kGroupsPerOctave - std::log2(kWidestCells * cell_m);
    const double joined = std::clamp(0.5 - octaves, 0.0, 1.0);
    const double apart_m2 = std::min(group.area_m2, group.points * kPieceCells * cell_m * cell_m);
    area_m2 += joined * group.area_m2 + (1.0 - joined) * apart_m2;
  }
  return area_m2;
}

}  // namespace ladar_perception
