// SPDX-License-Identifier: BSD-3-Clause
// Ways to take fewer points from a cloud, ours and those of other libraries, behind one face.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "ladar_perception/resample/cloud_resampler.h"

namespace ladar_perception::bench {

using Points = std::vector<Eigen::Vector3d>;

/// A method that has been given its cloud, in the form it takes, and what it shall find in it.
struct SamplingMethod {
  std::function<void()> run;       ///< what is timed
  std::function<Points()> result;  ///< of the last run
  /// Cells and milliseconds by stage of the last run, of methods that tell.
  std::function<std::map<std::string, double>()> stages = {};
  std::function<void()> prepare = {};  ///< before every run, and not timed
};

/// Ours. `cloud` must outlive the method.
SamplingMethod ourSampling(const ResampleConfig& config, const Policies& policies,
                           const PoseCloudData& cloud);
/// Ours, of the last of two clouds, which are one: the first has been re-sampled.
SamplingMethod ourExtension(const ResampleConfig& config, const PoseCloudData& first,
                            const PoseCloudData& more);
/// Points at random: the least that can be done.
SamplingMethod randomSampling(const Points& points, std::size_t count);
/// Farthest points of the raw cloud, exactly as PCL and Open3D choose them from their first point,
/// with a k-d tree whose nodes know their greatest distance: how fast that can be.
SamplingMethod treeFarthestPoints(const Points& points, std::size_t count);

SamplingMethod pclFarthestPoints(const Points& points, std::size_t count);
/// These two are given an edge of their cells, which is found so that they give `count` points
/// within a per cent or as near as they come.
SamplingMethod pclVoxelGrid(const Points& points, std::size_t count);
SamplingMethod pclUniformSampling(const Points& points, std::size_t count);

SamplingMethod open3dFarthestPoints(const Points& points, std::size_t count);

/// Calls `points_at` with edges of cells in m until it gives `count` within a per cent; it falls as
/// the edge grows. The last call was the best.
void tuneCellEdge(std::size_t count, const std::function<std::size_t(double)>& points_at);

}  // namespace ladar_perception::bench
