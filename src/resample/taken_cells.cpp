// SPDX-License-Identifier: BSD-3-Clause
#include "taken_cells.h"

#include <algorithm>

#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

// Of the cells in reach of a brick's there may be some of half and of twice their edges.
constexpr uint8_t kSmaller = 1;
constexpr uint8_t kLarger = 2;

/// Bricks along an axis that are within reach of a cell, all in cells of the finest size.
struct BrickRange {
  uint32_t low;
  uint32_t high;

  BrickRange(uint32_t cell, uint32_t edge, int brick_shift)
      : low((cell - std::min(cell, TakenCells::kReach * edge)) >> brick_shift),
        high((cell + (TakenCells::kReach + 1) * edge - 1) >> brick_shift) {}
};

}  // namespace

TakenCells::TakenCells(const Crust& crust) : crust_(crust), bricks_(crust.size()) {
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
    Level& here = levels_[level];
    here.taken.assign(here.grid.bricks().size(), 0);
    here.edge.assign(here.grid.bricks().size(), 0);
    for (uint32_t brick = 0; brick < here.taken.size(); ++brick) {
      for (uint32_t i = here.grid.bricks()[brick].first; i < here.grid.brickEnd(brick); ++i) {
        bricks_[here.numbers[i]] = brick;
      }
    }
  }
  for (std::size_t level = 0; level + 1 < levels_.size(); ++level) markEdges(level);
}

void TakenCells::markEdges(std::size_t number) {
  Level& small = levels_[number];
  Level& large = levels_[number + 1];
  const std::vector<SparseGrid::Brick>& bricks = small.grid.bricks();
  for (std::size_t begin = 0, end = 0; begin < bricks.size(); begin = end) {
    // A large brick is as wide as two small ones, and reaches are less than a brick.
    const uint64_t key = bricks[begin].key >> 3;
    while (end < bricks.size() && bricks[end].key >> 3 == key) ++end;
    for (int step = 0; step < 27; ++step) {
      const uint32_t near = large.grid.findBrick(morton::around(key, step));
      if (near == kNoIndex) continue;
      large.edge[near] |= kSmaller;
      for (std::size_t i = begin; i < end; ++i) small.edge[i] |= kLarger;
    }
  }
}

void TakenCells::add(uint32_t cell) {
  const std::size_t level = crust_.levels[cell];
  const uint64_t bit = crust_.keys[cell] >> 3 * level & 63;
  levels_[level].taken[bricks_[cell]] |= uint64_t{1} << bit;
}

void TakenCells::findAround(uint32_t cell, const Eigen::Vector3f& place,
                            std::vector<uint32_t>* cells) const {
  const std::size_t own = crust_.levels[cell];
  const Level& level = levels_[own];
  // The place may lie in another cell, with the sample beyond it out of reach of this one.
  const uint64_t own_key = crust_.keys[cell] >> 3 * own;
  const uint64_t key = cellKey(place) >> 3 * own;
  const uint32_t brick = key >> 6 == own_key >> 6 ? bricks_[cell] : level.grid.findBrick(key >> 6);
  if (brick != kNoIndex) {
    findNear(level, brick, key & 63, cells);
  } else {
    findNear(level, bricks_[cell], own_key & 63, cells);
  }
  const uint8_t edge = level.edge[bricks_[cell]];
  if ((edge & kSmaller) != 0) findWithin(own - 1, cell, cells);
  if ((edge & kLarger) != 0) findWithin(own + 1, cell, cells);
}

void TakenCells::findNear(const Level& level, uint32_t brick, uint64_t bit,
                          std::vector<uint32_t>* cells) {
  const auto& sides = kNearCells<kReach>.sides[bit];
  for (std::size_t i = 0; i < kNearCells<kReach>.count[bit]; ++i) {
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
