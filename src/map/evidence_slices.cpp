// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/map/evidence_slices.h"

#include <algorithm>
#include <cassert>

namespace ladar_perception {

EvidenceSlices::EvidenceSlices(const MapShape& shape, uint32_t max_points_per_voxel) {
  for (int i = 0; i < kSlices; ++i) slices_.emplace_back(shape, max_points_per_voxel);
}

void EvidenceSlices::advance(double lifetimes, VoxelMap* map) {
  assert(enabled() && lifetimes >= 0.0);
  const int64_t now = floorToInt(lifetimes * kSlices);
  if (!started_) newest_ = now;
  started_ = true;
  // After a long pause every slice is past its time, once.
  newest_ = std::max(newest_, now - kSlices);
  while (newest_ < now) {
    ++newest_;
    map->subtract(current());
    current().clear();
  }
}

void EvidenceSlices::scrollTo(const VoxelIndex& min_corner) {
  for (VoxelMap& slice : slices_) {
    slice.scrollTo(min_corner);
    slice.forgetChanges();
  }
}

void EvidenceSlices::clear() {
  for (VoxelMap& slice : slices_) slice.clear();
  started_ = false;
}

std::size_t EvidenceSlices::memoryBytes() const {
  std::size_t bytes = 0;
  for (const VoxelMap& slice : slices_) bytes += slice.memoryBytes();
  return bytes;
}

}  // namespace ladar_perception
