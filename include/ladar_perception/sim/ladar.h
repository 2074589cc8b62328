// SPDX-License-Identifier: BSD-3-Clause
// A ladar described by its table of beams: on a turret, spinning, or sweeping one plane.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/sim/random.h"
#include "ladar_perception/sim/scene.h"
#include "ladar_perception/sim/vehicle_path.h"

namespace ladar_perception::sim {

/// Sensor, mounting and turret. A scan is a table of beams, elevations times azimuths; the default
/// is the turreted range-image ladar of the Demo III vehicle. See sensors.h for others.
struct LadarConfig {
  static constexpr int kMaxRays = 16;

  int columns = 180;
  int rows = 32;
  double width_deg = 90.0;   ///< horizontal field of view; 0: every column looks the same way
  double height_deg = 20.0;  ///< vertical field of view
  /// Elevation of each row, top first; empty: rows lie evenly in height_deg about the horizon.
  std::vector<double> row_elevations_deg;
  /// Azimuths that the field of view is centred on, left of forward; columns take them in turn.
  std::vector<double> heads_deg = {0.0};
  double rate_hz = 20.0;     ///< scans per second; columns are measured one by one
  double row_sweep_s = 0.0;  ///< from the first row of a column to its last; 0: all at once
  double min_range_m = 0.5;
  double max_range_m = 50.0;
  double range_sigma_m = 0.02;
  double range_step_m = 0.0;        ///< ranges are multiples of this; 0: not rounded
  double angle_sigma_deg = 0.03;    ///< of the beam about the direction that is reported
  double divergence_mrad = 4.0;     ///< full angle of the beam
  int rays = 2;                     ///< that stand for the beam: its axis, and others around it
  double drop_probability = 0.012;  ///< returns lost whatever they hit
  double detection_threshold =
      0.008;                        ///< echo, relative to white at max_range_m, seen half the time
  double mixed_probability = 0.25;  ///< range averaged when an echo is followed by another
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
  Eigen::Vector3f p_ladar;  ///< in the sensor frame at the time of this beam
  float intensity = 0.0F;   ///< 0..255, for reflectivity and incidence
  float time_s = 0.0F;      ///< after the first beam
  Truth truth = Truth::kNone;
  Label label = Label::kNone;
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
  /// Time of a beam after the scan's first.
  double beamTime(int row, int column) const;
  Scan takeScan(uint64_t scan) const;

 private:
  using Rays = std::array<Hit, LadarConfig::kMaxRays>;
  struct Echo {
    double range_m = kMiss;
    Hit hit;
    Truth truth = Truth::kNone;
    Label label = Label::kNone;
    bool mixed = false;
  };

  Eigen::Isometry3d T_odom_ladar(double time_s) const;
  Return measure(const Eigen::Isometry3d& T_odom_ladar, int row, int column, Random random) const;
  Hit cast(const Eigen::Isometry3d& T_odom_ladar, const Eigen::Vector3d& direction_ladar,
           Random* random) const;
  Echo receive(Rays* hits, Random* random) const;
  bool detected(const Hit* first, const Hit* last, Random* random) const;
  void mixWith(const Hit& far, Echo* echo, Random* random) const;

  LadarConfig config_;
  const Scene& scene_;
  const VehiclePath& path_;
  uint64_t seed_;
};

}  // namespace ladar_perception::sim
