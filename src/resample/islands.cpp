// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/islands.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/sparse_grid.h"

namespace ladar_perception {
namespace {

/// Union of sets, with halving of paths.
class Sets {
 public:
  explicit Sets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), uint32_t{0});
  }
  uint32_t find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The least number names the set.
  void unite(uint32_t a, uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parent_;
};

/// Cubes that hold points, and for each the first of its points, with an end.
struct Cubes {
  SparseGrid grid;
  std::vector<uint32_t> first_point;

  Cubes(const GridPoints& points, int level) {
    std::vector<uint64_t> keys;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const uint64_t key = points.keys[i] >> 3 * level;
      if (!keys.empty() && keys.back() == key) continue;
      keys.push_back(key);
      first_point.push_back(static_cast<uint32_t>(i));
    }
    first_point.push_back(static_cast<uint32_t>(points.size()));
    grid.assign(std::move(keys));
  }
};

Sets touchingCubes(const SparseGrid& cubes) {
  Sets sets(cubes.size());
  for (uint32_t i = 0; i < cubes.size(); ++i) {
    // Half of the neighbours: the others find this one.
    for (int step = 14; step < 27; ++step) {
      const uint32_t other = cubes.find(morton::around(cubes.keys()[i], step));
      if (other != kNoIndex) sets.unite(i, other);
    }
  }
  return sets;
}

void keepPoints(const std::vector<uint8_t>& kept, GridPoints* points) {
  std::size_t size = 0;
  for (std::size_t i = 0; i < points->size(); ++i) {
    if (kept[i] == 0) continue;
    points->keys[size] = points->keys[i];
    points->sources[size] = points->sources[i];
    points->positions[size++] = points->positions[i];
  }
  points->keys.resize(size);
  points->sources.resize(size);
  points->positions.resize(size);
}

}  // namespace

Islands dropSmallIslands(int level, std::size_t least_points, std::size_t most,
                         GridPoints* points) {
  const Cubes cubes(*points, level);
  Sets sets = touchingCubes(cubes.grid);
  std::vector<std::size_t> sizes(cubes.grid.size(),
                                 0);  // points, by the number that names the island
  for (uint32_t i = 0; i < cubes.grid.size(); ++i) {
    sizes[sets.find(i)] += cubes.first_point[i + 1] - cubes.first_point[i];
  }
  std::vector<uint32_t> islands;
  for (uint32_t i = 0; i < cubes.grid.size(); ++i) {
    if (sizes[i] > 0) islands.push_back(i);
  }
  std::stable_sort(islands.begin(), islands.end(),
                   [&](uint32_t a, uint32_t b) { return sizes[a] > sizes[b]; });
  Islands result;
  result.kept = islands.size();
  if (!islands.empty() && sizes[islands.front()] >= least_points) {
    while (sizes[islands[result.kept - 1]] < least_points) --result.kept;
  }
  if (most > 0) result.kept = std::min(result.kept, most);
  result.dropped = islands.size() - result.kept;
  if (result.dropped == 0) return result;
  std::vector<uint8_t> island_kept(cubes.grid.size(), 0);
  for (std::size_t i = 0; i < result.kept; ++i) island_kept[islands[i]] = 1;
  std::vector<uint8_t> point_kept(points->size());
  for (uint32_t i = 0; i < cubes.grid.size(); ++i) {
    std::fill(point_kept.begin() + cubes.first_point[i],
              point_kept.begin() + cubes.first_point[i + 1], island_kept[sets.find(i)]);
  }
  keepPoints(point_kept, points);
  return result;
}

std::size_t dropLonePoints(int level, float radius, std::size_t most, GridPoints* points) {
  const Cubes cubes(*points, level);
  const auto isNear = [&](std::size_t point, uint32_t cube) {
    if (cube == kNoIndex) return false;
    for (uint32_t i = cubes.first_point[cube]; i < cubes.first_point[cube + 1]; ++i) {
      const float distance2 = (points->positions[i] - points->positions[point]).squaredNorm();
      if (i != point && distance2 <= radius * radius) return true;
    }
    return false;
  };
  std::vector<uint8_t> kept(points->size(), 1);
  std::size_t dropped = 0;
  for (uint32_t cube = 0; cube < cubes.grid.size(); ++cube) {
    for (std::size_t i = cubes.first_point[cube]; i < cubes.first_point[cube + 1]; ++i) {
      // Two in a cube of half the edge are near enough.
      const uint64_t half = points->keys[i] >> 3 * (level - 1);
      if (i > 0 && points->keys[i - 1] >> 3 * (level - 1) == half) continue;
      if (i + 1 < points->size() && points->keys[i + 1] >> 3 * (level - 1) == half) continue;
      bool lone = !isNear(i, cube);
      for (int step = 0; lone && step < 27; ++step) {
        lone = step == 13 ||
               !isNear(i, cubes.grid.find(morton::around(cubes.grid.keys()[cube], step)));
      }
      if (!lone) continue;
      kept[i] = 0;
      if (++dropped > most) return 0;
    }
  }
  if (dropped > 0) keepPoints(kept, points);
  return dropped;
}

}  // namespace ladar_perception
