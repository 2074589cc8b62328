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
    levels_[level].grid.linkBricks();
    levels_[level].taken.assign(levels_[level].grid.bricks().size(), 0);
  }
}

void TakenCells::add(uint32_t cell) {
  const std::size_t number = crust_.levels[cell];
  const uint64_t key = crust_.keys[cell] >> 3 * number;
  Level& level = levels_[number];
  level.taken[level.grid.findBrick(key >> 6)] |= uint64_t{1} << (key & 63);
}

void TakenCells::findAround(uint32_t cell, const Eigen::Vector3f& place,
                            std::vector<uint32_t>* cells) const {
  const std::size_t own = crust_.levels[cell];
  const Level& level = levels_[own];
  // The place may lie in another cell, with the sample beyond it out of reach of this one.
  uint64_t key = cellKey(place) >> 3 * own;
  if (level.grid.findBrick(key >> 6) == kNoIndex) key = crust_.keys[cell] >> 3 * own;
  findNear(level, key, cells);
  if (own > 0) findWithin(own - 1, cell, cells);
  if (own + 1 < levels_.size()) findWithin(own + 1, cell, cells);
}

void TakenCells::findNear(const Level& level, uint64_t key, std::vector<uint32_t>* cells) {
  const uint32_t brick = level.grid.findBrick(key >> 6);
  const auto& sides = kNearCells<kReach>.sides[key & 63];
  for (std::size_t i = 0; i < kNearCells<kReach>.count[key & 63]; ++i) {
    const uint32_t near = level.grid.brickAround(brick, sides[i].direction);
    if (near == kNoIndex) continue;
    for (uint64_t mask = level.taken[near] & sides[i].mask; mask != 0; mask &= mask - 1) {
      cells->push_back(level.numbers[level.grid.cellIn(near, __builtin_ctzll(mask))]);
    }
  }
}

void TakenCells::findWithin(std::size_t number, uint32_t cell, std::vector<uint32_t>* cells) const {
  const Level& level = levels_[number];
  const uint64_t key = crust_.keys[cell];
  const uint32_t edge = uint32_t{1} << crust_.levels[cell];
  const int brick_shift = static_cast<int>(number) + 2;
  const BrickRange x(morton::x(key), edge, brick_shift);
  const BrickRange y(morton::y(key), edge, brick_shift);
  const BrickRange z(morton::z(key), edge, brick_shift);
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

}  // namespace ladar_perception
