// SPDX-License-Identifier: BSD-3-Clause
// What slam_bag writes of an estimate: graph, metrics.
#pragma once

#include <nlohmann/json.hpp>
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

}  // namespace ladar_perception
