// SPDX-License-Identifier: BSD-3-Clause
// Samplings of PCL, for comparison. PCL's headers stay in this file.
#include <pcl/filters/farthest_point_sampling.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>

#include <cmath>

#include "basin_sampling.h"

namespace ladar_perception {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

PclCloud::Ptr toPcl(const std::vector<Eigen::Vector3d>& points_m, const Eigen::Vector3d& origin_m) {
  auto cloud = std::make_shared<PclCloud>();
  for (const Eigen::Vector3d& p : points_m) {
    const Eigen::Vector3f local = (p - origin_m).cast<float>();
    cloud->emplace_back(local.x(), local.y(), local.z());
  }
  return cloud;
}

std::vector<Eigen::Vector3d> fromPcl(const PclCloud& cloud, const Eigen::Vector3d& origin_m) {
  std::vector<Eigen::Vector3d> points_m;
  for (const pcl::PointXYZ& p : cloud) {
    points_m.push_back(origin_m + Eigen::Vector3f(p.x, p.y, p.z).cast<double>());
  }
  return points_m;
}

/// Leaf sizes below this overflow VoxelGrid's index, whereupon it returns its input.
double leastLeaf(const PclCloud& cloud) {
  Eigen::Array3f low = Eigen::Array3f::Constant(1e9F);
  Eigen::Array3f high = -low;
  for (const pcl::PointXYZ& p : cloud) {
    low = low.min(p.getArray3fMap());
    high = high.max(p.getArray3fMap());
  }
  const Eigen::Array3d extent = (high - low).cast<double>() + 1.0;
  return 1.1 * std::cbrt(extent.prod() / 2147483647.0);
}

PclCloud filtered(const PclCloud::Ptr& cloud, double leaf_m) {
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(cloud);
  const auto leaf = static_cast<float>(leaf_m);
  grid.setLeafSize(leaf, leaf, leaf);
  PclCloud out;
  grid.filter(out);
  return out;
}

}  // namespace

std::vector<Eigen::Vector3d> pclVoxelGrid(const std::vector<Eigen::Vector3d>& points_m,
                                          std::size_t count) {
  if (points_m.size() <= count) return points_m;
  const Eigen::Vector3d origin_m = points_m.front();
  const PclCloud::Ptr cloud = toPcl(points_m, origin_m);
  double low_m = leastLeaf(*cloud);
  double high_m = 50.0;
  PclCloud best = filtered(cloud, high_m);
  constexpr int kHalvings = 24;
  for (int i = 0; i < kHalvings && best.size() < count; ++i) {
    const double leaf_m = std::sqrt(low_m * high_m);
    PclCloud out = filtered(cloud, leaf_m);
    if (out.size() > count) {
      low_m = leaf_m;
    } else {
      high_m = leaf_m;
      best = std::move(out);
    }
  }
  return fromPcl(best, origin_m);
}

std::vector<Eigen::Vector3d> pclFarthestPoints(const std::vector<Eigen::Vector3d>& points_m,
                                               std::size_t count) {
  if (points_m.size() <= count) return points_m;
  const Eigen::Vector3d origin_m = points_m.front();
  pcl::FarthestPointSampling<pcl::PointXYZ> sampling;
  sampling.setInputCloud(toPcl(points_m, origin_m));
  sampling.setSample(count);
  sampling.setSeed(1);
  PclCloud out;
  sampling.filter(out);
  return fromPcl(out, origin_m);
}

}  // namespace ladar_perception
