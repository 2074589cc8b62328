// SPDX-License-Identifier: BSD-3-Clause
// Clouds of public data sets. The data are not part of the package.
#pragma once

#include <string>

#include "bench_scenes.h"

namespace ladar_perception::bench {

/// A tile of the Oakland 3-D set, points in acquisition order. The tiles measure about 120 x 70 x
/// 30 m, 17 GB for a dense array of records; so this is the part of one with most points that fits
/// into 40 x 40 x 6.4 m. Throws std::runtime_error if the file is not there or no such file.
Scene makeOakland(const std::string& data_folder);

/// Six consecutive scans of KITTI sequence 00 in one map of 40 x 40 x 4 m around the first sensor.
/// Throws as above.
Scene makeKitti(const std::string& data_folder);

}  // namespace ladar_perception::bench
