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
    // By axis, coordinate and brick: few, so that compilers do not give up on the table.
    std::array<std::array<std::array<uint64_t, 3>, 4>, 3> along{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t coordinate = 0; coordinate < 4; ++coordinate) {
        for (std::size_t side = 0; side < 3; ++side) {
          along[axis][coordinate][side] =
              near(axis, static_cast<int>(coordinate), static_cast<int>(side) - 1);
        }
      }
    }
    for (std::size_t bit = 0; bit < 64; ++bit) {
      for (uint32_t direction = 0; direction < 27; ++direction) {
        const uint64_t mask = along[0][morton::x(bit)][direction % 3] &
                              along[1][morton::y(bit)][direction / 3 % 3] &
                              along[2][morton::z(bit)][direction / 9];
        if (mask != 0) sides[bit][count[bit]++] = {mask, direction};
      }
    }
  }

 private:
  /// Of the brick `side` bricks on: cells whose coordinate is near to the one of a cell here.
  static constexpr uint64_t near(std::size_t axis, int coordinate, int side) {
    uint64_t mask = 0;
    for (uint64_t bit = 0; bit < 64; ++bit) {
      const int steps = static_cast<int>(morton::compact(bit >> axis)) + 4 * side - coordinate;
      if (-kReach <= steps && steps <= kReach) mask |= uint64_t{1} << bit;
    }
    return mask;
  }
};
template <int kReach>
inline constexpr NearCells<kReach> kNearCells;

/// Cells of a brick that touch the brick in each of 27 directions: a side, an edge or a corner.
constexpr std::array<uint64_t, 27> brickSides() {
  std::array<uint64_t, 27> masks{};
  for (uint64_t bit = 0; bit < 64; ++bit) {
    const std::array<uint32_t, 3> cell = {morton::x(bit), morton::y(bit), morton::z(bit)};
    for (std::size_t direction = 0; direction < 27; ++direction) {
      const std::array<std::size_t, 3> side = {direction % 3, direction / 3 % 3, direction / 9};
      bool touches = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        touches = touches && (side[axis] == 1 || cell[axis] == (side[axis] == 0 ? 0U : 3U));
      }
      if (touches) masks[direction] |= uint64_t{1} << bit;
    }
  }
  return masks;
}
inline constexpr std::array<uint64_t, 27> kBrickSides = brickSides();

/// x + 3 y + 9 z of the cell at every bit of a brick.
constexpr std::array<int8_t, 64> ninthsOfBits() {
  std::array<int8_t, 64> ninths{};
  for (uint64_t bit = 0; bit < 64; ++bit) {
    ninths[bit] = static_cast<int8_t>(morton::x(bit) + 3 * morton::y(bit) + 9 * morton::z(bit));
  }
  return ninths;
}
inline constexpr std::array<int8_t, 64> kNinths = ninthsOfBits();

/// Which of the 27 steps (x fastest, 13 none) it is from a cell of a brick to one of a brick around
/// it, told by their bits.
LADAR_INLINE constexpr uint32_t stepBetween(int from_bit, uint32_t direction, int to_bit) {
  // x + 3 y + 9 z is linear, and four steps on in the next brick.
  return static_cast<uint32_t>(13 + 4 * (static_cast<int>(direction) - 13) +
                               kNinths[static_cast<std::size_t>(to_bit)] -
                               kNinths[static_cast<std::size_t>(from_bit)]);
}

/// A set of grid cells, numbered in the order of their Morton keys and kept as bricks of 4^3: a bit
/// per cell, so that a cell's number is the brick's first plus the bits below.
class SparseGrid {
 public:
  static constexpr int kBlockEdge = 6;
  static constexpr int kBlockCells = kBlockEdge * kBlockEdge * kBlockEdge;
  /// Place in a block of 6^3 cells, a brick and one cell around it, of the cell (x, y, z), each in
  /// [-1, 4].
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
        const int near_bit = __builtin_ctzll(mask);
        visit(numberOf(other, near_bit), sides[i].direction, near_bit);
      }
    }
  }
  /// How many cells those are.
  template <int kReach>
  LADAR_INLINE uint32_t countNear(std::size_t brick, int bit) const {
    const auto b = static_cast<std::size_t>(bit);
    const auto& sides = kNearCells<kReach>.sides[b];
    uint32_t count = 0;
    for (std::size_t i = 0; i < kNearCells<kReach>.count[b]; ++i) {
      const uint32_t near = around_[brick][sides[i].direction];
      if (near == kNoIndex) continue;
      count += static_cast<uint32_t>(__builtin_popcountll(bricks_[near].mask & sides[i].mask));
    }
    return count;
  }
  /// Calls visit(number, place in the block, direction of its brick) for the cells of a brick and
  /// those around it, there only next to the brick's own cells.
  template <typename Visit>
  LADAR_INLINE void visitBlock(std::size_t brick, const Visit& visit) const {
    for (uint32_t direction = 0; direction < 27; ++direction) {
      const uint32_t near = around_[brick][direction];
      // Of the brick on side d only the cells on its side -d are around those here, on side d.
      if (near == kNoIndex || (bricks_[brick].mask & kBrickSides[direction]) == 0) continue;
      const Brick& other = bricks_[near];
      const auto d = static_cast<int>(direction);
      const int shift = 4 * (d % 3 - 1 + kBlockEdge * (d / 3 % 3 - 1 + kBlockEdge * (d / 9 - 1)));
      for (uint64_t mask = other.mask & kBrickSides[26 - direction]; mask != 0; mask &= mask - 1) {
        const int bit = __builtin_ctzll(mask);
        visit(numberOf(other, bit), kBlockPlaces[static_cast<std::size_t>(bit)] + shift, direction);
      }
    }
  }

 private:
  void findBricksAround();
  static constexpr std::array<int, 64> blockPlaces() {
    std::array<int, 64> places{};
    for (uint64_t bit = 0; bit < 64; ++bit) {
      places[bit] = blockIndex(static_cast<int>(morton::x(bit)), static_cast<int>(morton::y(bit)),
                               static_cast<int>(morton::z(bit)));
    }
    return places;
  }
  static const std::array<int, 64> kBlockPlaces;  // by bit
  /// Of the cell that is at a bit.
  LADAR_INLINE static uint32_t numberOf(const Brick& brick, int bit) {
    const uint64_t below = (uint64_t{1} << bit) - 1;
    return brick.first + static_cast<uint32_t>(__builtin_popcountll(brick.mask & below));
  }
  static uint32_t cellOf(const Brick& brick, int bit) {
    return brick.mask >> bit & 1 ? numberOf(brick, bit) : kNoIndex;
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

inline constexpr std::array<int, 64> SparseGrid::kBlockPlaces = SparseGrid::blockPlaces();

}  // namespace ladar_perception
