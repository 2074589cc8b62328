// SPDX-License-Identifier: BSD-3-Clause
// Random numbers that are the same bits with every standard library; std:: distributions are not.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace ladar_perception::sim {

/// Finaliser of SplitMix64 (Steele, Lea, Flood 2014): a bijection that spreads every input bit.
inline uint64_t mixBits(uint64_t bits) {
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebULL;
  return bits ^ (bits >> 31);
}

/// Seed of an independent stream named by `keys`, e.g. {scan, column, row}.
inline uint64_t streamSeed(uint64_t seed, std::initializer_list<uint64_t> keys) {
  uint64_t state = mixBits(seed + 0x9e3779b97f4a7c15ULL);
  for (const uint64_t key : keys) state = mixBits(state + 0x9e3779b97f4a7c15ULL * (key + 1));
  return state;
}

/// Uniform number in [0, 1) from the upper 53 bits.
inline double unitFromBits(uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

/// SplitMix64 with the few distributions the simulator needs. Draw at most once per function call
/// or operator: C++ does not fix the order of arguments and operands, so scenes would depend on
/// the compiler.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t bits() { return mixBits(state_ += 0x9e3779b97f4a7c15ULL); }
  /// In [0, 1).
  double uniform() { return unitFromBits(bits()); }
  /// In [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In {0, ..., count - 1}; `count` > 0.
  int below(int count) { return static_cast<int>(uniform() * count); }
  bool chance(double probability) { return uniform() < probability; }
  /// Standard normal (Box-Muller; the second value is thrown away to keep streams simple).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(6.283185307179586 * uniform());
  }
  double normal(double mean, double sigma) { return mean + sigma * normal(); }

 private:
  uint64_t state_;
};

}  // namespace ladar_perception::sim
