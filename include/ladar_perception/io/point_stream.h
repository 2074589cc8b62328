// SPDX-License-Identifier: BSD-3-Clause
// Replays a surveyed tile, whose sensor and trajectory are not known, as scans of a vehicle that
// drives through it.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "ladar_perception/io/scan.h"

namespace ladar_perception {

/// The order in which the vehicle meets the points. Files of labelled tiles are often grouped by
/// object: in their own order a place would be seen wall by wall and tree by tree, far apart in
/// time, and the neighbours of a point would tell its class.
enum class StreamOrder {
  kSweep,  ///< along the tile's main horizontal axis, as a push-broom sensor passes over it
  kFile,   ///< as in the file
};

struct StreamConfig {
  std::size_t points_per_scan = 10000;
  StreamOrder order = StreamOrder::kSweep;
};

/// Points of one scan and the pose the vehicle is given for it.
struct StreamScan {
  std::vector<std::size_t> points;  ///< indices into the tile
  Eigen::Isometry3d T_map_vehicle = Eigen::Isometry3d::Identity();
};

/// Cuts a tile into scans; the last has the rest, at least half a scan if there are several. Every
/// point is in one scan. The vehicle stands among the low points of its scan (their median in x
/// and y), on the ground (a low percentile of z), smoothed over the scans before and after; it does
/// not turn. NaN points move no vehicle.
std::vector<StreamScan> cutStream(const Scan& tile, const StreamConfig& config);

/// The scan's points with their fields, positions in the sensor frame.
Scan takeStreamScan(const Scan& tile, const StreamScan& stream_scan,
                    const Eigen::Isometry3d& T_map_sensor);

}  // namespace ladar_perception
