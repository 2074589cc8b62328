// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/ladar.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace ladar_perception::sim {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kRadPerDeg = kPi / 180.0;
// Depths closer than this are one surface to the receiver.
constexpr double kSameDepthM = 0.12;

/// Direction turned by small angles left and up.
Eigen::Vector3d deflect(const Eigen::Vector3d& direction, double left_rad, double up_rad) {
  const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(direction).normalized();
  return (direction + left_rad * left + up_rad * direction.cross(left)).normalized();
}

}  // namespace

std::vector<std::string> LadarConfig::validate() const {
  std::vector<std::string> errors;
  const auto require = [&](bool ok, const char* field, double value, const char* rule) {
    if (!ok) errors.push_back(std::string(field) + " = " + std::to_string(value) + ": " + rule);
  };
  const auto share = [&](double value, const char* field) {
    require(value >= 0.0 && value <= 1.0, field, value, "must lie in [0, 1]");
  };
  const auto positive = [&](double value, const char* field) {
    require(std::isfinite(value) && value > 0.0, field, value, "must be positive");
  };
  const auto notNegative = [&](double value, const char* field) {
    require(std::isfinite(value) && value >= 0.0, field, value, "must not be negative");
  };
  require(columns > 0, "columns", columns, "must be positive");
  require(rows > 0 && rows <= 65536, "rows", rows, "must lie in 1..65536");
  require(width_deg > 0.0 && width_deg <= 360.0, "width_deg", width_deg, "must lie in (0, 360]");
  require(height_deg > 0.0 && height_deg <= 170.0, "height_deg", height_deg,
          "must lie in (0, 170]");
  positive(rate_hz, "rate_hz");
  notNegative(min_range_m, "min_range_m");
  require(max_range_m > min_range_m, "max_range_m", max_range_m, "must exceed min_range_m");
  notNegative(range_sigma_m, "range_sigma_m");
  notNegative(angle_sigma_deg, "angle_sigma_deg");
  notNegative(divergence_mrad, "divergence_mrad");
  share(drop_probability, "drop_probability");
  notNegative(detection_threshold, "detection_threshold");
  share(mixed_probability, "mixed_probability");
  notNegative(mixed_limit_m, "mixed_limit_m");
  positive(nod_period_s, "nod_period_s");
  positive(pan_period_s, "pan_period_s");
  return errors;
}

Ladar::Ladar(const LadarConfig& config, const Scene& scene, const VehiclePath& path, uint64_t seed)
    : config_(config), scene_(scene), path_(path), seed_(seed) {
  assert(config.validate().empty());
}

Eigen::Isometry3d Ladar::T_base_ladar(double time_s) const {
  const double pan_deg =
      config_.pan_amplitude_deg * std::sin(2.0 * kPi * time_s / config_.pan_period_s);
  const double down_deg =
      config_.tilt_down_deg +
      config_.nod_amplitude_deg * std::sin(2.0 * kPi * time_s / config_.nod_period_s);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << config_.mount_forward_m, 0.0, config_.mount_height_m;
  pose.linear() = (Eigen::AngleAxisd(pan_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(down_deg * kRadPerDeg, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix();
  return pose;
}

Eigen::Vector3d Ladar::beam(int row, int column) const {
  const double azimuth = kRadPerDeg * config_.width_deg * (0.5 - (column + 0.5) / config_.columns);
  const double elevation = kRadPerDeg * config_.height_deg * (0.5 - (row + 0.5) / config_.rows);
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

double Ladar::columnTime(int column) const {
  return config_.scanPeriod() * column / config_.columns;
}

Scan Ladar::takeScan(uint64_t scan) const {
  Scan returns(static_cast<std::size_t>(config_.columns) * config_.rows);
  for (int column = 0; column < config_.columns; ++column) {
    const double time_s = startTime(scan) + columnTime(column);
    const Eigen::Isometry3d T_odom_ladar = path_.T_odom_base(time_s) * T_base_ladar(time_s);
    for (int row = 0; row < config_.rows; ++row) {
      const uint64_t stream =
          streamSeed(seed_, {scan, static_cast<uint64_t>(column), static_cast<uint64_t>(row)});
      Return& result = returns[static_cast<std::size_t>(row) * config_.columns + column];
      result = measure(T_odom_ladar, row, column, Random(stream));
      result.time_s = static_cast<float>(columnTime(column));
    }
  }
  return returns;
}

Return Ladar::measure(const Eigen::Isometry3d& T_odom_ladar, int row, int column,
                      Random random) const {
  Return result;
  result.p_ladar.setConstant(std::numeric_limits<float>::quiet_NaN());
  const double sigma = config_.angle_sigma_deg * kRadPerDeg;
  const Eigen::Vector3d nominal = beam(row, column);
  const double left_rad = sigma * random.normal();  // named: the order of arguments is not fixed
  const double up_rad = sigma * random.normal();
  const Eigen::Vector3d centre = deflect(nominal, left_rad, up_rad);
  // One more ray, anywhere in the footprint, tells whether the beam lies across an edge.
  const double off_axis = 0.5e-3 * config_.divergence_mrad * std::sqrt(random.uniform());
  const double turn = 2.0 * kPi * random.uniform();
  const Eigen::Vector3d side =
      deflect(centre, off_axis * std::cos(turn), off_axis * std::sin(turn));

  const Echo echo = combine(cast(T_odom_ladar, centre), cast(T_odom_ladar, side), &random);
  if (!echo.hit.valid() || !detected(echo, &random)) return result;
  const double range_m = echo.range_m + config_.range_sigma_m * random.normal();
  if (range_m < config_.min_range_m || range_m > config_.max_range_m) return result;

  result.p_ladar = (range_m * nominal).cast<float>();
  result.mixed = echo.mixed;
  result.truth = echo.mixed ? Truth::kNone : echo.hit.truth;
  result.rgb = echo.hit.rgb;
  const double brightness = propertiesOf(echo.hit.material).reflectivity *
                            (0.3 + 0.7 * echo.hit.incidence) * random.normal(1.0, 0.06);
  result.intensity = static_cast<float>(std::clamp(255.0 * brightness, 0.0, 255.0));
  return result;
}

Hit Ladar::cast(const Eigen::Isometry3d& T_odom_ladar,
                const Eigen::Vector3d& direction_ladar) const {
  // Beyond the last range by a few sigma, so that noise can bring a return into range.
  const double limit_m = config_.max_range_m + 4.0 * config_.range_sigma_m;
  return scene_.castRay({T_odom_ladar.translation(), T_odom_ladar.linear() * direction_ladar},
                        limit_m);
}

Ladar::Echo Ladar::combine(const Hit& centre, const Hit& side, Random* random) const {
  if (!side.valid() || !centre.valid()) {
    // Half of the light is lost to the sky.
    const Hit& only = centre.valid() ? centre : side;
    return {only.range, only.incidence, random->chance(0.5) ? only : Hit(), false};
  }
  const double gap_m = std::abs(centre.range - side.range);
  const bool same_plane =
      centre.material == side.material && centre.truth == Truth::kSurface && gap_m < 1.0;
  if (gap_m <= kSameDepthM || same_plane) return {centre.range, centre.incidence, centre, false};
  const Hit& near = centre.range < side.range ? centre : side;
  if (gap_m < config_.mixed_limit_m && random->chance(config_.mixed_probability)) {
    const double weight = random->uniform(0.15, 0.85);
    return {weight * centre.range + (1.0 - weight) * side.range, near.incidence, near, true};
  }
  // Otherwise one of the two echoes wins; the first one more often.
  const Hit& winner = random->chance(0.5) ? near : centre;
  return {winner.range, winner.incidence, winner, false};
}

bool Ladar::detected(const Echo& echo, Random* random) const {
  const double relative_range = echo.range_m / config_.max_range_m;
  const double signal = propertiesOf(echo.hit.material).reflectivity * echo.incidence /
                        std::max(relative_range * relative_range, 1e-6);
  const double probability =
      (1.0 - config_.drop_probability) * signal / (signal + config_.detection_threshold);
  return random->chance(probability);
}

}  // namespace ladar_perception::sim
