// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ladar_perception/resample/voxel_pyramid.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

struct PointNormals {
  std::vector<Eigen::Vector3f> normals;  ///< by source; zero where there are too few points
  std::vector<float> variation;  ///< by source: variance of the angle to normals around, rad^2
};

/// Normals by the planes of voxels and their 26 neighbours, of the first size at which these hold
/// kPlanePoints, towards the sensor (in cells). The variation compares the voxels of that size.
PointNormals pointNormals(const GridPoints& points, const VoxelPyramid& pyramid,
                          const Eigen::Vector3f& sensor, ThreadPool* pool);

}  // namespace ladar_perception
