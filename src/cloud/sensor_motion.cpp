// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/cloud/sensor_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace ladar_perception {

SensorMotion::SensorMotion(std::vector<Knot> knots) : knots_(std::move(knots)) {
  assert(!knots_.empty());
}

bool SensorMotion::isFinite() const {
  return std::all_of(knots_.begin(), knots_.end(),
                     [](const Knot& knot) { return knot.T_map_sensor.matrix().allFinite(); });
}

Eigen::Isometry3d SensorMotion::poseAt(double offset_s) const {
  if (offset_s <= knots_.front().offset_s) return knots_.front().T_map_sensor;
  if (offset_s >= knots_.back().offset_s) return knots_.back().T_map_sensor;
  const auto after =
      std::upper_bound(knots_.begin(), knots_.end(), offset_s,
                       [](double offset, const Knot& knot) { return offset < knot.offset_s; });
  const Knot& a = *std::prev(after);
  const Knot& b = *after;
  const double t = (offset_s - a.offset_s) / (b.offset_s - a.offset_s);
  const Eigen::Quaterniond rotation_a(a.T_map_sensor.linear());
  const Eigen::Quaterniond rotation_b(b.T_map_sensor.linear());
  Eigen::Isometry3d pose(rotation_a.slerp(t, rotation_b));
  pose.translation() = (1.0 - t) * a.T_map_sensor.translation() + t * b.T_map_sensor.translation();
  return pose;
}

void MotionTable::assign(const SensorMotion& motion) {
  const auto& knots = motion.knots();
  const double duration_s = knots.back().offset_s - knots.front().offset_s;
  begin_s_ = knots.front().offset_s;
  const int steps = duration_s > 0.0 ? kSteps : 1;
  steps_per_s_ = duration_s > 0.0 ? (steps - 1) / duration_s : 0.0;
  poses_.resize(steps);
  for (int i = 0; i < steps; ++i) {
    poses_[i] = motion.poseAt(steps == 1 ? 0.0 : begin_s_ + i / steps_per_s_);
  }
}

}  // namespace ladar_perception
