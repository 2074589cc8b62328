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

using Numbers = std::vector<std::vector<uint32_t>>;

/// Numbers the surfels of all levels in the order of their keys of level 0.
Numbers numbersInOrder(const std::vector<std::vector<Surfel>>& surfels) {
  Numbers numbers(surfels.size());
  std::size_t size = 0;
  for (std::size_t level = 0; level < surfels.size(); ++level) {
    numbers[level].reserve(surfels[level].size());
    size += surfels[level].size();
  }
  for (uint32_t number = 0; number < size; ++number) {
    std::size_t first = 0;
    uint64_t least = ~uint64_t{0};
    for (std::size_t level = 0; level < surfels.size(); ++level) {
      const std::size_t next = numbers[level].size();
      if (next == surfels[level].size() || surfels[level][next].key << 3 * level >= least) continue;
      first = level;
      least = surfels[level][next].key << 3 * level;
    }
    numbers[first].push_back(number);
  }
  return numbers;
}

class Linker {
 public:
  Linker(const std::vector<std::vector<Surfel>>& surfels, const Numbers& numbers, ThreadPool* pool,
         Crust* crust)
      : numbers_(numbers), pool_(pool), crust_(crust), grids_(surfels.size()) {
    for (std::size_t level = 0; level < surfels.size(); ++level) {
      std::vector<uint64_t> keys;
      keys.reserve(surfels[level].size());
      for (const Surfel& surfel : surfels[level]) keys.push_back(surfel.key);
      grids_[level].assign(std::move(keys));
      grids_[level].linkBricks();
    }
  }

  /// Counts neighbours, then writes them to where they belong.
  void run() {
    std::vector<std::vector<Run>> levels;
    for (std::size_t level = 0; level < grids_.size(); ++level) levels.push_back(runsOf(level));
    std::vector<uint32_t>& first = crust_->first_neighbor;
    first.assign(crust_->size() + 1, 0);
    for (std::vector<Run>& runs : levels) {
      inParallel(&runs, [this](Run* run) { countRun(run); });
    }
    for (const std::vector<Run>& runs : levels) {
      for (const Run& run : runs) {
        for (const Link& link : run.above) {
          ++first[link.a + 1];
          ++first[link.b + 1];
        }
      }
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    crust_->neighbors.resize(first.back());
    next_.assign(first.begin(), first.end() - 1);
    for (std::vector<Run>& runs : levels) {
      inParallel(&runs, [this](Run* run) { writeRun(*run); });
      // Every link is one of both cells.
      for (const Run& run : runs) {
        for (const Link& link : run.above) {
          crust_->neighbors[next_[link.a]++] = link.b;
          crust_->neighbors[next_[link.b]++] = link.a;
        }
      }
    }
  }

 private:
  struct Link {
    uint32_t a;
    uint32_t b;
  };
  /// Bricks [first, last) of one level.
  struct Run {
    std::size_t level;
    std::size_t first;
    std::size_t last;
    std::vector<Link> above;  ///< to larger cells
  };

  std::vector<Run> runsOf(std::size_t level) const {
    constexpr std::size_t kRun = 512;
    const std::size_t bricks = grids_[level].bricks().size();
    std::vector<Run> runs;
    for (std::size_t first = 0; first < bricks; first += kRun) {
      runs.push_back({level, first, std::min(first + kRun, bricks), {}});
    }
    return runs;
  }

  template <typename Work>
  void inParallel(std::vector<Run>* runs, const Work& work) {
    parallelFor(pool_, runs->size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        dispatch([&]() LADAR_INLINE_LAMBDA { work(&(*runs)[i]); });
      }
    });
  }

  /// Calls visit(cell, bit) for all cells of a brick.
  template <typename Visit>
  static LADAR_INLINE void visitCells(const SparseGrid::Brick& brick, const Visit& visit) {
    uint32_t cell = brick.first;
    for (uint64_t mask = brick.mask; mask != 0; mask &= mask - 1, ++cell) {
      visit(cell, __builtin_ctzll(mask));
    }
  }

  LADAR_INLINE void countRun(Run* run) {
    const SparseGrid& grid = grids_[run->level];
    for (std::size_t brick = run->first; brick < run->last; ++brick) {
      const uint32_t levels = levelsNear(run->level, grid.bricks()[brick].key);
      visitCells(grid.bricks()[brick], [&](uint32_t cell, int bit) LADAR_INLINE_LAMBDA {
        const uint32_t number = numbers_[run->level][cell];
        crust_->first_neighbor[number + 1] = grid.countNear<1>(brick, bit) - 1;
        if (levels != 0) linkAbove(brick, cell, bit, levels, run);
      });
    }
  }

  /// The levels of larger cells, a bit each, that have bricks where a cell may touch those of a
  /// brick: few bricks have any.
  uint32_t levelsNear(std::size_t level, uint64_t brick_key) const {
    const std::array<uint32_t, 3> brick = {morton::x(brick_key), morton::y(brick_key),
                                           morton::z(brick_key)};
    uint32_t near = 0;
    for (std::size_t above = level + 1; above < grids_.size(); ++above) {
      const auto shift = static_cast<int>(above - level) + 2;
      std::array<uint32_t, 3> low{};
      std::array<uint32_t, 3> high{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = (4 * brick[axis] - 1) >> shift;
        high[axis] = (4 * brick[axis] + 4) >> shift;
      }
      for (uint32_t z = low[2]; z <= high[2]; ++z) {
        for (uint32_t y = low[1]; y <= high[1]; ++y) {
          for (uint32_t x = low[0]; x <= high[0]; ++x) {
            if (grids_[above].findBrick(morton::encode(x, y, z)) != kNoIndex) near |= 1U << above;
          }
        }
      }
    }
    return near;
  }

  LADAR_INLINE void writeRun(const Run& run) {
    const SparseGrid& grid = grids_[run.level];
    const std::vector<uint32_t>& numbers = numbers_[run.level];
    for (std::size_t brick = run.first; brick < run.last; ++brick) {
      visitCells(grid.bricks()[brick], [&](uint32_t cell, int bit) LADAR_INLINE_LAMBDA {
        uint32_t* next = &next_[numbers[cell]];
        grid.visitNear<1>(brick, bit, [&](uint32_t other, auto...) LADAR_INLINE_LAMBDA {
          if (other != cell) crust_->neighbors[(*next)++] = numbers[other];
        });
      });
    }
  }

  /// Links to the larger cells of those levels in the steps around a cell that meet none of its own
  /// size.
  void linkAbove(std::size_t brick, uint32_t cell, int bit, uint32_t levels, Run* run) const {
    const SparseGrid& grid = grids_[run->level];
    uint32_t met = 0;
    grid.visitNear<1>(brick, bit, [&](uint32_t, uint32_t direction, int other_bit) {
      met |= uint32_t{1} << stepBetween(bit, direction, other_bit);
    });
    const std::size_t first = run->above.size();
    for (int step = 0; step < 27; ++step) {
      if ((met >> step & 1) != 0) continue;
      uint64_t key = morton::around(grid.keys()[cell], step);
      for (std::size_t above = run->level + 1; above < grids_.size(); ++above) {
        key >>= 3;
        if ((levels >> above & 1) == 0) continue;
        const uint32_t other = grids_[above].find(key);
        if (other == kNoIndex) continue;
        const uint32_t number = numbers_[above][other];
        const auto begin = run->above.begin() + static_cast<std::ptrdiff_t>(first);
        if (std::none_of(begin, run->above.end(), [&](const Link& l) { return l.b == number; })) {
          run->above.push_back({numbers_[run->level][cell], number});
        }
        break;
      }
    }
  }

  const Numbers& numbers_;  // in the crust, by level
  ThreadPool* pool_;
  Crust* crust_;
  std::vector<SparseGrid> grids_;
  std::vector<uint32_t> next_;  // by cell of the crust: where its next neighbour is to be written
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
  const Numbers numbers = numbersInOrder(surfels);
  std::size_t size = 0;
  for (const std::vector<Surfel>& of_level : surfels) size += of_level.size();
  Crust crust;
  crust.frame = frame;
  crust.keys.resize(size);
  crust.positions.resize(size);
  crust.normals.resize(size);
  crust.slowness.resize(size);
  crust.levels.resize(size);
  for (std::size_t level = 0; level < surfels.size(); ++level) {
    parallelFor(pool, surfels[level].size(), 16384, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Surfel& surfel = surfels[level][i];
        const uint32_t number = numbers[level][i];
        crust.keys[number] = surfel.key << 3 * level;
        crust.positions[number] = surfel.position;
        crust.normals[number] = surfel.normal;
        crust.slowness[number] = surfel.slowness;
        crust.levels[number] = static_cast<uint8_t>(level);
      }
    });
  }
  Linker(surfels, numbers, pool, &crust).run();
  return crust;
}

}  // namespace ladar_perception
