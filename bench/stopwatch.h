// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <ctime>

namespace ladar_perception::bench {

/// Time since its construction. The CPU time of the process is what work on one thread takes
/// whatever else the machine does meanwhile; with more threads only the wall clock tells.
class Stopwatch {
 public:
  double cpu_ns() const {
    return 1e9 * static_cast<double>(std::clock() - cpu_begin_) / CLOCKS_PER_SEC;
  }
  double wall_ns() const {
    return std::chrono::duration<double, std::nano>(Clock::now() - wall_begin_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::clock_t cpu_begin_ = std::clock();
  Clock::time_point wall_begin_ = Clock::now();
};

}  // namespace ladar_perception::bench
