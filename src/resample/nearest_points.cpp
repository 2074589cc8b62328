// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/nearest_points.h"

#include <limits>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"

namespace ladar_perception {
namespace {

struct Nearest {
  uint32_t point = kNoIndex;
  float distance2 = std::numeric_limits<float>::infinity();

  void look(const GridPoints& points, uint32_t first, uint32_t end, const Eigen::Vector3f& place) {
    for (uint32_t i = first; i < end; ++i) {
      const float d2 = (points.positions[i] - place).squaredNorm();
      if (d2 < distance2 || (d2 == distance2 && i < point)) {
        distance2 = d2;
        point = i;
      }
    }
  }
};

uint32_t nearestPoint(const GridPoints& points, const VoxelPyramid& pyramid,
                      const Eigen::Vector3f& place) {
  const uint64_t cell = cellKey(place);
  for (int level = 0; level < pyramid.levels(); ++level) {
    const VoxelLevel& voxels = pyramid.level(level);
    Nearest nearest;
    for (int step = 0; step < 27; ++step) {
      uint64_t key = morton::step(cell >> 3 * level, morton::kAxisX, step % 3 - 1);
      key = morton::step(key, morton::kAxisY, step / 3 % 3 - 1);
      key = morton::step(key, morton::kAxisZ, step / 9 - 1);
      const uint32_t voxel = voxels.grid.find(key);
      if (voxel == kNoIndex) continue;
      nearest.look(points, voxels.first_point[voxel], voxels.first_point[voxel + 1], place);
    }
    // Whatever is outside the 27 voxels is farther than one of their edges.
    const auto edge = static_cast<float>(1 << level);
    if (nearest.distance2 <= edge * edge) return nearest.point;
  }
  Nearest nearest;
  nearest.look(points, 0, static_cast<uint32_t>(points.size()), place);
  return nearest.point;
}

}  // namespace

std::vector<uint32_t> nearestPoints(const GridPoints& points, const VoxelPyramid& pyramid,
                                    const std::vector<Eigen::Vector3f>& places, ThreadPool* pool) {
  std::vector<uint32_t> nearest(places.size());
  parallelFor(pool, places.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) nearest[i] = nearestPoint(points, pyramid, places[i]);
  });
  return nearest;
}

}  // namespace ladar_perception
