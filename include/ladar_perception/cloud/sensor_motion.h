// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// Where the sensor was while it measured a scan: poses at instants, linear in between.
class SensorMotion {
 public:
  struct Knot {
    double offset_s = 0.0;  ///< from the scan's stamp
    Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  };

  /// A sensor at rest.
  explicit SensorMotion(const Eigen::Isometry3d& T_map_sensor) : knots_{{0.0, T_map_sensor}} {}
  /// `knots` by strictly ascending offset, at least one.
  explicit SensorMotion(std::vector<Knot> knots);

  const std::vector<Knot>& knots() const { return knots_; }
  bool isFinite() const;
  /// Translation linear, rotation by slerp between the knots; the end poses beyond them.
  Eigen::Isometry3d poseAt(double offset_s) const;

 private:
  std::vector<Knot> knots_;
};

/// Poses at `kSteps` instants over a motion, to look up per point: at 15 m/s and 100 ms a scan the
/// nearest instant is within 0.7 mm.
class MotionTable {
 public:
  void assign(const SensorMotion& motion);
  LADAR_INLINE const Eigen::Isometry3d& nearest(float offset_s) const {
    const double step = (offset_s - begin_s_) * steps_per_s_ + 0.5;
    const double last = static_cast<double>(poses_.size()) - 1.0;
    return poses_[static_cast<std::size_t>(std::min(std::max(step, 0.0), last))];
  }

 private:
  static constexpr int kSteps = 1024;

  double begin_s_ = 0.0;
  double steps_per_s_ = 0.0;
  std::vector<Eigen::Isometry3d> poses_;
};

}  // namespace ladar_perception
