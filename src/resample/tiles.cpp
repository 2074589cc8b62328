// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/tiles.h"

#include <atomic>
#include <deque>
#include <mutex>
#include <thread>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/sparse_grid.h"

namespace ladar_perception {
namespace {

/// Tiles that wait for none any more, of one thread; others take from it when they have none.
class ReadyTiles {
 public:
  void push(uint32_t tile) {
    const std::lock_guard<std::mutex> lock(mutex_);
    tiles_.push_back(tile);
  }
  /// The last one is near to what its thread did before, which its cache gains by.
  bool popLast(uint32_t* tile) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (tiles_.empty()) return false;
    *tile = tiles_.back();
    tiles_.pop_back();
    return true;
  }
  bool popFirst(uint32_t* tile) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (tiles_.empty()) return false;
    *tile = tiles_.front();
    tiles_.pop_front();
    return true;
  }

 private:
  std::mutex mutex_;
  std::deque<uint32_t> tiles_;
};

}  // namespace

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
}

void Tiles::run(ThreadPool* pool, const std::function<void(int, std::size_t)>& work,
                const std::function<void()>& beside) const {
  std::vector<std::atomic<uint32_t>> waiting(tiles_.size());
  for (std::size_t i = 0; i < tiles_.size(); ++i) waiting[i] = tiles_[i].earlier;
  std::atomic<std::size_t> unfinished{tiles_.size()};
  const auto threads = static_cast<std::size_t>(pool->size());
  std::vector<ReadyTiles> ready(threads);
  // Each thread begins in a region of its own.
  for (std::size_t i = tiles_.size(); i-- > 0;) {
    if (tiles_[i].earlier == 0) ready[i * threads / tiles_.size()].push(static_cast<uint32_t>(i));
  }
  const auto take = [&](std::size_t own, uint32_t* tile) {
    if (ready[own].popLast(tile)) return true;
    for (std::size_t k = 1; k < threads; ++k) {
      if (ready[(own + k) % threads].popFirst(tile)) return true;
    }
    return false;
  };
  pool->run([&](int thread) {
    const auto own = static_cast<std::size_t>(thread);
    if (thread == 0 && beside) beside();
    while (unfinished.load() > 0) {
      uint32_t tile = 0;
      if (!take(own, &tile)) {
        std::this_thread::yield();
        continue;
      }
      work(thread, tile);
      for (const uint32_t later : tiles_[tile].later) {
        if (waiting[later].fetch_sub(1, std::memory_order_acq_rel) == 1) ready[own].push(later);
      }
      --unfinished;
    }
  });
}

}  // namespace ladar_perception
