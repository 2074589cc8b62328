// SPDX-License-Identifier: BSD-3-Clause
#include "taken_cells.h"

#include <algorithm>

#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

/// Bricks along an axis that are within reach of a cell, all in cells of the finest size.
struct BrickRange {
  uint32_t low;
  uint32_t high;

  BrickRange(uint32_t cell, uint32_t edge, int brick_shift)
      : low((cell - std::min(cell, TakenCells::kReach * edge)) >> brick_shift),
        high((cell + (TakenCells::kReach + 1) * edge - 1) >> brick_shift) {}
};

}  // namespace

TakenCells::TakenCells(const Crust& crust) : crust_(crust) {
  std::vector<std::vector<uint64_t>> keys;
  for (uint32_t cell = 0; cell < crust.size(); ++cell) {
    const std::size_t level = crust.levels[cell];
    if (level >= levels_.size()) {
      levels_.resize(level + 1);
      keys.resize(level + 1);
    }
    keys[level].push_back(crust.keys[cell] >> 3 * level);
    levels_[level].numbers.push_back(cell);
  }
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    levels_[level].grid.assign(std::move(keys[level]));
    levels_[level].taken.assign(levels_[level].grid.bricks().size(), 0);
  }
}

void TakenCells::add(uint32_t cell) {
  const std::size_t number = crust_.levels[cell];
  const uint64_t key = crust_.keys[cell] >> 3 * number;
  Level& level = levels_[number];
  level.taken[level.grid.findBrick(key >> 6)] |= uint64_t{1} << (key & 63);
}

void TakenCells::findAround(uint32_t cell, std::vector<uint32_t>* cells) const {
  const int own = crust_.levels[cell];
  const uint64_t key = crust_.keys[cell];
  const uint32_t edge = uint32_t{1} << own;
  const int last = std::min(own + 1, static_cast<int>(levels_.size()) - 1);
  for (int number = std::max(own - 1, 0); number <= last; ++number) {
    const Level& level = levels_[static_cast<std::size_t>(number)];
    const BrickRange x(morton::x(key), edge, number + 2);
    const BrickRange y(morton::y(key), edge, number + 2);
    const BrickRange z(morton::z(key), edge, number + 2);
    for (uint32_t bz = z.low; bz <= z.high; ++bz) {
      for (uint32_t by = y.low; by <= y.high; ++by) {
        for (uint32_t bx = x.low; bx <= x.high; ++bx) {
          const uint32_t brick = level.grid.findBrick(morton::encode(bx, by, bz));
          if (brick == kNoIndex) continue;
          for (uint64_t mask = level.taken[brick]; mask != 0; mask &= mask - 1) {
            cells->push_back(level.numbers[level.grid.cellIn(brick, __builtin_ctzll(mask))]);
          }
        }
      }
    }
  }
}

}  // namespace ladar_perception
