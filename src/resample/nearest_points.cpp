// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/nearest_points.h"

#include <array>
#include <cstdlib>
#include <limits>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"

namespace ladar_perception {
namespace {

// How many of the widest voxels a point is looked for in the middle of a gap.
constexpr int kWide = 4;

struct Nearest {
  uint32_t point = kNoIndex;
  float distance2 = std::numeric_limits<float>::infinity();

  LADAR_INLINE void look(const GridPoints& points, uint32_t first, uint32_t end,
                         const Eigen::Vector3f& place) {
    for (uint32_t i = first; i < end; ++i) {
      const float d2 = (points.positions[i] - place).squaredNorm();
      if (d2 < distance2 || (d2 == distance2 && i < point)) {
        distance2 = d2;
        point = i;
      }
    }
  }
  /// Whatever is outside the voxels looked at is farther than those beside the own are deep.
  bool isSure(int voxels, int level) const {
    const auto depth = static_cast<float>(voxels << level);
    return distance2 <= depth * depth;
  }
};

/// Voxels along one axis up to kWide steps from the own one, which comes first: it is likely to
/// make the others needless.
struct Steps {
  static constexpr std::size_t kCount = 2 * kWide + 1;
  std::array<float, kCount> gaps2;  ///< squared distances to the voxels

  static constexpr int step(std::size_t n) {
    const auto half = static_cast<int>((n + 1) / 2);
    return n % 2 == 0 ? half : -half;
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

/// Of the widest voxels up to kWide steps from the own one.
Nearest nearestInWideGap(const GridPoints& points, const VoxelLevel& voxels, int level,
                         uint64_t own, const Eigen::Vector3f& place) {
  const auto edge = static_cast<float>(1 << level);
  const Eigen::Vector3f in_voxel =
      (place - cubeCenter(own, level)) / edge + Eigen::Vector3f::Constant(0.5F);
  const Steps along_x(in_voxel.x(), edge);
  const Steps along_y(in_voxel.y(), edge);
  const Steps along_z(in_voxel.z(), edge);
  Nearest nearest;
  for (std::size_t z = 0; z < Steps::kCount; ++z) {
    if (along_z.gaps2[z] > nearest.distance2) continue;
    const uint64_t key_z = morton::jump(own, morton::kAxisZ, Steps::step(z));
    for (std::size_t y = 0; y < Steps::kCount; ++y) {
      const float to_y = along_z.gaps2[z] + along_y.gaps2[y];
      if (to_y > nearest.distance2) continue;
      const uint64_t key_y = morton::jump(key_z, morton::kAxisY, Steps::step(y));
      for (std::size_t x = 0; x < Steps::kCount; ++x) {
        if (to_y + along_x.gaps2[x] > nearest.distance2) continue;
        const uint64_t key = morton::jump(key_y, morton::kAxisX, Steps::step(x));
        const uint32_t voxel = voxels.grid.find(key);
        if (voxel == kNoIndex) continue;
        nearest.look(points, voxels.first_point[voxel], voxels.first_point[voxel + 1], place);
      }
    }
  }
  return nearest;
}

/// Of the own voxel and those around it, from the finest ones up.
LADAR_INLINE Nearest nearestAround(const GridPoints& points, const VoxelPyramid& pyramid,
                                   uint64_t cell, const Eigen::Vector3f& place) {
  Nearest nearest;
  for (int level = 0; level < pyramid.levels(); ++level) {
    const VoxelLevel& voxels = pyramid.level(level);
    const uint64_t key = cell >> 3 * level;
    const uint32_t brick = voxels.grid.findBrick(key >> 6);
    // Voxels beside a brick that is not there are found among the larger ones.
    if (brick == kNoIndex) continue;
    voxels.grid.visitNear<1>(brick, static_cast<int>(key & 63), [&](uint32_t voxel, auto...) {
      nearest.look(points, voxels.first_point[voxel], voxels.first_point[voxel + 1], place);
    });
    if (nearest.isSure(1, level)) return nearest;
  }
  return {};
}

LADAR_INLINE uint32_t nearestPoint(const GridPoints& points, const VoxelPyramid& pyramid,
                                   const Eigen::Vector3f& place) {
  const uint64_t cell = cellKey(place);
  Nearest nearest = nearestAround(points, pyramid, cell, place);
  if (nearest.point != kNoIndex) return nearest.point;
  const int top = pyramid.levels() - 1;
  nearest = nearestInWideGap(points, pyramid.level(top), top, cell >> 3 * top, place);
  if (nearest.isSure(kWide, top)) return nearest.point;
  nearest.look(points, 0, static_cast<uint32_t>(points.size()), place);
  return nearest.point;
}

}  // namespace

std::vector<uint32_t> nearestPoints(const GridPoints& points, const VoxelPyramid& pyramid,
                                    const std::vector<Eigen::Vector3f>& places, ThreadPool* pool) {
  std::vector<uint32_t> nearest(places.size());
  parallelFor(pool, places.size(), 1024, [&](std::size_t begin, std::size_t end) {
    dispatch([&]() LADAR_INLINE_LAMBDA {
      for (std::size_t i = begin; i < end; ++i) {
        nearest[i] = nearestPoint(points, pyramid, places[i]);
      }
    });
  });
  return nearest;
}

}  // namespace ladar_perception
