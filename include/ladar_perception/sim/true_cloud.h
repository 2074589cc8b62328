// SPDX-License-Identifier: BSD-3-Clause
// A dense cloud from one place with what is true of every point: for measuring errors.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/sim/world.h"

namespace ladar_perception::sim {

/// A sensor that stands still and turns once: columns all round, rows evenly from low to high. Its
/// beams are lines, so that no range is mixed from two depths and every point has its true place.
struct TrueCloudConfig {
  int points = 190000;     ///< wanted, 1000 to 10,000,000; the cloud has about as many
  double low_deg = -60.0;  ///< elevation of the lowest row
  double high_deg = 45.0;  ///< of the highest
  double max_range_m = 50.0;
  double range_sigma_m = 0.02;  ///< noise of the ranges, along the beams

  /// Every violation as "field = value: rule".
  std::vector<std::string> validate() const;
};

/// Directions are those of the world, positions count from the sensor.
struct TruePoint {
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();       ///< as measured
  Eigen::Vector3d p_true_m = Eigen::Vector3d::Zero();  ///< where the beam ended
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< of the true surface there
  uint32_t face = 0;                                   ///< PlanarFace::id, 0 where it is not flat
  Truth truth = Truth::kNone;
  Label label = Label::kNone;
  uint32_t rgb = 0;        ///< 0x00RRGGBB
  float intensity = 0.0F;  ///< 0..255, for reflectivity and incidence
};

/// Where a sensor stands beside the track: `left_m` to the left of it at arc length `s_m`,
/// `height_m` above the ground.
Eigen::Vector3d placeBesideTrack(const World& world, double s_m, double left_m, double height_m);

/// The returns, column by column from forward (+x) to the left, from the lowest row up. `config`
/// must validate. Every beam has random numbers of its own.
std::vector<TruePoint> takeTrueCloud(const Scene& scene, const Eigen::Vector3d& sensor_world,
                                     const TrueCloudConfig& config, uint64_t seed);

}  // namespace ladar_perception::sim
