// SPDX-License-Identifier: BSD-3-Clause
// Ways to choose the points of a cloud that are registered.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "basin_cloud.h"

namespace ladar_perception {

/// "raw" (all points), "voxel_grid", "voxel_grid_25m" (cropped to that range from the sensor),
/// "random", "fps" (these four from PCL or plain), or policies of the re-sampler, such as
/// "range:min=3", several multiplied as "range+label:surface=0.5".
struct Sampling {
  std::string method;
  int count = 0;
  uint64_t seed = 1;
};

struct SampledCloud {
  OrientedPoints points;
  double sampling_ms = 0.0;
};

/// Throws std::invalid_argument with what is wrong with the method's name.
void checkMethod(const std::string& method);

/// Splits "raw,label:surface=0.2,linear=5,range" into three methods: what has a '=' and no ':' goes
/// with what is before it.
std::vector<std::string> splitMethods(const std::string& list);

/// Samples with the normals of the cloud's surface. Throws std::runtime_error where a policy needs
/// a field that the cloud lacks.
SampledCloud sampleCloud(const BasinCloud& cloud, const Sampling& sampling);

/// Centroids of PCL's VoxelGrid, as near to `count` and not above it as its leaf size allows.
std::vector<Eigen::Vector3d> pclVoxelGrid(const std::vector<Eigen::Vector3d>& points_m,
                                          std::size_t count);
/// PCL's FarthestPointSampling.
std::vector<Eigen::Vector3d> pclFarthestPoints(const std::vector<Eigen::Vector3d>& points_m,
                                               std::size_t count);

}  // namespace ladar_perception
