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
  std::vector<uint64_t> keys;
  std::vector<uint32_t> first_point;
  for (std::size_t i = 0; i < points->size(); ++i) {
    const uint64_t key = points->keys[i] >> 3 * level;
    if (!keys.empty() && keys.back() == key) continue;
    keys.push_back(key);
    first_point.push_back(static_cast<uint32_t>(i));
  }
  first_point.push_back(static_cast<uint32_t>(points->size()));
  SparseGrid cubes;
  cubes.assign(std::move(keys));
  Sets sets = touchingCubes(cubes);
  std::vector<std::size_t> sizes(cubes.size(), 0);  // points, by the number that names the island
  for (uint32_t i = 0; i < cubes.size(); ++i) {
    sizes[sets.find(i)] += first_point[i + 1] - first_point[i];
  }
  std::vector<uint32_t> islands;
  for (uint32_t i = 0; i < cubes.size(); ++i) {
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
  std::vector<uint8_t> island_kept(cubes.size(), 0);
  for (std::size_t i = 0; i < result.kept; ++i) island_kept[islands[i]] = 1;
  std::vector<uint8_t> point_kept(points->size());
  for (uint32_t i = 0; i < cubes.size(); ++i) {
    std::fill(point_kept.begin() + first_point[i], point_kept.begin() + first_point[i + 1],
              island_kept[sets.find(i)]);
  }
  keepPoints(point_kept, points);
  return result;
}

}  // namespace ladar_perception
