// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ladar_perception::bench {

/// Puts points into the order in which a ladar that looks at one patch of the scene at a time would
/// have measured them: frame after frame, in each line after line, along each line by azimuth. It
/// is on a turret of a vehicle that drives along +x through the middle of a window of `size_m` from
/// the origin. Every point is given a frame that could see it, near one of its lines if there is
/// such a frame; occlusion is left aside.
///
/// Points only lie near the lines, not on them, so that one is farther from the next (0.3 to 0.9 m
/// on average) than in a scan of KITTI (0.12 m): insertion is measured on an order that is rather
/// too hard than too easy.
void sortInScanOrder(const Eigen::Vector3d& size_m, uint64_t seed,
                     std::vector<Eigen::Vector3d>* points);

}  // namespace ladar_perception::bench
