// SPDX-License-Identifier: BSD-3-Clause
// Range-image ladar on a turret, after the one of the Demo III experimental unmanned vehicle.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/sim/random.h"
#include "ladar_perception/sim/scene.h"
#include "ladar_perception/sim/vehicle_path.h"

namespace ladar_perception::sim {

/// Sensor, mounting and turret.
struct LadarConfig {
  int columns = 180;
  int rows = 32;
  double width_deg = 90.0;   ///< horizontal field of view
  double height_deg = 20.0;  ///< vertical field of view
  double rate_hz = 20.0;     ///< scans per second; columns are measured one by one
  double min_range_m = 0.5;
  double max_range_m = 50.0;
  double range_sigma_m = 0.02;
  double angle_sigma_deg = 0.03;    ///< of the beam about the direction that is reported
  double divergence_mrad = 4.0;     ///< full angle of the beam
  double drop_probability = 0.012;  ///< returns lost whatever they hit
  double detection_threshold =
      0.008;                        ///< echo, relative to white at max_range_m, seen half the time
  double mixed_probability = 0.25;  ///< range averaged when a beam meets two depths
  double mixed_limit_m = 5.0;       ///< depths further apart are told apart by the receiver
  double mount_forward_m = 0.6;     ///< turret ahead of base_link
  double mount_height_m = 1.7;      ///< turret above base_link
  double tilt_down_deg = 8.0;
  double nod_amplitude_deg = 4.0;  ///< slow tilt around tilt_down_deg
  double nod_period_s = 11.0;
  double pan_amplitude_deg = 40.0;
  double pan_period_s = 9.0;

  /// Every violation as "field = value: rule"; empty if the sensor can be built.
  std::vector<std::string> validate() const;
  double scanPeriod() const { return 1.0 / rate_hz; }
};

/// One beam of a scan. Without a return, p_ladar is NaN and the rest is 0.
struct Return {
  Eigen::Vector3f p_ladar;  ///< in the sensor frame at the time of this column
  float intensity = 0.0F;   ///< 0..255, for reflectivity and incidence
  float time_s = 0.0F;      ///< after the first column
  Truth truth = Truth::kNone;
  bool mixed = false;
  uint32_t rgb = 0;  ///< 0x00RRGGBB

  bool valid() const { return p_ladar.x() == p_ladar.x(); }
};

/// Row by row from the top, columns from left to right.
using Scan = std::vector<Return>;

/// Takes scans of a scene from a moving vehicle. Every beam has random numbers of its own, named
/// by (seed, scan, column, row): results do not depend on the order of evaluation.
class Ladar {
 public:
  /// `config` must validate; `scene` and `path` must outlive the ladar.
  Ladar(const LadarConfig& config, const Scene& scene, const VehiclePath& path, uint64_t seed);

  const LadarConfig& config() const { return config_; }
  /// Pose of the turret on the vehicle. Sensor axes: x forward, y left, z up.
  Eigen::Isometry3d T_base_ladar(double time_s) const;
  /// Direction reported for a beam, in the sensor frame; unit length.
  Eigen::Vector3d beam(int row, int column) const;
  double startTime(uint64_t scan) const { return static_cast<double>(scan) / config_.rate_hz; }
  /// Time of a column after the scan's first.
  double columnTime(int column) const;
  Scan takeScan(uint64_t scan) const;

 private:
  struct Echo {
    double range_m = kMiss;
    double incidence = 0.0;
    Hit hit;
    bool mixed = false;
  };

  Return measure(const Eigen::Isometry3d& T_odom_ladar, int row, int column, Random random) const;
  Hit cast(const Eigen::Isometry3d& T_odom_ladar, const Eigen::Vector3d& direction_ladar) const;
  Echo combine(const Hit& centre, const Hit& side, Random* random) const;
  bool detected(const Echo& echo, Random* random) const;

  LadarConfig config_;
  const Scene& scene_;
  const VehiclePath& path_;
  uint64_t seed_;
};

}  // namespace ladar_perception::sim
