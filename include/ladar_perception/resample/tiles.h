// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Cubes of cells that are worked on one after the other where they touch, and at the same time
/// where they do not. Tiles have one of eight colours, by the parity of their coordinates; of two
/// that touch, the one of the lesser colour is first. The result is the same for any number of
/// threads if the work on a tile neither reads nor writes farther than half a tile beyond it.
class Tiles {
 public:
  struct Tile {
    uint32_t first = 0;  ///< cells [first, end)
    uint32_t end = 0;
    std::vector<uint32_t> later;  ///< tiles that touch this one and wait for it
    uint32_t earlier = 0;         ///< how many tiles this one waits for
  };

  /// `keys` of cells ascend; a tile has 2^level cells an edge.
  Tiles(const std::vector<uint64_t>& keys, int level);

  std::size_t size() const { return tiles_.size(); }
  const Tile& tile(std::size_t i) const { return tiles_[i]; }
  /// Calls `work(thread, tile)` once for every tile, on the threads of the pool: each goes on near
  /// the tile it had, in a region of its own as long as there is work.
  /// One of them does what is to be done `beside` first.
  void run(ThreadPool* pool, const std::function<void(int, std::size_t)>& work,
           const std::function<void()>& beside = nullptr) const;

 private:
  std::vector<Tile> tiles_;
};

}  // namespace ladar_perception
