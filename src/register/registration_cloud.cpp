// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/register/registration_cloud.h"

#include <algorithm>
#include <cmath>

#include "registration_cloud_parts.h"

namespace ladar_perception {
namespace {

/// More points than these do not make a median better.
constexpr std::size_t kSpacingPoints = 500;

bool usable(const Eigen::Vector3d& position_m, const Eigen::Vector3f& normal) {
  return position_m.allFinite() && std::abs(normal.squaredNorm() - 1.0F) < 1e-2F;
}

Eigen::Vector3d originOf(const OrientedPoints& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!usable(points.positions_m[i], points.normals[i])) continue;
    sum += points.positions_m[i];
    ++count;
  }
  return count == 0 ? sum : Eigen::Vector3d(sum / static_cast<double>(count));
}

double medianSpacing(const std::vector<Eigen::Vector3f>& positions) {
  if (positions.size() < 2) return 0.0;
  const SurfaceIndex tree(positions, {}, false);
  const std::size_t step = std::max<std::size_t>(positions.size() / kSpacingPoints, 1);
  std::vector<uint32_t> found;
  std::vector<float> squared;
  std::vector<float> nearest;
  for (std::size_t i = 0; i < positions.size(); i += step) {
    tree.nearest(positions[i], 2, &found, &squared);
    nearest.push_back(squared[1]);
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return std::sqrt(static_cast<double>(*middle));
}

IndexedPoints indexed(const OrientedPoints& points, const Eigen::Vector3d& origin_m) {
  IndexedPoints out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!usable(points.positions_m[i], points.normals[i])) continue;
    out.positions.emplace_back((points.positions_m[i] - origin_m).cast<float>());
    out.normals.push_back(points.normals[i].normalized());
  }
  out.spacing_m = medianSpacing(out.positions);
  out.by_normal.emplace(out.positions, out.normals, true);
  return out;
}

}  // namespace

const SurfaceIndex& RegistrationCloud::Parts::together() const {
  std::call_once(once_, [&] { together_.emplace(samples.positions, samples.normals, false); });
  return *together_;
}

RegistrationCloud::RegistrationCloud(const OrientedPoints& samples, const OrientedPoints& surface) {
  auto parts = std::make_shared<Parts>();
  parts->origin_m = originOf(samples);
  parts->samples = indexed(samples, parts->origin_m);
  parts->surface = indexed(surface, parts->origin_m);
  parts->dropped = samples.size() - parts->samples.positions.size();
  parts_ = std::move(parts);
}

const Eigen::Vector3d& RegistrationCloud::origin_m() const { return parts_->origin_m; }
const std::vector<Eigen::Vector3f>& RegistrationCloud::positions() const {
  return parts_->samples.positions;
}
const std::vector<Eigen::Vector3f>& RegistrationCloud::normals() const {
  return parts_->samples.normals;
}
std::size_t RegistrationCloud::size() const { return parts_->samples.positions.size(); }
std::size_t RegistrationCloud::dropped() const { return parts_->dropped; }
double RegistrationCloud::spacing_m() const { return parts_->samples.spacing_m; }

}  // namespace ladar_perception
