// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/vehicle_path.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ladar_perception::sim {
namespace {

// The Demo III XUV is about 3 m long and 1.7 m wide.
constexpr double kHalfWheelBaseM = 1.1;
constexpr double kHalfTrackM = 0.75;
constexpr double kSuspensionSigmaM = 0.8;

}  // namespace

VehiclePath::VehiclePath(const Circuit& circuit, const HeightField& ground, double speed_m_s)
    : circuit_(circuit), speed_m_s_(speed_m_s) {
  const auto count = static_cast<int>(std::ceil(circuit.length() / 0.1));
  step_m_ = circuit.length() / count;
  std::vector<Attitude> rests;
  for (int i = 0; i < count; ++i) rests.push_back(restOn(circuit, ground, i * step_m_));

  const auto reach = static_cast<int>(std::ceil(3.0 * kSuspensionSigmaM / step_m_));
  attitudes_.resize(rests.size());
  for (int i = 0; i < count; ++i) {
    Attitude sum;
    double weight_sum = 0.0;
    for (int k = -reach; k <= reach; ++k) {
      const double z = k * step_m_ / kSuspensionSigmaM;
      const double weight = std::exp(-0.5 * z * z);
      const Attitude& rest = rests[((i + k) % count + count) % count];
      weight_sum += weight;
      sum.height_m += weight * rest.height_m;
      sum.pitch_rad += weight * rest.pitch_rad;
      sum.roll_rad += weight * rest.roll_rad;
    }
    attitudes_[i] = {sum.height_m / weight_sum, sum.pitch_rad / weight_sum,
                     sum.roll_rad / weight_sum};
  }
}

VehiclePath::Attitude VehiclePath::restOn(const Circuit& circuit, const HeightField& ground,
                                          double s_m) {
  const Eigen::Vector2d p = circuit.position(s_m);
  const double heading = circuit.heading(s_m);
  const Eigen::Vector2d ahead =
      kHalfWheelBaseM * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  const Eigen::Vector2d left = kHalfTrackM * Eigen::Vector2d(-std::sin(heading), std::cos(heading));
  const auto wheel = [&](double x, double y) {
    const Eigen::Vector2d contact = p + x * ahead + y * left;
    return ground.height(contact.x(), contact.y());
  };
  const std::array<double, 4> h = {wheel(1, 1), wheel(1, -1), wheel(-1, 1), wheel(-1, -1)};
  const double nose_up = (h[0] + h[1] - h[2] - h[3]) / (4.0 * kHalfWheelBaseM);
  const double left_up = (h[0] - h[1] + h[2] - h[3]) / (4.0 * kHalfTrackM);
  return {0.25 * (h[0] + h[1] + h[2] + h[3]), -std::atan(nose_up), std::atan(left_up)};
}

VehiclePath::Attitude VehiclePath::attitudeAt(double s_m) const {
  const double s = s_m - circuit_.length() * std::floor(s_m / circuit_.length());
  const auto count = static_cast<int>(attitudes_.size());
  const int i = std::min(static_cast<int>(s / step_m_), count - 1);
  const double u = s / step_m_ - i;
  // Catmull-Rom: no kinks for the vehicle to shake at.
  const std::array<double, 4> w = {0.5 * u * (u * (2.0 - u) - 1.0),
                                   0.5 * (u * u * (3.0 * u - 5.0) + 2.0),
                                   0.5 * u * (u * (4.0 - 3.0 * u) + 1.0), 0.5 * u * u * (u - 1.0)};
  Attitude result;
  for (int k = 0; k < 4; ++k) {
    const Attitude& knot = attitudes_[(i + k - 1 + count) % count];
    result.height_m += w[k] * knot.height_m;
    result.pitch_rad += w[k] * knot.pitch_rad;
    result.roll_rad += w[k] * knot.roll_rad;
  }
  return result;
}

Eigen::Isometry3d VehiclePath::T_odom_base(double time_s) const {
  const double s = speed_m_s_ * time_s;
  const Eigen::Vector2d p = circuit_.position(s);
  const Attitude attitude = attitudeAt(s);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << p.x(), p.y(), attitude.height_m;
  pose.linear() = (Eigen::AngleAxisd(circuit_.heading(s), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(attitude.pitch_rad, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(attitude.roll_rad, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

}  // namespace ladar_perception::sim
