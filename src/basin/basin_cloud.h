// SPDX-License-Identifier: BSD-3-Clause
// Clouds of a study of registrations, from files.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "ladar_perception/register/oriented_points.h"
#include "ladar_perception/resample/policy.h"

namespace ladar_perception {

/// A scan without what is no measurement, and the surface it shows.
struct BasinCloud {
  PoseCloudData points;
  OrientedPoints surface;
};

/// Reads PCD, PLY, text (x y z), VTK, 3DTK, KITTI .bin or Oakland by the file's extension, with the
/// fields rgb and label if it has them. Throws std::runtime_error that names the file if it cannot
/// be read or has no points left.
BasinCloud readBasinCloud(const std::string& path, const Eigen::Vector3d& sensor_m);

/// A rigid transform as 4 rows of 4 numbers (or 3 of 4). Throws std::runtime_error that names the
/// file and what is wrong.
Eigen::Isometry3d readTransform(const std::string& path);

}  // namespace ladar_perception
