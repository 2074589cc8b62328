// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/sparse_grid.h"

#include <utility>

namespace ladar_perception {
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
  around_.resize(bricks_.size());
  for (auto& around : around_) around.fill(kNoIndex);
  constexpr std::size_t kFew = 64;
  if (bricks_.size() < kFew) {
    findBricksAround();
    return;
  }
  // Bricks are cells of a coarser grid, with far fewer bricks to look for.
  SparseGrid coarse;
  std::vector<uint64_t> keys;
  keys.reserve(bricks_.size());
  for (const Brick& brick : bricks_) keys.push_back(brick.key);
  coarse.assign(std::move(keys));
  coarse.linkBricks();
  dispatch([&]() LADAR_INLINE_LAMBDA {
    for (uint32_t big = 0; big < coarse.bricks_.size(); ++big) {
      uint32_t brick = coarse.bricks_[big].first;
      for (uint64_t mask = coarse.bricks_[big].mask; mask != 0; mask &= mask - 1, ++brick) {
        const int bit = __builtin_ctzll(mask);
        coarse.visitNear<1>(big, bit, [&](uint32_t other, uint32_t direction, int other_bit) {
          around_[brick][stepBetween(bit, direction, other_bit)] = other;
        });
      }
    }
  });
}

void SparseGrid::findBricksAround() {
  constexpr uint32_t kOwn = 13;
  for (uint32_t brick = 0; brick < bricks_.size(); ++brick) {
    around_[brick][kOwn] = brick;
    // Half of the directions: from the others this brick is found.
    for (uint32_t direction = kOwn + 1; direction < 27; ++direction) {
      const uint32_t other =
          findBrick(morton::around(bricks_[brick].key, static_cast<int>(direction)));
      if (other == kNoIndex) continue;
      around_[brick][direction] = other;
      around_[other][2 * kOwn - direction] = brick;
    }
  }
}

}  // namespace ladar_perception
