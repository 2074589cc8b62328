// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "ladar_perception/register/registration_cloud.h"
#include "surface_index.h"

namespace ladar_perception {

/// Points from an origin, with their index by normals.
struct IndexedPoints {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;
  double spacing_m = 0.0;
  std::optional<SurfaceIndex> by_normal;
};

struct RegistrationCloud::Parts {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  IndexedPoints samples;
  IndexedPoints surface;  ///< empty if there is none
  std::size_t dropped = 0;

  const IndexedPoints& finest() const { return surface.positions.empty() ? samples : surface; }
  /// The samples in one tree whatever their normals; built when first asked for.
  const SurfaceIndex& together() const;

 private:
  mutable std::once_flag once_;
  mutable std::optional<SurfaceIndex> together_;
};

}  // namespace ladar_perception
