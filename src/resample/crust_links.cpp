// SPDX-License-Identifier: BSD-3-Clause
#include "crust_links.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"

namespace ladar_perception {
namespace {

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
      grids_[level].linkBricks();
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
        for (std::size_t run = begin; run < end; ++run) {
          linkRun(level, run * kRun, std::min((run + 1) * kRun, bricks), &runs_[first + run]);
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
  /// Neighbours of a run of cells of one level.
  struct Run {
    std::size_t level = 0;
    uint32_t first_cell = 0;
    std::vector<uint8_t> counts;      // of neighbours of the same level, by cell
    std::vector<uint32_t> neighbors;  // those, one cell's after the other's
    std::vector<Link> above;          // to larger cells
  };

  void linkRun(std::size_t level, std::size_t first_brick, std::size_t last_brick, Run* run) const {
    const SparseGrid& grid = grids_[level];
    run->level = level;
    run->first_cell = grid.bricks()[first_brick].first;
    run->counts.reserve(grid.brickEnd(last_brick - 1) - run->first_cell);
    // Neighbours are written before it is known how many there are.
    constexpr std::size_t kMost = 64 * 27;
    std::size_t size = 0;
    for (std::size_t brick = first_brick; brick < last_brick; ++brick) {
      if (run->neighbors.size() < size + kMost) run->neighbors.resize(2 * size + kMost);
      dispatch([&]() LADAR_INLINE_LAMBDA { size = linkBrick(level, brick, size, run); });
    }
    run->neighbors.resize(size);
  }

  /// Returns how many neighbours the run has then.
  LADAR_INLINE std::size_t linkBrick(std::size_t level, std::size_t brick, std::size_t size,
                                     Run* run) const {
    const SparseGrid& grid = grids_[level];
    const std::vector<uint32_t>& numbers = numbers_[level];
    const bool larger = level + 1 < grids_.size();
    uint32_t cell = grid.bricks()[brick].first;
    for (uint64_t mask = grid.bricks()[brick].mask; mask != 0; mask &= mask - 1, ++cell) {
      const int bit = __builtin_ctzll(mask);
      const std::size_t before = size;
      uint32_t met = 0;
      grid.visitNear<1>(brick, bit, [&](uint32_t other, uint32_t direction, int other_bit) {
        run->neighbors[size] = numbers[other];
        size += other != cell ? 1 : 0;
        if (larger) met |= uint32_t{1} << stepBetween(bit, direction, other_bit);
      });
      run->counts.push_back(static_cast<uint8_t>(size - before));
      if (larger) linkAbove(level, cell, met, run);
    }
    return size;
  }

  /// Links to the larger cells in those steps around a cell that met none of its own size.
  void linkAbove(std::size_t level, uint32_t cell, uint32_t met, Run* run) const {
    const std::size_t first = run->above.size();
    for (int step = 0; step < 27; ++step) {
      if ((met >> step & 1) != 0) continue;
      uint64_t key = morton::around(grids_[level].keys()[cell], step);
      for (std::size_t above = level + 1; above < grids_.size(); ++above) {
        key >>= 3;
        const uint32_t other = grids_[above].find(key);
        if (other == kNoIndex) continue;
        const uint32_t number = numbers_[above][other];
        const auto begin = run->above.begin() + static_cast<std::ptrdiff_t>(first);
        if (std::none_of(begin, run->above.end(), [&](const Link& l) { return l.b == number; })) {
          run->above.push_back({numbers_[level][cell], number});
        }
        break;
      }
    }
  }

  /// Every link is one of both cells.
  void writeNeighbors() {
    std::vector<uint32_t>& first = crust_->first_neighbor;
    first.assign(crust_->size() + 1, 0);
    for (const Run& run : runs_) {
      const uint32_t* numbers = numbers_[run.level].data() + run.first_cell;
      for (std::size_t i = 0; i < run.counts.size(); ++i) first[numbers[i] + 1] += run.counts[i];
      for (const Link& link : run.above) {
        ++first[link.a + 1];
        ++first[link.b + 1];
      }
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    crust_->neighbors.resize(first.back());
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    for (const Run& run : runs_) {
      const uint32_t* numbers = numbers_[run.level].data() + run.first_cell;
      auto from = run.neighbors.begin();
      for (std::size_t i = 0; i < run.counts.size(); ++i, from += run.counts[i - 1]) {
        std::copy_n(from, run.counts[i], crust_->neighbors.begin() + next[numbers[i]]);
        next[numbers[i]] += run.counts[i];
      }
      for (const Link& link : run.above) {
        crust_->neighbors[next[link.a]++] = link.b;
        crust_->neighbors[next[link.b]++] = link.a;
      }
    }
  }

  Crust* crust_;
  std::vector<SparseGrid> grids_;
  std::vector<std::vector<uint32_t>> numbers_;  // in the crust, by level
  std::vector<Run> runs_;
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
