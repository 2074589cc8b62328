// SPDX-License-Identifier: BSD-3-Clause
// Maps to sum support volumes in, each with an oracle that sums by look-ups.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/saliency/box_sums.h"
#include "map_oracle.h"
#include "test_random.h"

namespace ladar_perception::test {

/// A map with its oracle, and how it is filled.
struct BoxSumScene {
  BoxSumScene(const MapShape& shape, const VoxelIndex& min)
      : map(shape, 1000000), oracle(shape, 1000000) {
    scrollTo(min);
  }
  void scrollTo(const VoxelIndex& min) {
    map.scrollTo(min);
    oracle.scrollTo(min);
  }
  /// A point at a random place of the voxel with these local coordinates.
  void insertLocal(int64_t x, int64_t y, int64_t z) {
    const VoxelIndex& min = map.minCorner();
    const auto place = [&] { return static_cast<int>(random.integer(0, kStepsPerVoxel - 1)); };
    const int sx = place();
    const int sy = place();
    const FixedPoint q = pointIn({static_cast<int32_t>(min.x + x), static_cast<int32_t>(min.y + y),
                                  static_cast<int32_t>(min.z + z)},
                                 sx, sy, place());
    CellId cell = 0;
    map.insert(q, &cell);
    oracle.insert(q);
  }
  void insertSomewhere(int64_t count) {
    const MapShape& s = map.shape();
    for (int64_t i = 0; i < count; ++i) {
      const int64_t x = random.integer(0, s.nx - 1);
      const int64_t y = random.integer(0, s.ny - 1);
      insertLocal(x, y, random.integer(0, s.nz - 1));
    }
  }
  /// Half of the voxels on the faces of the window.
  void insertOnBorders() {
    const MapShape& s = map.shape();
    const auto isLast = [](int i, int n) { return i == 0 || i == n - 1; };
    for (int x = 0; x < s.nx; ++x) {
      for (int y = 0; y < s.ny; ++y) {
        for (int z = 0; z < s.nz; ++z) {
          const bool on_face = isLast(x, s.nx) || isLast(y, s.ny) || isLast(z, s.nz);
          if (on_face && random.integer(0, 1) == 0) insertLocal(x, y, z);
        }
      }
    }
  }
  void fill(const std::string& kind) {
    const MapShape& s = map.shape();
    const int64_t voxels = int64_t{s.nx} * s.ny * s.nz;
    if (kind == "random") insertSomewhere(voxels / 12 + 1);
    if (kind == "dense") insertSomewhere(3 * voxels);
    if (kind == "border") insertOnBorders();
    if (kind == "single") insertLocal(s.nx - 1, 0, s.nz / 2);
    if (kind == "planar") {
      for (int x = 0; x < s.nx; ++x) {
        for (int y = 0; y < s.ny; ++y) insertLocal(x, y, (x + 2 * y) % s.nz / 3);
      }
    }
    if (kind == "linear") {
      for (int z = 0; z < s.nz; ++z) insertLocal(s.nx / 3, s.ny - 1, z);
      for (int x = 0; x < s.nx; ++x) insertLocal(x, x * s.ny / s.nx, s.nz - 1);
    }
  }

  TestRandom random{7};
  VoxelMap map;
  MapOracle oracle;
};

inline const std::vector<std::string>& boxSumSceneKinds() {
  static const std::vector<std::string> kKinds = {"random", "planar", "linear", "dense",
                                                  "border", "single", "empty"};
  return kKinds;
}

/// Wide ones with two words of columns to a row, tall ones with three words to a column, flat ones.
inline const std::vector<MapShape>& boxSumSceneShapes() {
  static const std::vector<MapShape> kShapes = {{12, 10, 9}, {7, 5, 3},   {70, 4, 3}, {6, 5, 64},
                                                {4, 3, 130}, {15, 14, 1}, {1, 1, 1}};
  return kShapes;
}

/// Sum over the box by as many look-ups.
template <typename Sum>
Sum boxSumByLookUp(const MapOracle& oracle, const VoxelIndex& center, const SupportBox& box) {
  Sum sum;
  for (int dy = -box.radius_xy; dy <= box.radius_xy; ++dy) {
    for (int dx = -box.radius_xy; dx <= box.radius_xy; ++dx) {
      for (int dz = -box.radius_z; dz <= box.radius_z; ++dz) {
        const Moments* record = oracle.find({center.x + dx, center.y + dy, center.z + dz});
        if (record != nullptr) sum += *record;
      }
    }
  }
  return sum;
}

/// What a strategy has to find for a voxel, and where it has to put it.
struct ExpectedSum {
  VoxelIndex voxel;
  std::size_t slot;
  Moments sum;
};

/// For every voxel of the map, which must be the oracle's voxels.
inline std::vector<ExpectedSum> expectedSums(const BoxSumScene& scene, const SupportBox& box) {
  std::vector<ExpectedSum> expected;
  scene.map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
    expected.push_back({voxel, slot, boxSumByLookUp<Moments>(scene.oracle, voxel, box)});
  });
  return expected;
}

}  // namespace ladar_perception::test
