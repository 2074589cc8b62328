// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace ladar_perception::test {

/// Random numbers that are the same on every machine (std's distributions are not).
class TestRandom {
 public:
  explicit TestRandom(uint64_t seed) : engine_(seed) {}

  /// A whole number in [lowest, highest].
  int64_t integer(int64_t lowest, int64_t highest) {
    return lowest + static_cast<int64_t>(engine_() % static_cast<uint64_t>(highest - lowest + 1));
  }
  /// A real number in [lowest, highest).
  double real(double lowest, double highest) {
    return lowest + (highest - lowest) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// Near enough to a normal number: the sum of twelve uniform ones.
  double normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += real(0.0, 1.0);
    return sum;
  }
  Eigen::Vector3d normal3() {
    const double x = normal();
    const double y = normal();
    return {x, y, normal()};
  }
  std::mt19937_64& engine() { return engine_; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace ladar_perception::test
