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

/// Steps in a block to the 27 cells around one, itself included, x fastest.
constexpr std::array<int, 27> stepsInBlock() {
  std::array<int, 27> steps{};
  for (int n = 0; n < 27; ++n) {
    steps[static_cast<std::size_t>(n)] =
        SparseGrid::blockIndex(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1) -
        SparseGrid::blockIndex(0, 0, 0);
  }
  return steps;
}
constexpr std::array<int, 27> kSteps = stepsInBlock();

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

  void run(ThreadPool* pool) {
    // Runs of bricks give runs of links, whoever works on them.
    constexpr std::size_t kRun = 512;
    for (std::size_t level = 0; level < grids_.size(); ++level) {
      const std::size_t bricks = grids_[level].bricks().size();
      const std::size_t first = runs_.size();
      runs_.resize(first + (bricks + kRun - 1) / kRun);
      parallelFor(pool, runs_.size() - first, 1, [&](std::size_t begin, std::size_t end) {
        SparseGrid::Block block;
        for (std::size_t run = begin; run < end; ++run) {
          std::vector<Link>* links = &runs_[first + run];
          for (std::size_t brick = run * kRun; brick < std::min((run + 1) * kRun, bricks);
               ++brick) {
            linkBrick(level, brick, &block, links);
          }
        }
      });
    }
    writeNeighbors();
  }

 private:
  struct Link {
    uint32_t a;
    uint32_t b;
  };

  /// Links to half of the neighbours of this size, which do not find this one, and to larger ones.
  void linkBrick(std::size_t level, std::size_t brick, SparseGrid::Block* block,
                 std::vector<Link>* links) const {
    const SparseGrid& grid = grids_[level];
    const std::vector<uint32_t>& numbers = numbers_[level];
    grid.gather(brick, block);
    const uint32_t end = grid.brickEnd(brick);
    for (uint32_t i = grid.bricks()[brick].first; i < end; ++i) {
      const uint64_t bit = grid.keys()[i] & 63;
      const int middle =
          SparseGrid::blockIndex(static_cast<int>(morton::x(bit)), static_cast<int>(morton::y(bit)),
                                 static_cast<int>(morton::z(bit)));
      for (std::size_t step = kSteps.size() / 2 + 1; step < kSteps.size(); ++step) {
        const uint32_t other = (*block)[static_cast<std::size_t>(middle + kSteps[step])];
        if (other != kNoIndex) links->push_back({numbers[i], numbers[other]});
      }
      if (level + 1 == grids_.size()) continue;
      const std::size_t first_link = links->size();
      for (std::size_t step = 0; step < kSteps.size(); ++step) {
        if ((*block)[static_cast<std::size_t>(middle + kSteps[step])] == kNoIndex) {
          linkAbove(numbers[i], level, i, step, first_link, links);
        }
      }
    }
  }

  void linkAbove(uint32_t cell, std::size_t level, uint32_t index, std::size_t step,
                 std::size_t first_link, std::vector<Link>* links) const {
    const auto n = static_cast<int>(step);
    uint64_t key = grids_[level].keys()[index];
    key = morton::step(key, morton::kAxisX, n % 3 - 1);
    key = morton::step(key, morton::kAxisY, n / 3 % 3 - 1);
    key = morton::step(key, morton::kAxisZ, n / 9 - 1);
    for (std::size_t above = level + 1; above < grids_.size(); ++above) {
      key >>= 3;
      const uint32_t other = grids_[above].find(key);
      if (other == kNoIndex) continue;
      const uint32_t number = numbers_[above][other];
      const auto begin = links->begin() + static_cast<std::ptrdiff_t>(first_link);
      if (std::none_of(begin, links->end(), [&](const Link& l) { return l.b == number; })) {
        links->push_back({cell, number});
      }
      return;
    }
  }

  /// Every link is one of both cells.
  void writeNeighbors() {
    std::vector<uint32_t>& first = crust_->first_neighbor;
    first.assign(crust_->size() + 1, 0);
    for (const std::vector<Link>& links : runs_) {
      for (const Link& link : links) {
        ++first[link.a + 1];
        ++first[link.b + 1];
      }
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    crust_->neighbors.resize(first.back());
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    for (const std::vector<Link>& links : runs_) {
      for (const Link& link : links) {
        crust_->neighbors[next[link.a]++] = link.b;
        crust_->neighbors[next[link.b]++] = link.a;
      }
    }
  }

  Crust* crust_;
  std::vector<SparseGrid> grids_;
  std::vector<std::vector<uint32_t>> numbers_;  // in the crust, by level
  std::vector<std::vector<Link>> runs_;
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
