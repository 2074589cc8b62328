// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ladar_perception/saliency/box_sum_strategy.h"
#include "stopwatch.h"

namespace ladar_perception::bench {

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Times strategies on one map, in rounds over all of them, so that what else the machine does
/// hits all alike.
class StrategyTimer {
 public:
  StrategyTimer(const std::vector<std::string>& names, const VoxelMap& map) : map_(map), pool_(1) {
    for (const std::string& name : names) {
      runs_.push_back({name, makeBoxSumStrategy(name), {}});
      runs_.back().strategy->load(map);
    }
    sums_.resize(map.slotBound());
  }

  /// Medians in ns per occupied voxel, by strategy.
  std::map<std::string, double> nsPerVoxel(int k) {
    constexpr int kRounds = 7;
    constexpr int kFewRounds = 3;
    constexpr double kSlow_ns = 0.7e9;     // few rounds must do
    constexpr double kVerySlow_ns = 10e9;  // one must do
    for (Run& run : runs_) run.times_ns.clear();
    for (int round = 0; round < kRounds; ++round) {
      for (Run& run : runs_) {
        const double first_ns = round == 0 ? 0.0 : run.times_ns.front();
        if (first_ns > kVerySlow_ns || (first_ns > kSlow_ns && round >= kFewRounds)) continue;
        run.times_ns.push_back(timeOnce(run.strategy.get(), k));
      }
    }
    std::map<std::string, double> result;
    for (const Run& run : runs_) {
      result[run.name] = median(run.times_ns) / static_cast<double>(map_.occupied());
    }
    return result;
  }

  /// Voxels whose sums are not, bit by bit, those of the first strategy.
  std::size_t mismatches(int k) {
    std::vector<Moments> expected(sums_.size());
    runs_.front().strategy->compute(k / 2, &pool_, &expected);
    std::size_t count = 0;
    for (Run& run : runs_) {
      std::fill(sums_.begin(), sums_.end(), Moments());  // nothing of the strategy before
      run.strategy->compute(k / 2, &pool_, &sums_);
      map_.forEachVoxel([&](const VoxelIndex& /*voxel*/, std::size_t slot) {
        count += sums_[slot] != expected[slot] ? 1 : 0;
      });
    }
    return count;
  }

  std::map<std::string, std::size_t> memoryBytes() const {
    std::map<std::string, std::size_t> result;
    for (const Run& run : runs_) result[run.name] = run.strategy->memoryBytes();
    return result;
  }

 private:
  struct Run {
    std::string name;
    std::unique_ptr<BoxSumStrategy> strategy;
    std::vector<double> times_ns;
  };

  double timeOnce(BoxSumStrategy* strategy, int k) {
    const Stopwatch stopwatch;
    strategy->compute(k / 2, &pool_, &sums_);
    return stopwatch.cpu_ns();
  }

  const VoxelMap& map_;
  ThreadPool pool_;
  std::vector<Run> runs_;
  std::vector<Moments> sums_;
};

}  // namespace ladar_perception::bench
