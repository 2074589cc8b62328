// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <utility>

namespace ladar_perception {

/// What other threads want done on the thread that owns the data, so that the data needs no lock.
class Errands {
 public:
  /// Waits until the errand is done, and throws what it threw; false if the owner ended before.
  bool run(std::function<void()> errand) {
    std::packaged_task<void()> task(std::move(errand));
    std::future<void> done = task.get_future();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (closed_) return false;
      tasks_.push_back(std::move(task));
    }
    try {
      done.get();
    } catch (const std::future_error&) {  // close() left it undone
      return false;
    }
    return true;
  }

  /// Of the owner: does what there is to do.
  void doAll() {
    while (true) {
      std::packaged_task<void()> task;
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (tasks_.empty()) return;
        task = std::move(tasks_.front());
        tasks_.pop_front();
      }
      task();
    }
  }
  /// Whoever waits returns, and nobody waits any more.
  void close() {
    std::deque<std::packaged_task<void()>> undone;
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
    undone.swap(tasks_);
  }

 private:
  std::mutex mutex_;  // guards the two below
  std::deque<std::packaged_task<void()>> tasks_;
  bool closed_ = false;
};

}  // namespace ladar_perception
