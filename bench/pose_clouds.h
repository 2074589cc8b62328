// SPDX-License-Identifier: BSD-3-Clause
// Clouds of one pose to re-sample: simulated ones of any size, and real ones where they are
// present.
#pragma once

#include <cstddef>
#include <string>

#include "ladar_perception/resample/policy.h"

namespace ladar_perception::bench {

/// The simulated campus as a sensor sees it that stands on the street and turns slowly: `points`
/// returns, spread evenly over the directions from 60 degrees down to 30 up, all around. Range
/// noise 2 cm. Made on first use and kept.
const PoseCloudData& campusCloud(std::size_t points);

/// "kitti00", the first of six scans, or "3dtk_indoor", the first of three; nullptr, said once on
/// standard error, where the data are not present. Looked for in $LADAR_DATA, else in
/// `../shared/data` beside the repository.
const PoseCloudData* realCloud(const std::string& name);

}  // namespace ladar_perception::bench
