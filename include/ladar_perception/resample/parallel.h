// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Calls task(begin, end) for pieces of [0, size) on all threads of the pool. Threads take pieces
/// as they become free, so what a piece computes must not depend on the others.
template <typename Task>
void parallelFor(ThreadPool* pool, std::size_t size, std::size_t piece, const Task& task) {
  if (pool->size() == 1 || size <= piece) {
    if (size > 0) task(std::size_t{0}, size);
    return;
  }
  std::atomic<std::size_t> next{0};
  pool->run([&](int /*thread*/) {
    for (;;) {
      const std::size_t begin = next.fetch_add(piece);
      if (begin >= size) return;
      task(begin, std::min(begin + piece, size));
    }
  });
}

/// Calls task(&scratch, i) for every i in [0, size), on all threads of the pool, each of which has
/// a scratch of its own.
template <typename Scratch, typename Task>
void parallelForWith(ThreadPool* pool, std::size_t size, const Task& task) {
  std::atomic<std::size_t> next{0};
  pool->run([&](int /*thread*/) {
    Scratch scratch;
    for (std::size_t i = next.fetch_add(1); i < size; i = next.fetch_add(1)) task(&scratch, i);
  });
}

}  // namespace ladar_perception
