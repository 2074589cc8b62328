// SPDX-License-Identifier: BSD-3-Clause
// What slam_bag writes of an estimate: graph, map cloud, metrics.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ladar_perception/slam/delayed_state.h"
#include "ladar_perception/slam/trajectory.h"

namespace ladar_perception {

/// Poses with standard deviations, and constraints.
nlohmann::ordered_json graphJson(const DelayedState& state);
/// What became of registrations, constraints by kind.
nlohmann::ordered_json countsJson(const DelayedState& state);
/// p50, p95 and max.
nlohmann::ordered_json percentilesJson(std::vector<double> values);
/// Of the poses with a true one: the odometry's and the estimate's errors.
nlohmann::ordered_json errorJson(const Trajectory& odometry, const Trajectory& estimate,
                                 const Trajectory& truth);

/// All samples in the map frame, as a binary PCD: x y z normal_x normal_y normal_z rgb label pose;
/// rgb and label only if there are any. Throws std::runtime_error that names the path.
void writeMapCloud(const std::string& path, const DelayedState& state);

}  // namespace ladar_perception
