// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace ladar_perception {

/// Runs a fixed number of independent tasks, one per thread; the caller is one of the threads.
/// Tasks must not throw. What a task computes must not depend on which thread ran it.
class ThreadPool {
 public:
  /// `threads` >= 1; with 1 there are no other threads and no locks.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const { return static_cast<int>(workers_.size()) + 1; }
  /// Calls `task(i)` for i in [0, size()) at the same time and returns when all have ended.
  void run(const std::function<void(int)>& task);

 private:
  void work(int index);

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable start_;
  std::condition_variable done_;
  const std::function<void(int)>* task_ = nullptr;
  uint64_t round_ = 0;
  int running_ = 0;
  bool stopping_ = false;
};

}  // namespace ladar_perception
