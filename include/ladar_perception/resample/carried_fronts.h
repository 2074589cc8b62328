// SPDX-License-Identifier: BSD-3-Clause
// From a crust with samples on it to the crust that it becomes when points are added.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/farthest_points.h"
#include "ladar_perception/resample/fronts.h"

namespace ladar_perception {

/// For every cell of `now` the one of `before` with the same size, place and slowness, or kNoIndex.
/// Both are in the same frame.
std::vector<uint32_t> sameCells(const Crust& now, const Crust& before);

/// Takes the samples of `set` and their fronts, as far as `before` has them, to `field`, of the
/// crust that follows and reset. A front that ran over cells which have changed, or beside them, is
/// run anew; others stay, and run on into cells that have come. A sample that lost its cell, as the
/// surface was found to be elsewhere, stays where it is if a cell is near, else it is given up.
template <typename Metric>
EarlierSamples carryFronts(const FrontField& before, const SampleSet& set, FrontField* field);

extern template EarlierSamples carryFronts<Flood>(const FrontField&, const SampleSet&, FrontField*);
extern template EarlierSamples carryFronts<FastMarching>(const FrontField&, const SampleSet&,
                                                         FrontField*);

}  // namespace ladar_perception
