// SPDX-License-Identifier: BSD-3-Clause
// The occupied voxels visited last along every line of the map (Lalonde et al. 2005, section IV-E).
#pragma once

#include <climits>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/saliency/box_sum_strategy.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// An occupied voxel that was visited before, straight down one axis from another.
struct Predecessor {
  int distance;  ///< more than any map is long if there is none
  int axis;      ///< 0, 1, 2 for x, y, z
  uint32_t slot;
};

/// Three arrays, one entry per line along x, y and z, of the occupied voxels visited last. The
/// paper's pointers are a place on the line and a slot here.
///
/// Predecessors have a smaller index along their axis in every scan by ascending indices, so
/// distances do not depend on which axis the scan runs through first.
class LastVisited {
 public:
  /// Looks along `axis`, or along all three.
  explicit LastVisited(ScanAxis axis) : axis_(axis) {}

  void reset(const MapShape& shape) {
    shape_ = shape;
    along_x_.assign(static_cast<std::size_t>(shape.ny) * shape.nz, Visit());
    along_y_.assign(static_cast<std::size_t>(shape.nx) * shape.nz, Visit());
    along_z_.assign(static_cast<std::size_t>(shape.nx) * shape.ny, Visit());
  }
  std::size_t memoryBytes() const {
    return (along_x_.capacity() + along_y_.capacity() + along_z_.capacity()) * sizeof(Visit);
  }

  /// The nearest voxel visited before (x, y, z), which is then the one visited last on its lines.
  LADAR_INLINE Predecessor visit(int x, int y, int z, uint32_t slot) {
    Predecessor nearest = {INT_MAX, 0, 0};
    // Of equally near ones the axis whose slices are most in the cache: the scan runs along x, so
    // those across y are almost the previous voxel's.
    if (looksAlong(ScanAxis::kY)) {
      step(&along_y_[static_cast<std::size_t>(x) * shape_.nz + z], y, slot, 1, &nearest);
    }
    if (looksAlong(ScanAxis::kX)) {
      step(&along_x_[static_cast<std::size_t>(y) * shape_.nz + z], x, slot, 0, &nearest);
    }
    if (looksAlong(ScanAxis::kZ)) {
      step(&along_z_[static_cast<std::size_t>(y) * shape_.nx + x], z, slot, 2, &nearest);
    }
    return nearest;
  }

 private:
  struct Visit {
    int at = INT_MIN / 2;  // nowhere near
    uint32_t slot = 0;
  };

  LADAR_INLINE bool looksAlong(ScanAxis axis) const {
    return axis_ == axis || axis_ == ScanAxis::kBest;
  }
  LADAR_INLINE static void step(Visit* last, int at, uint32_t slot, int axis,
                                Predecessor* nearest) {
    if (at - last->at < nearest->distance) *nearest = {at - last->at, axis, last->slot};
    *last = {at, slot};
  }

  ScanAxis axis_;
  MapShape shape_;
  std::vector<Visit> along_x_;  // by (y, z)
  std::vector<Visit> along_y_;  // by (x, z)
  std::vector<Visit> along_z_;  // by (y, x)
};

}  // namespace ladar_perception
