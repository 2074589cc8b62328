// SPDX-License-Identifier: BSD-3-Clause
// Shares of successes, with what chance allows.
#pragma once

#include <cstddef>
#include <vector>

namespace ladar_perception {

/// Bounds of a share, in [0, 1].
struct Interval {
  double low = 0.0;
  double high = 1.0;
};

/// Wilson's score interval of a share (two-sided, 95 %). All of [0, 1] without trials.
Interval wilsonInterval(std::size_t successes, std::size_t trials);

/// Two ways on the same trials: those that only one of them did.
struct PairedComparison {
  std::size_t only_a = 0;
  std::size_t only_b = 0;
  /// Of McNemar's exact test, two-sided: chance of a difference as large if both were as good.
  double p_value = 1.0;
};

/// Both must have one length.
PairedComparison mcnemar(const std::vector<bool>& a, const std::vector<bool>& b);

}  // namespace ladar_perception
