// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/sparse_grid.h"

#include <utility>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

/// Where the cell of bit b lies in a block, for each of the 64 bits.
struct BlockPlaces {
  std::array<uint8_t, 64> of_bit{};
  constexpr BlockPlaces() {
    for (int bit = 0; bit < 64; ++bit) {
      const auto key = static_cast<uint64_t>(bit);
      of_bit[static_cast<std::size_t>(bit)] = static_cast<uint8_t>(
          SparseGrid::blockIndex(static_cast<int>(morton::x(key)), static_cast<int>(morton::y(key)),
                                 static_cast<int>(morton::z(key))));
    }
  }
};
constexpr BlockPlaces kPlaces;

/// Bits of the cells with the least (side -1) or greatest (1) coordinate along an axis; all for 0.
constexpr uint64_t sideMask(int axis, int side) {
  if (side == 0) return ~uint64_t{0};
  uint64_t mask = 0;
  for (int bit = 0; bit < 64; ++bit) {
    const uint32_t coordinate = morton::compact(static_cast<uint64_t>(bit) >> axis);
    if (coordinate == (side < 0 ? 0U : 3U)) mask |= uint64_t{1} << bit;
  }
  return mask;
}

constexpr std::array<std::array<uint64_t, 3>, 3> kSideMasks = {{
    {sideMask(0, -1), sideMask(0, 0), sideMask(0, 1)},
    {sideMask(1, -1), sideMask(1, 0), sideMask(1, 1)},
    {sideMask(2, -1), sideMask(2, 0), sideMask(2, 1)},
}};

/// Cells of a brick on those of its sides.
LADAR_INLINE uint64_t sides(int dx, int dy, int dz) {
  return kSideMasks[0][static_cast<std::size_t>(1 + dx)] &
         kSideMasks[1][static_cast<std::size_t>(1 + dy)] &
         kSideMasks[2][static_cast<std::size_t>(1 + dz)];
}

}  // namespace

void SparseGrid::assign(std::vector<uint64_t> keys) {
  keys_ = std::move(keys);
  bricks_.clear();
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (bricks_.empty() || bricks_.back().key != keys_[i] >> 6) {
      bricks_.push_back({keys_[i] >> 6, 0, static_cast<uint32_t>(i)});
    }
    bricks_.back().mask |= uint64_t{1} << (keys_[i] & 63);
  }
  int bits = 4;
  while ((std::size_t{1} << bits) < 2 * bricks_.size()) ++bits;
  slots_.assign(std::size_t{1} << bits, kNoIndex);
  slot_mask_ = slots_.size() - 1;
  slot_shift_ = 64 - bits;
  for (std::size_t brick = 0; brick < bricks_.size(); ++brick) {
    uint64_t slot = slotOf(bricks_[brick].key);
    while (slots_[slot] != kNoIndex) slot = (slot + 1) & slot_mask_;
    slots_[slot] = static_cast<uint32_t>(brick);
  }
}

void SparseGrid::linkBricks() {
  constexpr uint32_t kOwn = 13;
  around_.resize(bricks_.size());
  for (auto& around : around_) around.fill(kNoIndex);
  for (uint32_t brick = 0; brick < bricks_.size(); ++brick) {
    around_[brick][kOwn] = brick;
    // Half of the directions: from the others this brick is found.
    for (uint32_t direction = kOwn + 1; direction < 27; ++direction) {
      const auto d = static_cast<int>(direction);
      uint64_t key = morton::step(bricks_[brick].key, morton::kAxisX, d % 3 - 1);
      key = morton::step(key, morton::kAxisY, d / 3 % 3 - 1);
      const uint32_t other = findBrick(morton::step(key, morton::kAxisZ, d / 9 - 1));
      if (other == kNoIndex) continue;
      around_[brick][direction] = other;
      around_[other][2 * kOwn - direction] = brick;
    }
  }
}

LADAR_INLINE void SparseGrid::gatherInto(std::size_t brick, Block* block) const {
  block->fill(kNoIndex);
  const uint64_t own = bricks_[brick].mask;
  std::size_t direction = 0;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx, ++direction) {
        // Only where one of our own cells lies on that side.
        if ((own & sides(dx, dy, dz)) == 0) continue;
        const uint32_t neighbor = around_[brick][direction];
        if (neighbor == kNoIndex) continue;
        // Of the brick on side d only the cells on its side -d are around ours.
        uint64_t mask = bricks_[neighbor].mask & sides(-dx, -dy, -dz);
        const int shift = 4 * (dx + kBlockEdge * (dy + kBlockEdge * dz));
        for (; mask != 0; mask &= mask - 1) {
          const int bit = __builtin_ctzll(mask);
          (*block)[static_cast<std::size_t>(kPlaces.of_bit[static_cast<std::size_t>(bit)] +
                                            shift)] = cellOf(bricks_[neighbor], bit);
        }
      }
    }
  }
}

void SparseGrid::gather(std::size_t brick, Block* block) const {
  dispatch([&]() LADAR_INLINE_LAMBDA { gatherInto(brick, block); });
}

}  // namespace ladar_perception
