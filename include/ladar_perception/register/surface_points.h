// SPDX-License-Identifier: BSD-3-Clause
// From a scan to points of surfaces: what is no return is dropped, voxels are averaged, normals
// point to the sensor. For clouds that no re-sampler has given normals.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ladar_perception/register/oriented_points.h"

namespace ladar_perception {

/// Nearer returns are of the vehicle itself, or noise.
constexpr double kNearestReturn_m = 0.5;

/// Indices of the points that are measurements: finite, at least kNearestReturn_m from the sensor,
/// and not at the range that some sensors report where nothing came back. Such returns lie on a
/// thin shell that is the farthest of the cloud and stands out by ten times from the ranges below.
std::vector<uint32_t> plausibleReturns(const std::vector<Eigen::Vector3d>& positions_m,
                                       const Eigen::Vector3d& sensor_m);

/// Centroids of about `count` voxels (within a tenth; fewer if there are fewer points), whose size
/// is chosen for that, with normals by principal components of the 12 nearest centroids. Normals
/// are zero where these lie on a line. Needs finite positions.
OrientedPoints surfaceCentroids(const std::vector<Eigen::Vector3d>& positions_m,
                                const Eigen::Vector3d& sensor_m, int count = 30000);

/// The positions, each with the normal of the nearest point of `surface`.
OrientedPoints withNormalsOf(const OrientedPoints& surface,
                             const std::vector<Eigen::Vector3d>& positions_m);

}  // namespace ladar_perception
