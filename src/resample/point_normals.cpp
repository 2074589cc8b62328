// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/point_normals.h"

#include <algorithm>
#include <cmath>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"
#include "ladar_perception/resample/surface_fit.h"

namespace ladar_perception {
namespace {

/// Normals of the voxels of one level, zero where there is none, and how they vary.
class LevelNormals {
 public:
  LevelNormals(const VoxelLevel& level, int number, const Eigen::Vector3f& sensor, ThreadPool* pool)
      : level_(level), normals_(level.grid.size(), Eigen::Vector3f::Zero()) {
    std::vector<uint8_t> all(level.grid.size(), 1);
    const std::vector<PointSums> sums = sumNeighborhoods(level, number, false, &all, pool);
    parallelFor(pool, sums.size(), 2048, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        if (sums[i].count < kPlanePoints) continue;
        const PlaneFit plane = fitPlane(sums[i]);
        const Eigen::Vector3f mean = brickCenter(level.grid.keys()[i] >> 6, number) + plane.mean;
        normals_[i] =
            plane.normal.dot(sensor - mean) < 0.0F ? Eigen::Vector3f(-plane.normal) : plane.normal;
      }
    });
  }

  const Eigen::Vector3f& normal(std::size_t voxel) const { return normals_[voxel]; }

  /// Variance about 0 of the angles to the normals of the neighbours, as the paper's.
  float variation(std::size_t voxel) const {
    double sum = 0.0;
    int count = 0;
    const uint64_t key = level_.grid.keys()[voxel];
    for (int step = 0; step < 27; ++step) {
      const uint32_t near = level_.grid.find(morton::around(key, step));
      if (near == kNoIndex || near == voxel || normals_[near].isZero()) continue;
      const float cosine = std::abs(normals_[near].dot(normals_[voxel]));
      const double angle = std::acos(std::min(cosine, 1.0F));
      sum += angle * angle;
      ++count;
    }
    return count > 0 ? static_cast<float>(sum / count) : 0.0F;
  }

 private:
  const VoxelLevel& level_;
  std::vector<Eigen::Vector3f> normals_;
};

}  // namespace

PointNormals pointNormals(const GridPoints& points, const VoxelPyramid& pyramid,
                          const Eigen::Vector3f& sensor, ThreadPool* pool) {
  PointNormals result;
  std::size_t sources = 0;
  for (const uint32_t source : points.sources) sources = std::max<std::size_t>(sources, source + 1);
  result.normals.assign(sources, Eigen::Vector3f::Zero());
  result.variation.assign(sources, 0.0F);
  for (int number = 0; number < pyramid.levels() && number <= kBridgeLevels; ++number) {
    const VoxelLevel& level = pyramid.level(number);
    const LevelNormals normals(level, number, sensor, pool);
    parallelFor(pool, level.grid.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t voxel = begin; voxel < end; ++voxel) {
        if (normals.normal(voxel).isZero()) continue;
        const float variation = normals.variation(voxel);
        for (uint32_t i = level.first_point[voxel]; i < level.first_point[voxel + 1]; ++i) {
          Eigen::Vector3f& normal = result.normals[points.sources[i]];
          if (!normal.isZero()) continue;
          normal = normals.normal(voxel);
          result.variation[points.sources[i]] = variation;
        }
      }
    });
  }
  return result;
}

}  // namespace ladar_perception
