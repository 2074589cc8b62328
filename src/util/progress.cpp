// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/util/progress.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

namespace ladar_perception {

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) != 0),
      begin_(Clock::now()),
      next_show_(begin_ + std::chrono::seconds(1)) {}

void Progress::advance() {
  ++done_;
  const auto now = Clock::now();
  if (now < next_show_) return;
  show(now);
  next_show_ = now + std::chrono::milliseconds(terminal_ ? 200 : 10000);
}

void Progress::finish() {
  if (!shown_) return;
  show(Clock::now());
  if (terminal_) std::fprintf(stderr, "\n");
}

void Progress::show(Clock::time_point now) {
  shown_ = true;
  const double seconds = std::chrono::duration<double>(now - begin_).count();
  std::fprintf(stderr, "%s%zu of %zu %s, %.0f s%s", terminal_ ? "\r" : "", done_, total_,
               what_.c_str(), seconds, terminal_ ? "" : "\n");
  std::fflush(stderr);
}

}  // namespace ladar_perception
