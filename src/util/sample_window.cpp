// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/util/sample_window.h"

#include <algorithm>
#include <cmath>

namespace ladar_perception {

void SampleWindow::add(double sample) {
  if (capacity_ == 0 || samples_.size() < capacity_) {
    samples_.push_back(sample);
    return;
  }
  samples_[next_] = sample;
  next_ = (next_ + 1) % capacity_;
}

double SampleWindow::percentile(double share) const {
  if (samples_.empty()) return 0.0;
  std::vector<double> sorted = samples_;
  const double rank = std::ceil(share * static_cast<double>(sorted.size())) - 1.0;
  const auto index = static_cast<std::ptrdiff_t>(
      std::clamp(rank, 0.0, static_cast<double>(sorted.size()) - 1.0));
  std::nth_element(sorted.begin(), sorted.begin() + index, sorted.end());
  return sorted[index];
}

}  // namespace ladar_perception
