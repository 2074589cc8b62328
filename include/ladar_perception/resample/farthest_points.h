// SPDX-License-Identifier: BSD-3-Clause
// The farthest point strategy over a crust.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstdint>
#include <vector>

#include "ladar_perception/resample/fronts.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// When to stop: at the first of the conditions that are set. Lengths in cells.
struct FarthestPointsGoal {
  std::size_t count = 0;  ///< samples; 0: not set
  /// No cell is reached later, but where a sample is nearer in a straight line; 0: not set.
  float radius = 0;
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
  /// First radius: samples that far apart are put in at random, farther ones need not be looked
  /// for.
  float first_radius = 0;
};

/// Samples in the order of their choice, farthest first.
struct SampleSet {
  std::vector<uint32_t> cells;  ///< cell a sample lies in; no two in one
  std::vector<Eigen::Vector3f> positions;
  /// Greatest arrival time that is left when this sample and those before it are in; does not grow.
  /// Among the first samples, those of the random start, it is the straight distance times the mean
  /// slowness, and up to two cells too little: every fourth cell stands for those around it.
  std::vector<float> covering;
  float radius_reached = 0;  ///< the next sample would have been at most this far

  std::size_t size() const { return cells.size(); }
};

/// Samples that are there, with their fronts in the field.
struct EarlierSamples {
  SampleSet set;
  std::vector<uint32_t> new_cells;  ///< that the coverings in `set` do not know of
};

/// Chooses samples. The strategy puts every sample at the place the fronts reach last, a vertex of
/// the Voronoi diagram of those before, one after the other. Here
/// 1. random cells farther than `first_radius` from all before make a start (a Poisson-disk set:
///    it covers every island of the crust): the many long fronts of the first samples are not run;
/// 2. rounds with radii that fall by a third, then a seventh, fill in the vertices farther than the
///    radius, tile by tile, each at the circumcentre of its three nearest samples, not at the
///    middle of a cell;
/// 3. samples are put into the order of their distances.
/// Time is O(cells + samples) but for a logarithm in step 3. `field` is left with all fronts.
/// Samples of `before` are first in the result: none of them is chosen again, and a count is one
/// with them.
template <typename Metric>
SampleSet chooseFarthestPoints(FrontField* field, const FarthestPointsGoal& goal, ThreadPool* pool,
                               const EarlierSamples& before = {});

extern template SampleSet chooseFarthestPoints<Flood>(FrontField*, const FarthestPointsGoal&,
                                                      ThreadPool*, const EarlierSamples&);
extern template SampleSet chooseFarthestPoints<FastMarching>(FrontField*, const FarthestPointsGoal&,
                                                             ThreadPool*, const EarlierSamples&);

}  // namespace ladar_perception
