// SPDX-License-Identifier: BSD-3-Clause
// Where the vehicle is at a given time.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "ladar_perception/sim/circuit.h"
#include "ladar_perception/sim/height_field.h"

namespace ladar_perception::sim {

/// Drives round a circuit at constant speed. Height, roll and pitch follow the ground under the
/// wheels through a low-pass, as suspension and tyres do.
class VehiclePath {
 public:
  /// `speed_m_s` >= 0. The vehicle starts at arc length 0 at time 0; negative times are valid.
  VehiclePath(const Circuit& circuit, const HeightField& ground, double speed_m_s);

  /// Pose of `base_link`, on the ground below the vehicle's middle: x forward, z up.
  Eigen::Isometry3d T_odom_base(double time_s) const;

 private:
  struct Attitude {
    double height_m = 0.0;
    double pitch_rad = 0.0;  // positive: nose down (REP-103)
    double roll_rad = 0.0;   // positive: left side up
  };

  static Attitude restOn(const Circuit& circuit, const HeightField& ground, double s_m);
  Attitude attitudeAt(double s_m) const;

  Circuit circuit_;
  double speed_m_s_;
  double step_m_ = 0.1;
  std::vector<Attitude> attitudes_;  // periodic in the arc length
};

}  // namespace ladar_perception::sim
