// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/util/proportions.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ladar_perception {
namespace {

constexpr double kZ = 1.959963984540054;  // two-sided 95 %

/// Chance of at most `most` heads of `tosses` of a fair coin.
double fairTail(std::size_t most, std::size_t tosses) {
  const auto n = static_cast<double>(tosses);
  double sum = 0.0;
  for (std::size_t k = 0; k <= most; ++k) {
    const auto heads = static_cast<double>(k);
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(heads + 1.0) - std::lgamma(n - heads + 1.0) -
                    n * std::log(2.0));
  }
  return sum;
}

}  // namespace

Interval wilsonInterval(std::size_t successes, std::size_t trials) {
  assert(successes <= trials);
  if (trials == 0) return {};
  const auto n = static_cast<double>(trials);
  const double share = static_cast<double>(successes) / n;
  const double middle = share + kZ * kZ / (2.0 * n);
  const double half = kZ * std::sqrt(share * (1.0 - share) / n + kZ * kZ / (4.0 * n * n));
  const double scale = 1.0 / (1.0 + kZ * kZ / n);
  return {std::max(0.0, (middle - half) * scale), std::min(1.0, (middle + half) * scale)};
}

PairedComparison mcnemar(const std::vector<bool>& a, const std::vector<bool>& b) {
  assert(a.size() == b.size());
  PairedComparison comparison;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] && !b[i]) ++comparison.only_a;
    if (b[i] && !a[i]) ++comparison.only_b;
  }
  const std::size_t lesser = std::min(comparison.only_a, comparison.only_b);
  comparison.p_value = std::min(1.0, 2.0 * fairTail(lesser, comparison.only_a + comparison.only_b));
  return comparison;
}

}  // namespace ladar_perception
