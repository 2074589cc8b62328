// SPDX-License-Identifier: BSD-3-Clause
// Samplings of simulated clouds against the true surface.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ladar_perception/resample/cloud_resampler.h"
#include "ladar_perception/sim/true_cloud.h"

namespace ladar_perception::bench {

/// Where a sensor stands in a simulated world.
struct StandingSensor {
  std::string scene = "campus";
  uint64_t seed = 1;
  double at_m = 152.0;  ///< along the track
  double left_m = -4.5;
  double height_m = 1.7;
  sim::TrueCloudConfig config;
};

/// A world with a cloud taken in it. Positions count from the sensor.
struct TrueCloud {
  explicit TrueCloud(const StandingSensor& standing);

  StandingSensor sensor;
  sim::World world;
  Eigen::Vector3d sensor_world;
  std::vector<sim::TruePoint> points;

  /// Positions and colours; labels by `class_of`, none if it is empty.
  PoseCloudData poseCloud(const std::vector<uint8_t>& class_of = {}) const;
};

/// Spacing, covering (raw points and true places), error to the true surface, error and density of
/// every flat face that at least 100 samples are expected on.
nlohmann::json qualityOf(const TrueCloud& cloud, const ResampledCloud& samples);

}  // namespace ladar_perception::bench
