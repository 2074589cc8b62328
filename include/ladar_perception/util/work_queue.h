// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace ladar_perception {

/// A queue between threads that holds at most `capacity` items. What becomes of one more is the
/// caller's choice: the oldest leaves, or the caller waits.
template <typename Item>
class WorkQueue {
 public:
  explicit WorkQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Appends; returns the oldest item if it had to leave.
  std::optional<Item> pushOverOldest(Item item) {
    std::optional<Item> displaced;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (items_.size() >= capacity_) displaced = takeFirst();
      items_.push_back(std::move(item));
    }
    changed_.notify_all();
    return displaced;
  }

  /// Waits for room and appends; false if the queue was stopped before there was any.
  bool pushWhenRoom(Item item) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(lock, [this] { return stopped_ || items_.size() < capacity_; });
      if (stopped_) return false;
      items_.push_back(std::move(item));
    }
    changed_.notify_all();
    return true;
  }

  /// Waits for an item; none once the queue was stopped.
  std::optional<Item> pop() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return stopped_ || !items_.empty(); });
    return popLocked(&lock);
  }
  /// The same, but none after the time either.
  std::optional<Item> pop(std::chrono::duration<double> timeout) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait_for(lock, timeout, [this] { return stopped_ || !items_.empty(); });
    return popLocked(&lock);
  }

  /// Whoever waits returns, now and from now on.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
  }

  /// Asks again and again until `ready()`, the time (of the wall: simulated time may stand still)
  /// is up or the queue is stopped; returns the last answer.
  template <typename Ready>
  bool pollUntil(const Ready& ready, std::chrono::duration<double> timeout) {
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(timeout);
    while (true) {
      if (ready()) return true;
      if (Clock::now() >= deadline) return false;
      std::unique_lock<std::mutex> lock(mutex_);
      const auto stopped = [this] { return stopped_; };
      if (changed_.wait_for(lock, std::chrono::milliseconds(2), stopped)) return false;
    }
  }

  bool stopped() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return stopped_;
  }
  std::size_t size() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return items_.size();
  }

 private:
  std::optional<Item> popLocked(std::unique_lock<std::mutex>* lock) {
    if (stopped_ || items_.empty()) return std::nullopt;
    std::optional<Item> item = takeFirst();
    lock->unlock();
    changed_.notify_all();
    return item;
  }
  Item takeFirst() {
    Item item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

  const std::size_t capacity_;
  mutable std::mutex mutex_;  // guards the two below
  std::deque<Item> items_;
  bool stopped_ = false;
  std::condition_variable changed_;
};

}  // namespace ladar_perception
