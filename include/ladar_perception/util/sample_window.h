// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace ladar_perception {

/// The last samples of a quantity, for percentiles.
class SampleWindow {
 public:
  /// Keeps the last `capacity` samples; 0 keeps all.
  explicit SampleWindow(std::size_t capacity) : capacity_(capacity) {}

  void add(double sample);
  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  /// Nearest-rank percentile, `share` in [0, 1]; 0 if there are no samples.
  double percentile(double share) const;
  double max() const { return percentile(1.0); }

 private:
  std::size_t capacity_;
  std::size_t next_ = 0;
  std::vector<double> samples_;
};

}  // namespace ladar_perception
