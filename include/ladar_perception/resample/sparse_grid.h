// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace ladar_perception {

constexpr uint32_t kNoIndex = 0xffffffffU;

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
  /// Around the brick only next to the brick's own cells.
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
  std::vector<uint32_t> slots_ = {kNoIndex, kNoIndex};  // open addressing: brick by hash of its key
  uint64_t slot_mask_ = 1;
  int slot_shift_ = 63;
};

}  // namespace ladar_perception
