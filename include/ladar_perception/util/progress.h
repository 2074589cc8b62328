// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace ladar_perception {

/// One line on standard error that tells how far a long job is; silent for jobs under a second and
/// a line every ten seconds where standard error is no terminal.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  void advance();
  /// Ends the line.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  void show(Clock::time_point now);

  std::string what_;
  std::size_t total_;
  std::size_t done_ = 0;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point begin_;
  Clock::time_point next_show_;
};

}  // namespace ladar_perception
