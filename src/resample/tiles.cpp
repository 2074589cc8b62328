// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/tiles.h"

#include <atomic>
#include <thread>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/sparse_grid.h"

namespace ladar_perception {

Tiles::Tiles(const std::vector<uint64_t>& keys, int level) {
  std::vector<uint64_t> tile_keys;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const uint64_t key = keys[i] >> 3 * level;
    if (tile_keys.empty() || tile_keys.back() != key) {
      tile_keys.push_back(key);
      tiles_.emplace_back();
      tiles_.back().first = static_cast<uint32_t>(i);
    }
    tiles_.back().end = static_cast<uint32_t>(i + 1);
  }
  SparseGrid grid;
  grid.assign(tile_keys);
  for (std::size_t i = 0; i < tile_keys.size(); ++i) {
    for (int step = 0; step < 27; ++step) {
      const uint64_t key = morton::around(tile_keys[i], step);
      const uint32_t other = grid.find(key);
      if (other == kNoIndex || (key & 7) <= (tile_keys[i] & 7)) continue;
      tiles_[i].later.push_back(other);
      ++tiles_[other].earlier;
    }
  }
  for (uint64_t color = 0; color < 8; ++color) {
    for (std::size_t i = 0; i < tile_keys.size(); ++i) {
      if ((tile_keys[i] & 7) == color) by_color_.push_back(static_cast<uint32_t>(i));
    }
  }
  orderByPlace();
}

void Tiles::orderByPlace() {
  std::vector<std::vector<uint32_t>> earlier(tiles_.size());
  for (uint32_t i = 0; i < tiles_.size(); ++i) {
    for (const uint32_t later : tiles_[i].later) earlier[later].push_back(i);
  }
  std::vector<uint8_t> taken(tiles_.size(), 0);
  // As deep as there are colours.
  const std::function<void(uint32_t)> take = [&](uint32_t tile) {
    if (taken[tile] != 0) return;
    for (const uint32_t other : earlier[tile]) take(other);
    taken[tile] = 1;
    by_place_.push_back(tile);
  };
  for (uint32_t tile = 0; tile < tiles_.size(); ++tile) take(tile);
}

void Tiles::run(ThreadPool* pool, const std::function<void(int, std::size_t)>& work) const {
  if (pool->size() == 1 || tiles_.size() == 1) {
    for (const uint32_t tile : by_place_) work(0, tile);
    return;
  }
  std::vector<std::atomic<uint32_t>> waiting(tiles_.size());
  for (std::size_t i = 0; i < tiles_.size(); ++i) waiting[i] = tiles_[i].earlier;
  std::atomic<std::size_t> next{0};
  pool->run([&](int thread) {
    for (;;) {
      const std::size_t place = next.fetch_add(1);
      if (place >= by_color_.size()) return;
      const uint32_t tile = by_color_[place];
      // What it waits for comes before it in the order, and has been begun, most likely ended.
      while (waiting[tile].load(std::memory_order_acquire) > 0) std::this_thread::yield();
      work(thread, tile);
      for (const uint32_t later : tiles_[tile].later) {
        waiting[later].fetch_sub(1, std::memory_order_acq_rel);
      }
    }
  });
}

}  // namespace ladar_perception
