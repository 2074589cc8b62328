// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"
#include "ladar_perception/cloud/point_reader.h"
#include "ladar_perception/cloud/sensor_motion.h"

namespace ladar_perception {

/// A scan and where it was measured; owns none of it. Frames: `map`, which does not jump, the
/// vehicle, and the sensor, in which the points are.
struct PlacedScan {
  const CloudView& cloud;
  const PointFields& fields;
  const std::vector<float>& time_offsets_s;  ///< of the points from the stamp; empty: all at it
  const SensorMotion& motion;
  const Eigen::Isometry3d& T_map_vehicle;  ///< at the stamp
  uint64_t stamp_ns = 0;
};

}  // namespace ladar_perception
