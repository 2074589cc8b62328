// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/nearest_points.h"

#include <array>
#include <cstdlib>
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

/// Voxels along one axis up to `kReach` steps from the own one, which comes first: it is likely to
/// make the others needless.
template <int kReach>
struct Steps {
  static constexpr std::size_t kCount = 2 * kReach + 1;
  std::array<float, kCount> gaps2;  ///< squared distances to the voxels

  static constexpr int step(std::size_t n) {
    const auto half = static_cast<int>((n + 1) / 2);
    return n % 2 == 0 ? half : -half;
  }
  static uint64_t key(uint64_t from, uint64_t axis, std::size_t n) {
    if constexpr (kReach == 1) return morton::step(from, axis, step(n));
    return morton::jump(from, axis, step(n));
  }
  /// `in_voxel`: place in the own voxel, in its edges.
  Steps(float in_voxel, float edge) {
    for (std::size_t n = 0; n < kCount; ++n) {
      const auto steps = static_cast<float>(std::abs(step(n)));
      const float gap = n == 0 ? 0.0F : steps - (step(n) > 0 ? in_voxel : 1.0F - in_voxel);
      gaps2[n] = gap * edge * gap * edge;
    }
  }
};

template <int kReach>
Nearest nearestInLevel(const GridPoints& points, const VoxelLevel& voxels, int level, uint64_t own,
                       const Eigen::Vector3f& place) {
  using Axis = Steps<kReach>;
  const auto edge = static_cast<float>(1 << level);
  const Eigen::Vector3f in_voxel =
      (place - cubeCenter(own, level)) / edge + Eigen::Vector3f::Constant(0.5F);
  const Axis along_x(in_voxel.x(), edge);
  const Axis along_y(in_voxel.y(), edge);
  const Axis along_z(in_voxel.z(), edge);
  Nearest nearest;
  for (std::size_t z = 0; z < Axis::kCount; ++z) {
    if (along_z.gaps2[z] > nearest.distance2) continue;
    const uint64_t key_z = Axis::key(own, morton::kAxisZ, z);
    for (std::size_t y = 0; y < Axis::kCount; ++y) {
      const float to_y = along_z.gaps2[z] + along_y.gaps2[y];
      if (to_y > nearest.distance2) continue;
      const uint64_t key_y = Axis::key(key_z, morton::kAxisY, y);
      for (std::size_t x = 0; x < Axis::kCount; ++x) {
        if (to_y + along_x.gaps2[x] > nearest.distance2) continue;
        const uint64_t key = Axis::key(key_y, morton::kAxisX, x);
        const uint32_t voxel = voxels.grid.find(key);
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
  Nearest nearest;
  // Whatever is outside the voxels looked at is farther than those beside the own are deep.
  const auto isSure = [&](int voxels, int level) {
    const auto depth = static_cast<float>(voxels << level);
    return nearest.distance2 <= depth * depth;
  };
  for (int level = 0; level < pyramid.levels(); ++level) {
    nearest = nearestInLevel<1>(points, pyramid.level(level), level, cell >> 3 * level, place);
    if (isSure(1, level)) return nearest.point;
  }
  // In the middle of a wide gap.
  const int top = pyramid.levels() - 1;
  nearest = nearestInLevel<4>(points, pyramid.level(top), top, cell >> 3 * top, place);
  if (isSure(4, top)) return nearest.point;
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
