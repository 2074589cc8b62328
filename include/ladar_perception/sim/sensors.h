// SPDX-License-Identifier: BSD-3-Clause
// Ladars by name: their tables of beams, ranges and noise.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/sim/ladar.h"

namespace ladar_perception::sim {

/// "xuv": range images of 180 x 32 beams, 90 x 20 degrees, on a turret that pans and nods, 20 Hz.
/// "vlp16": 16 rings of 1,800 beams from +15 to -15 degrees, 10 Hz.
/// "hdl64": 64 rings from +2 to -24.3 degrees, denser above -8.5 degrees, 10 Hz; 1,024 of the real
/// sensor's 2,083 columns.
/// "os64": 64 even rings of 1,024 beams from +22.5 to -22.5 degrees, 10 Hz.
/// "pushbroom": one vertical plane at right angles to the direction of travel, 361 beams half a
/// degree apart, 37.5 lines a second, as the line scanners of the Oakland data set; five lines a
/// scan. Looks to the right.
const std::vector<std::string>& sensorNames();

/// Throws std::invalid_argument for a name that is not in sensorNames().
LadarConfig sensorConfig(const std::string& sensor_name);

}  // namespace ladar_perception::sim
