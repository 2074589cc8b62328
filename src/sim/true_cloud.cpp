// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/true_cloud.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "panes.h"

namespace ladar_perception::sim {
namespace {

constexpr double kRadPerDeg = 3.141592653589793 / 180.0;

/// Beams on a lattice with equal steps of azimuth and elevation.
struct Lattice {
  int columns = 0;
  int rows = 0;
  double low_rad = 0.0;
  double step_rad = 0.0;

  Lattice(const TrueCloudConfig& config, double beams) {
    const double high_rad = kRadPerDeg * (config.high_deg - config.low_deg);
    const double wide_rad = kRadPerDeg * 360.0;
    step_rad = std::sqrt(wide_rad * high_rad / beams);
    columns = std::max(1, static_cast<int>(std::lround(wide_rad / step_rad)));
    step_rad = wide_rad / columns;
    rows = std::max(1, static_cast<int>(std::lround(high_rad / step_rad)));
    low_rad = kRadPerDeg * config.low_deg;
  }
  Eigen::Vector3d beam(int column, int row) const {
    const double azimuth = step_rad * column;
    const double elevation = low_rad + step_rad * (row + 0.5);
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
            std::sin(elevation)};
  }
};

/// Whether the beam came back, and its point.
bool measure(const Scene& scene, const Ray& ray, const TrueCloudConfig& config, Random random,
             TruePoint* point) {
  SurfacePoint surface;
  const auto cast = [&](const Ray& part, double limit_m) {
    Hit hit;
    surface = scene.castRayToSurface(part, limit_m, &hit);
    return hit;
  };
  const Hit hit = castThroughPanes(ray, config.max_range_m, cast, &random);
  if (!hit.valid()) return false;
  const double error_m = config.range_sigma_m * random.normal();
  const double gain = random.normal(1.0, 0.06);
  const MaterialProperties& look = propertiesOf(hit.material);
  point->p_true_m = hit.range * ray.direction;
  point->p_m = (hit.range + error_m) * ray.direction;
  point->normal = surface.normal;
  point->face = surface.face;
  point->truth = hit.truth;
  point->label = look.label;
  point->rgb = hit.rgb;
  const double brightness = look.reflectivity * (0.3 + 0.7 * hit.incidence) * gain;
  point->intensity = static_cast<float>(std::clamp(255.0 * brightness, 0.0, 255.0));
  return true;
}

std::vector<TruePoint> scan(const Scene& scene, const Eigen::Vector3d& sensor_world,
                            const TrueCloudConfig& config, const Lattice& lattice, uint64_t seed) {
  std::vector<TruePoint> points;
  for (int column = 0; column < lattice.columns; ++column) {
    for (int row = 0; row < lattice.rows; ++row) {
      const uint64_t stream =
          streamSeed(seed, {static_cast<uint64_t>(column), static_cast<uint64_t>(row)});
      TruePoint point;
      if (measure(scene, {sensor_world, lattice.beam(column, row)}, config, Random(stream),
                  &point)) {
        points.push_back(point);
      }
    }
  }
  return points;
}

}  // namespace

std::vector<std::string> TrueCloudConfig::validate() const {
  std::vector<std::string> errors;
  const auto require = [&](bool ok, const char* field, double value, const char* rule) {
    if (!ok) errors.push_back(std::string(field) + " = " + std::to_string(value) + ": " + rule);
  };
  require(points >= 1000 && points <= 10000000, "points", points, "must lie in [1000, 10000000]");
  require(low_deg >= -90.0 && low_deg < high_deg, "low_deg", low_deg,
          "must lie in [-90, high_deg)");
  require(high_deg <= 90.0, "high_deg", high_deg, "must not exceed 90");
  require(std::isfinite(max_range_m) && max_range_m > 0.0, "max_range_m", max_range_m,
          "must be positive");
  require(std::isfinite(range_sigma_m) && range_sigma_m >= 0.0, "range_sigma_m", range_sigma_m,
          "must not be negative");
  return errors;
}

Eigen::Vector3d placeBesideTrack(const World& world, double s_m, double left_m, double height_m) {
  const Eigen::Vector2d p = world.circuit.beside(s_m, left_m);
  return {p.x(), p.y(), world.scene.ground().height(p.x(), p.y()) + height_m};
}

std::vector<TruePoint> takeTrueCloud(const Scene& scene, const Eigen::Vector3d& sensor_world,
                                     const TrueCloudConfig& config, uint64_t seed) {
  assert(config.validate().empty());
  // A coarse scan tells which share of the beams comes back from here.
  constexpr double kCoarseBeams = 20000.0;
  const Lattice coarse(config, kCoarseBeams);
  const auto returned = static_cast<double>(scan(scene, sensor_world, config, coarse, seed).size());
  if (returned == 0.0) return {};
  const double share = returned / (static_cast<double>(coarse.columns) * coarse.rows);
  return scan(scene, sensor_world, config, Lattice(config, config.points / share), seed);
}

}  // namespace ladar_perception::sim
