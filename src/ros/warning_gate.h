// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <array>
#include <cstddef>

namespace ladar_perception {

/// Lets a warning through once in a while for each of its reasons, so that one that is frequent
/// does not hide another. (ROS_WARN_THROTTLE has one period for all, and for all nodes of a
/// process.)
template <std::size_t kReasons>
class WarningGate {
 public:
  template <typename Reason>
  bool opens(Reason reason) {
    ros::WallTime& last = last_[static_cast<std::size_t>(reason)];
    const ros::WallTime now = ros::WallTime::now();
    if (!last.isZero() && (now - last).toSec() < kPeriod_s) return false;
    last = now;
    return true;
  }

 private:
  static constexpr double kPeriod_s = 5.0;

  std::array<ros::WallTime, kReasons> last_{};
};

}  // namespace ladar_perception
