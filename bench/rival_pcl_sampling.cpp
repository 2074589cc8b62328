// SPDX-License-Identifier: BSD-3-Clause
// Samplings of PCL. Like rival_pcl.cpp this sees PCL's headers, and has no flags of an
// architecture.
#include <pcl/filters/farthest_point_sampling.h>
#include <pcl/filters/uniform_sampling.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <memory>

#include "sampling_methods.h"

namespace ladar_perception::bench {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// A filter, its input and its output.
template <typename Filter>
struct PclSampling {
  explicit PclSampling(const Points& points) {
    input->reserve(points.size());
    for (const Eigen::Vector3d& p : points) {
      const Eigen::Vector3f q = p.cast<float>();
      input->push_back(pcl::PointXYZ(q.x(), q.y(), q.z()));
    }
    filter.setInputCloud(input);
  }
  Points result() const {
    Points points;
    for (const pcl::PointXYZ& p : output) points.push_back(p.getVector3fMap().cast<double>());
    return points;
  }

  Cloud::Ptr input{new Cloud};
  Cloud output;
  Filter filter;
};

template <typename Filter>
SamplingMethod methodOf(const std::shared_ptr<PclSampling<Filter>>& sampling) {
  return {[sampling] { sampling->filter.filter(sampling->output); },
          [sampling] { return sampling->result(); }};
}

}  // namespace

SamplingMethod pclFarthestPoints(const Points& points, std::size_t count) {
  auto sampling = std::make_shared<PclSampling<pcl::FarthestPointSampling<pcl::PointXYZ>>>(points);
  sampling->filter.setSample(count);
  sampling->filter.setSeed(1);
  return methodOf(sampling);
}

SamplingMethod pclVoxelGrid(const Points& points, std::size_t count) {
  auto sampling = std::make_shared<PclSampling<pcl::VoxelGrid<pcl::PointXYZ>>>(points);
  // Where its index would overflow it gives the cloud as it is, which is too many, as it should be.
  tuneCellEdge(count, [&](double edge_m) {
    const auto leaf = static_cast<float>(edge_m);
    sampling->filter.setLeafSize(leaf, leaf, leaf);
    sampling->filter.filter(sampling->output);
    return sampling->output.size();
  });
  return methodOf(sampling);
}

SamplingMethod pclUniformSampling(const Points& points, std::size_t count) {
  auto sampling = std::make_shared<PclSampling<pcl::UniformSampling<pcl::PointXYZ>>>(points);
  tuneCellEdge(count, [&](double edge_m) {
    sampling->filter.setRadiusSearch(edge_m);
    sampling->filter.filter(sampling->output);
    return sampling->output.size();
  });
  return methodOf(sampling);
}

}  // namespace ladar_perception::bench
