// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

constexpr uint32_t kNoIndex = 0xffffffffU;

/// Which cells of the bricks around a cell are at most `kReach` steps (1 or 2) from it, the cell
/// itself among them.
template <int kReach>
struct NearCells {
  /// Some cells of the brick in one of 27 directions, x fastest; 13 is the cell's own.
  struct Side {
    uint64_t mask = 0;
    uint32_t direction = 0;
  };
  std::array<std::array<Side, 8>, 64> sides{};
  std::array<uint8_t, 64> count{};

  constexpr NearCells() {
    for (std::size_t bit = 0; bit < 64; ++bit) {
      for (uint32_t direction = 0; direction < 27; ++direction) {
        const auto d = static_cast<int>(direction);
        const uint64_t mask = near(0, morton::x(bit), d % 3 - 1) &
                              near(1, morton::y(bit), d / 3 % 3 - 1) &
                              near(2, morton::z(bit), d / 9 - 1);
        if (mask != 0) sides[bit][count[bit]++] = {mask, direction};
      }
    }
  }

 private:
  /// Of the brick `side` bricks on: cells whose coordinate is near to the one of a cell here.
  static constexpr uint64_t near(int axis, uint32_t coordinate, int side) {
    uint64_t mask = 0;
    for (int bit = 0; bit < 64; ++bit) {
      const auto there = static_cast<int>(morton::compact(static_cast<uint64_t>(bit) >> axis));
      const int steps = there + 4 * side - static_cast<int>(coordinate);
      if (-kReach <= steps && steps <= kReach) mask |= uint64_t{1} << bit;
    }
    return mask;
  }
};
template <int kReach>
inline constexpr NearCells<kReach> kNearCells;

/// A set of grid cells, numbered in the order of their Morton keys and kept as bricks of 4^3: a bit
/// per cell, so that a cell's number is the brick's first plus the bits below.
class SparseGrid {
 public:
  static constexpr int kBlockEdge = 6;  ///< of a brick with one cell around it
  static constexpr int kBlockCells = kBlockEdge * kBlockEdge * kBlockEdge;
  /// Numbers of the cells of a brick and around it, kNoIndex where there is none.
  using Block = std::array<uint32_t, kBlockCells>;
  /// Place in a block of the cell (x, y, z), each in [-1, 4].
  static constexpr int blockIndex(int x, int y, int z) {
    return ((z + 1) * kBlockEdge + y + 1) * kBlockEdge + x + 1;
  }

  struct Brick {
    uint64_t key = 0;  ///< Morton key of its cells, less the lowest 6 bits
    uint64_t mask = 0;
    uint32_t first = 0;
  };

  /// `keys` ascend strictly.
  void assign(std::vector<uint64_t> keys);

  std::size_t size() const { return keys_.size(); }
  const std::vector<uint64_t>& keys() const { return keys_; }
  const std::vector<Brick>& bricks() const { return bricks_; }
  uint32_t brickEnd(std::size_t brick) const {
    return brick + 1 < bricks_.size() ? bricks_[brick + 1].first
                                      : static_cast<uint32_t>(keys_.size());
  }
  /// Number of the cell with that key, or kNoIndex.
  uint32_t find(uint64_t key) const {
    const uint32_t brick = findBrick(key >> 6);
    return brick == kNoIndex ? kNoIndex : cellOf(bricks_[brick], static_cast<int>(key & 63));
  }
  /// Number of the brick with that key, or kNoIndex.
  uint32_t findBrick(uint64_t brick_key) const {
    for (uint64_t slot = slotOf(brick_key);; slot = (slot + 1) & slot_mask_) {
      const uint32_t brick = slots_[slot];
      if (brick == kNoIndex || bricks_[brick].key == brick_key) return brick;
    }
  }
  /// Number of the cell at a bit of a brick, or kNoIndex.
  uint32_t cellIn(uint32_t brick, int bit) const { return cellOf(bricks_[brick], bit); }
  /// Finds the bricks around every brick, for what follows.
  void linkBricks();
  /// Number of the brick in one of 27 directions (x fastest, 13 the brick itself), or kNoIndex.
  uint32_t brickAround(std::size_t brick, uint32_t direction) const {
    return around_[brick][direction];
  }
  /// Calls visit(number, direction of its brick, bit in it) for all cells at most kReach steps from
  /// the one at a bit of a brick, itself included.
  template <int kReach, typename Visit>
  LADAR_INLINE void visitNear(std::size_t brick, int bit, const Visit& visit) const {
    const auto b = static_cast<std::size_t>(bit);
    const auto& sides = kNearCells<kReach>.sides[b];
    for (std::size_t i = 0; i < kNearCells<kReach>.count[b]; ++i) {
      const uint32_t near = around_[brick][sides[i].direction];
      if (near == kNoIndex) continue;
      const Brick& other = bricks_[near];
      for (uint64_t mask = other.mask & sides[i].mask; mask != 0; mask &= mask - 1) {
        const uint64_t below = (mask & (~mask + 1)) - 1;
        visit(other.first + static_cast<uint32_t>(__builtin_popcountll(other.mask & below)),
              sides[i].direction, __builtin_ctzll(mask));
      }
    }
  }
  /// The cells of a brick and around it, there only next to the brick's own cells.
  void gather(std::size_t brick, Block* block) const;

 private:
  void gatherInto(std::size_t brick, Block* block) const;
  static uint32_t cellOf(const Brick& brick, int bit) {
    const uint64_t below = (uint64_t{1} << bit) - 1;
    return brick.mask >> bit & 1
               ? brick.first + static_cast<uint32_t>(__builtin_popcountll(brick.mask & below))
               : kNoIndex;
  }
  uint64_t slotOf(uint64_t brick_key) const {
    return brick_key * 0x9e3779b97f4a7c15ULL >> slot_shift_;
  }

  std::vector<uint64_t> keys_;
  std::vector<Brick> bricks_;
  std::vector<std::array<uint32_t, 27>> around_;
  std::vector<uint32_t> slots_ = {kNoIndex, kNoIndex};  // open addressing: brick by hash of its key
  uint64_t slot_mask_ = 1;
  int slot_shift_ = 63;
};

}  // namespace ladar_perception
