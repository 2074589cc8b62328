// SPDX-License-Identifier: BSD-3-Clause
// Forgetting: takes points out of a voxel map again when they have become too old.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {

/// The points of a map by age: their lifetime is cut into kSlices slices, and the points of each
/// slice stand in a map of their own. When a slice is past its time all of it is subtracted, which
/// is exact, so what is left is, bit by bit, a map that never saw the points of that slice (but for
/// points it refused as saturated meanwhile). Points live for 1 - 1 / kSlices to 1 lifetimes.
class EvidenceSlices {
 public:
  static constexpr int kSlices = 8;

  /// Without a map to follow: nothing is ever forgotten.
  EvidenceSlices() = default;
  EvidenceSlices(const MapShape& shape, uint32_t max_points_per_voxel);

  bool enabled() const { return !slices_.empty(); }
  /// `lifetimes` is the present time (or number of scans) over the lifetime. Subtracts from `map`
  /// the slices that are past their time; time never runs backwards for this.
  void advance(double lifetimes, VoxelMap* map);
  /// Where points that are inserted into the map have to be inserted, too.
  VoxelMap& current() { return slices_[newest_ % kSlices]; }
  void scrollTo(const VoxelIndex& min_corner);
  /// Forgets every point, and the time.
  void clear();
  std::size_t memoryBytes() const;

 private:
  std::vector<VoxelMap> slices_;  // by slice number modulo kSlices
  int64_t newest_ = 0;            // slice number: eighths of lifetimes since the start of time
  bool started_ = false;
};

}  // namespace ladar_perception
