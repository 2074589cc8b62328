// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ladar_perception/resample/voxel_pyramid.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// For every place, in cells, the nearest point: its place in the sorted order of `points`, of
/// which there must be one at least. Exact; of several the first.
std::vector<uint32_t> nearestPoints(const GridPoints& points, const VoxelPyramid& pyramid,
                                    const std::vector<Eigen::Vector3f>& places, ThreadPool* pool);

}  // namespace ladar_perception
