// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/cloud/labeled_cloud.h"
#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {

/// How labels compare with the truth of simulated or hand-labelled points.
///
/// Truth 1 to `classes` is a class by the model's numbering, everything else is not scored. Points
/// outside the map are counted apart; every other point with truth counts, unknown ones as wrong.
class TruthConfusion {
 public:
  explicit TruthConfusion(std::size_t classes);

  /// The points of one scan; all three in message order.
  void add(const std::vector<double>& truth, const std::vector<PointLabel>& labels,
           const std::vector<CellId>& cells);

  /// Points with truth inside the map, and outside it.
  uint64_t points() const { return points_; }
  uint64_t pointsOutsideMap() const { return outside_; }
  /// Points of true class `truth` (1-based) labelled `label` (0 is unknown).
  uint64_t count(std::size_t truth, std::size_t label) const {
    return counts_[(truth - 1) * (classes_ + 1) + label];
  }
  uint64_t truthCount(std::size_t truth) const;
  /// Share of a class's points that got its label; 0 if it has none.
  double recall(std::size_t truth) const;
  /// Mean over the classes that have points.
  double meanRecall() const;

 private:
  std::size_t classes_;
  std::vector<uint64_t> counts_;
  uint64_t points_ = 0;
  uint64_t outside_ = 0;
};

}  // namespace ladar_perception
