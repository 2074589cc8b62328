// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/ladar.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "panes.h"

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

/// Whether the receiver takes two hits, the first one nearer, for one echo.
bool isSameDepth(const Hit& near, const Hit& far) {
  const double gap_m = far.range - near.range;
  const bool same_plane =
      near.material == far.material && near.truth == Truth::kSurface && gap_m < 1.0;
  return gap_m <= kSameDepthM || same_plane;
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
  require(width_deg >= 0.0 && width_deg <= 360.0, "width_deg", width_deg, "must lie in [0, 360]");
  require(height_deg > 0.0 && height_deg <= 180.0, "height_deg", height_deg,
          "must lie in (0, 180]");
  const std::size_t elevations = row_elevations_deg.size();
  require(elevations == 0 || elevations == static_cast<std::size_t>(rows), "row_elevations_deg",
          static_cast<double>(elevations), "must have no entry or one per row");
  for (const double elevation : row_elevations_deg) {
    require(std::abs(elevation) < 90.0, "row_elevations_deg", elevation, "must lie in (-90, 90)");
  }
  require(!heads_deg.empty() && columns % static_cast<int>(heads_deg.size()) == 0, "heads_deg",
          static_cast<double>(heads_deg.size()), "must have entries whose number divides columns");
  for (const double head : heads_deg) {
    require(std::abs(head) <= 180.0, "heads_deg", head, "must lie in [-180, 180]");
  }
  positive(rate_hz, "rate_hz");
  require(row_sweep_s >= 0.0 && row_sweep_s * rate_hz * columns <= 1.0, "row_sweep_s", row_sweep_s,
          "must not be negative, and must end before the next column");
  notNegative(min_range_m, "min_range_m");
  require(max_range_m > min_range_m, "max_range_m", max_range_m, "must exceed min_range_m");
  notNegative(range_sigma_m, "range_sigma_m");
  notNegative(angle_sigma_deg, "angle_sigma_deg");
  notNegative(range_step_m, "range_step_m");
  notNegative(divergence_mrad, "divergence_mrad");
  require(rays >= 1 && rays <= kMaxRays, "rays", rays, "must lie in 1..16");
  share(drop_probability, "drop_probability");
  notNegative(detection_threshold, "detection_threshold");
  share(mixed_probability, "mixed_probability");
  notNegative(mixed_limit_m, "mixed_limit_m");
  positive(nod_period_s, "nod_period_s");
  positive(pan_period_s, "pan_period_s");
  notNegative(mount_height_m, "mount_height_m");
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
  const auto heads = static_cast<int>(config_.heads_deg.size());
  const double across = (column / heads + 0.5) / (config_.columns / heads);
  const double azimuth =
      kRadPerDeg * (config_.heads_deg[column % heads] + config_.width_deg * (0.5 - across));
  const double elevation =
      kRadPerDeg * (config_.row_elevations_deg.empty()
                        ? config_.height_deg * (0.5 - (row + 0.5) / config_.rows)
                        : config_.row_elevations_deg[row]);
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

double Ladar::beamTime(int row, int column) const {
  return config_.scanPeriod() * column / config_.columns + config_.row_sweep_s * row / config_.rows;
}

Eigen::Isometry3d Ladar::T_odom_ladar(double time_s) const {
  return path_.T_odom_base(time_s) * T_base_ladar(time_s);
}

Scan Ladar::takeScan(uint64_t scan) const {
  Scan returns(static_cast<std::size_t>(config_.columns) * config_.rows);
  for (int column = 0; column < config_.columns; ++column) {
    Eigen::Isometry3d pose = T_odom_ladar(startTime(scan) + beamTime(0, column));
    for (int row = 0; row < config_.rows; ++row) {
      const double time_s = beamTime(row, column);
      if (row > 0 && config_.row_sweep_s > 0.0) pose = T_odom_ladar(startTime(scan) + time_s);
      const uint64_t stream =
          streamSeed(seed_, {scan, static_cast<uint64_t>(column), static_cast<uint64_t>(row)});
      Return& result = returns[static_cast<std::size_t>(row) * config_.columns + column];
      result = measure(pose, row, column, Random(stream));
      result.time_s = static_cast<float>(time_s);
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
  const Eigen::Vector3d axis = deflect(nominal, left_rad, up_rad);
  Rays hits;
  hits[0] = cast(T_odom_ladar, axis, &random);
  // The other rays, spread over the footprint, tell what else the beam lies on.
  for (int i = 1; i < config_.rays; ++i) {
    const double out = std::sqrt((i - 1 + random.uniform()) / (config_.rays - 1));
    const double off_axis = 0.5e-3 * config_.divergence_mrad * out;
    const double turn = 2.0 * kPi * random.uniform();
    const Eigen::Vector3d side =
        deflect(axis, off_axis * std::cos(turn), off_axis * std::sin(turn));
    hits[i] = cast(T_odom_ladar, side, &random);
  }
  const Echo echo = receive(&hits, &random);
  if (!echo.hit.valid()) return result;
  double range_m = echo.range_m + config_.range_sigma_m * random.normal();
  if (config_.range_step_m > 0.0) {
    range_m = config_.range_step_m * std::round(range_m / config_.range_step_m);
  }
  if (range_m < config_.min_range_m || range_m > config_.max_range_m) return result;

  result.p_ladar = (range_m * nominal).cast<float>();
  result.mixed = echo.mixed;
  result.truth = echo.truth;
  result.label = echo.label;
  result.rgb = echo.hit.rgb;
  const double brightness = propertiesOf(echo.hit.material).reflectivity *
                            (0.3 + 0.7 * echo.hit.incidence) * random.normal(1.0, 0.06);
  result.intensity = static_cast<float>(std::clamp(255.0 * brightness, 0.0, 255.0));
  return result;
}

Hit Ladar::cast(const Eigen::Isometry3d& T_odom_ladar, const Eigen::Vector3d& direction_ladar,
                Random* random) const {
  // Beyond the last range by a few sigma, so that noise can bring a return into range.
  const double limit_m = config_.max_range_m + 4.0 * config_.range_sigma_m;
  const Eigen::Vector3d direction = T_odom_ladar.linear() * direction_ladar;
  return castThroughPanes(
      {T_odom_ladar.translation(), direction}, limit_m,
      [&](const Ray& ray, double ray_limit_m) { return scene_.castRay(ray, ray_limit_m); }, random);
}

Ladar::Echo Ladar::receive(Rays* hits, Random* random) const {
  Echo echo;
  if (random->chance(config_.drop_probability)) return echo;
  const Hit axis = hits->front();
  const auto end = hits->begin() + config_.rays;
  std::sort(hits->begin(), end, [](const Hit& a, const Hit& b) { return a.range < b.range; });
  // Echoes from near to far: the receiver takes the first that is strong enough.
  for (auto first = hits->begin(); first != end && first->valid();) {
    auto next = first + 1;
    while (next != end && next->valid() && isSameDepth(next[-1], *next)) ++next;
    const bool seen = detected(&*first, &*first + (next - first), random);
    if (seen) {
      echo.hit = *first;
      echo.truth = first->truth;
      echo.label = propertiesOf(first->material).label;
      // The beam's axis, if it is part of the echo: a slanted plane must not come nearer.
      const bool holds_axis = axis.range >= first->range && axis.range <= next[-1].range;
      echo.range_m = holds_axis ? axis.range : first->range;
      if (holds_axis) echo.hit = axis;
      if (next != end && next->valid()) mixWith(*next, &echo, random);
      return echo;
    }
    first = next;
  }
  return echo;
}

bool Ladar::detected(const Hit* first, const Hit* last, Random* random) const {
  double strength = 0.0;
  for (const Hit* hit = first; hit != last; ++hit) {
    strength += propertiesOf(hit->material).reflectivity * hit->incidence / config_.rays;
  }
  const double relative_range = first->range / config_.max_range_m;
  const double signal = strength / std::max(relative_range * relative_range, 1e-6);
  return random->chance(signal / (signal + config_.detection_threshold));
}

void Ladar::mixWith(const Hit& far, Echo* echo, Random* random) const {
  if (far.range - echo->range_m > config_.mixed_limit_m) return;
  if (!random->chance(config_.mixed_probability)) return;
  const double weight = random->uniform(0.15, 0.85);
  echo->range_m = weight * echo->range_m + (1.0 - weight) * far.range;
  echo->mixed = true;
  if (far.truth == echo->truth) return;  // between two leaves is still inside the crown
  echo->truth = Truth::kNone;
  echo->label = Label::kNone;
}

}  // namespace ladar_perception::sim
