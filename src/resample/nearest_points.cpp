// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/nearest_points.h"

#include <array>
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

/// Squared distances, along one axis, to the voxels one step down, none and one step up.
std::array<float, 3> gaps2(float in_voxel, float edge) {
  const float down = in_voxel * edge;
  const float up = (1.0F - in_voxel) * edge;
  return {down * down, 0.0F, up * up};
}

/// Own voxel first: it is likely to make the others needless.
constexpr std::array<int, 3> kInOrder = {0, -1, 1};

Nearest nearestInLevel(const GridPoints& points, const VoxelLevel& voxels, int level, uint64_t own,
                       const Eigen::Vector3f& place) {
  const auto edge = static_cast<float>(1 << level);
  const Eigen::Vector3f in_voxel =
      (place - cubeCenter(own, level)) / edge + Eigen::Vector3f::Constant(0.5F);
  const std::array<float, 3> gap_x = gaps2(in_voxel.x(), edge);
  const std::array<float, 3> gap_y = gaps2(in_voxel.y(), edge);
  const std::array<float, 3> gap_z = gaps2(in_voxel.z(), edge);
  Nearest nearest;
  for (const int dz : kInOrder) {
    const float to_z = gap_z[static_cast<std::size_t>(1 + dz)];
    if (to_z > nearest.distance2) continue;
    const uint64_t key_z = morton::step(own, morton::kAxisZ, dz);
    for (const int dy : kInOrder) {
      const float to_y = to_z + gap_y[static_cast<std::size_t>(1 + dy)];
      if (to_y > nearest.distance2) continue;
      const uint64_t key_y = morton::step(key_z, morton::kAxisY, dy);
      for (const int dx : kInOrder) {
        if (to_y + gap_x[static_cast<std::size_t>(1 + dx)] > nearest.distance2) continue;
        const uint32_t voxel = voxels.grid.find(morton::step(key_y, morton::kAxisX, dx));
        if (voxel == kNoIndex) continue;
        nearest.look(points, voxels.first_point[voxel], voxels.first_point[voxel + 1], place);
      }
    }
  }
  return nearest;
}

uint32_t nearestPoint(const GridPoints& points, const VoxelPyramid& pyramid,
                      const Eigen::Vector3f& place) {
  const uint64_t cell = cellKey(place);
  for (int level = 0; level < pyramid.levels(); ++level) {
    const Nearest nearest =
        nearestInLevel(points, pyramid.level(level), level, cell >> 3 * level, place);
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
