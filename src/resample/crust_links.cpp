// SPDX-License-Identifier: BSD-3-Clause
#include "crust_links.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"

namespace ladar_perception {
namespace {

// Cells with nearly the same normal are on one surface if the one lies near the other's plane, in
// edges of the larger cell; cells with other normals meet at an edge or a corner.
constexpr float kSameNormal = 0.7F;
constexpr float kPlaneOffset = 0.7F;

struct Place {
  uint64_t key;  // of level 0
  uint32_t level;
  uint32_t index;
};

std::vector<Place> placesInOrder(const std::vector<std::vector<Surfel>>& surfels) {
  std::vector<Place> places;
  for (std::size_t level = 0; level < surfels.size(); ++level) {
    for (std::size_t i = 0; i < surfels[level].size(); ++i) {
      places.push_back({surfels[level][i].key << 3 * level, static_cast<uint32_t>(level),
                        static_cast<uint32_t>(i)});
    }
  }
  if (surfels.size() > 1) {
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
      return a.key != b.key ? a.key < b.key : a.level < b.level;
    });
  }
  return places;
}

class Linker {
 public:
  Linker(const std::vector<std::vector<Surfel>>& surfels, const std::vector<Place>& places,
         Crust* crust)
      : crust_(crust), grids_(surfels.size()), numbers_(surfels.size()) {
    for (std::size_t level = 0; level < surfels.size(); ++level) {
      std::vector<uint64_t> keys;
      keys.reserve(surfels[level].size());
      for (const Surfel& surfel : surfels[level]) keys.push_back(surfel.key);
      grids_[level].assign(std::move(keys));
      numbers_[level].resize(surfels[level].size());
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      numbers_[places[i].level][places[i].index] = static_cast<uint32_t>(i);
    }
  }

  /// Links every cell finds on its own: those of its size, and larger ones.
  void run(ThreadPool* pool) {
    found_.resize(crust_->size());
    for (std::size_t level = 0; level < grids_.size(); ++level) {
      parallelFor(pool, grids_[level].bricks().size(), 256,
                  [&](std::size_t begin, std::size_t end) {
                    SparseGrid::Block block;
                    for (std::size_t brick = begin; brick < end; ++brick) {
                      linkBrick(level, brick, &block);
                    }
                  });
    }
    writeNeighbors();
  }

 private:
  struct Found {
    uint32_t count = 0;
    std::array<uint32_t, 26> cells;
  };

  void linkBrick(std::size_t level, std::size_t brick, SparseGrid::Block* block) {
    const SparseGrid& grid = grids_[level];
    grid.gather(brick, block);
    const uint32_t end = grid.brickEnd(brick);
    for (uint32_t i = grid.bricks()[brick].first; i < end; ++i) {
      const uint64_t key = grid.keys()[i];
      const int x = static_cast<int>(morton::x(key & 63));
      const int y = static_cast<int>(morton::y(key & 63));
      const int z = static_cast<int>(morton::z(key & 63));
      const uint32_t cell = numbers_[level][i];
      for (int dz = -1; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            const auto place =
                static_cast<std::size_t>(SparseGrid::blockIndex(x + dx, y + dy, z + dz));
            const uint32_t other = (*block)[place];
            if (other == i) continue;
            if (other != kNoIndex) {
              link(cell, numbers_[level][other]);
            } else if (level + 1 < grids_.size()) {
              linkAbove(cell, level, key, dx, dy, dz);
            }
          }
        }
      }
    }
  }

  void linkAbove(uint32_t cell, std::size_t level, uint64_t key, int dx, int dy, int dz) {
    key = morton::step(key, morton::kAxisX, dx);
    key = morton::step(key, morton::kAxisY, dy);
    key = morton::step(key, morton::kAxisZ, dz);
    for (std::size_t above = level + 1; above < grids_.size(); ++above) {
      key >>= 3;
      const uint32_t other = grids_[above].find(key);
      if (other == kNoIndex) continue;
      const uint32_t number = numbers_[above][other];
      const Found& found = found_[cell];
      if (std::find(found.cells.begin(), found.cells.begin() + found.count, number) ==
          found.cells.begin() + found.count) {
        link(cell, number);
      }
      return;
    }
  }

  void link(uint32_t a, uint32_t b) {
    const Eigen::Vector3f d = crust_->positions[b] - crust_->positions[a];
    const Eigen::Vector3f& na = crust_->normals[a];
    const Eigen::Vector3f& nb = crust_->normals[b];
    const float cosine = na.dot(nb);
    const float reach = kPlaneOffset * std::max(crust_->edge(a), crust_->edge(b));
    if (cosine < -kSameNormal) return;  // the two sides of a thin wall
    if (cosine > kSameNormal && std::abs(na.dot(d)) > reach && std::abs(nb.dot(d)) > reach) return;
    Found& found = found_[a];
    found.cells[found.count++] = b;
  }

  /// Neighbours of every cell: what it found, then smaller cells that found it.
  void writeNeighbors() {
    std::vector<uint32_t>& first = crust_->first_neighbor;
    const std::size_t size = crust_->size();
    const bool mixed = grids_.size() > 1;
    first.assign(size + 1, 0);
    for (std::size_t i = 0; i < size; ++i) {
      first[i + 1] += found_[i].count;
      for (uint32_t k = 0; mixed && k < found_[i].count; ++k) {
        const uint32_t other = found_[i].cells[k];
        if (crust_->levels[other] > crust_->levels[i]) ++first[other + 1];
      }
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    crust_->neighbors.resize(first[size]);
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < size; ++i) {
      for (uint32_t k = 0; k < found_[i].count; ++k) {
        const uint32_t other = found_[i].cells[k];
        crust_->neighbors[next[i]++] = other;
        if (crust_->levels[other] > crust_->levels[i]) {
          crust_->neighbors[next[other]++] = static_cast<uint32_t>(i);
        }
      }
    }
  }

  Crust* crust_;
  std::vector<SparseGrid> grids_;
  std::vector<std::vector<uint32_t>> numbers_;  // in the crust, by level
  std::vector<Found> found_;
};

}  // namespace

void dropCovered(std::vector<std::vector<Surfel>>* surfels) {
  std::vector<SparseGrid> larger(surfels->size());
  for (std::size_t level = surfels->size(); level-- > 0;) {
    std::vector<Surfel>& cells = (*surfels)[level];
    const auto covered = [&](const Surfel& cell) {
      uint64_t key = cell.key;
      for (std::size_t above = level + 1; above < larger.size(); ++above) {
        key >>= 3;
        if (larger[above].find(key) != kNoIndex) return true;
      }
      return false;
    };
    cells.erase(std::remove_if(cells.begin(), cells.end(), covered), cells.end());
    std::vector<uint64_t> keys;
    for (const Surfel& cell : cells) keys.push_back(cell.key);
    larger[level].assign(std::move(keys));
  }
}

Crust linkCells(const GridFrame& frame, const std::vector<std::vector<Surfel>>& surfels,
                ThreadPool* pool) {
  Crust crust;
  crust.frame = frame;
  const std::vector<Place> places = placesInOrder(surfels);
  crust.keys.reserve(places.size());
  crust.positions.reserve(places.size());
  crust.normals.reserve(places.size());
  crust.slowness.reserve(places.size());
  crust.levels.reserve(places.size());
  for (const Place& place : places) {
    const Surfel& surfel = surfels[place.level][place.index];
    crust.keys.push_back(place.key);
    crust.positions.push_back(surfel.position);
    crust.normals.push_back(surfel.normal);
    crust.slowness.push_back(surfel.slowness);
    crust.levels.push_back(static_cast<uint8_t>(place.level));
  }
  Linker(surfels, places, &crust).run(pool);
  return crust;
}

}  // namespace ladar_perception
