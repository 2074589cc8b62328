// SPDX-License-Identifier: BSD-3-Clause
// Posterior probabilities of a map's voxels as whole numbers, so that sums over boxes are exact
// and slide like those of moments.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// What a probability of 1 is. Sums over 25^3 voxels stay below 2^31.
constexpr uint32_t kPosteriorUnit = 65535;

/// Probabilities of up to kClasses classes, all 0 for a voxel of which nothing is known.
template <int kClasses>
struct PosteriorRecord {
  uint16_t part[kClasses] = {};
};

template <int kClasses>
struct PosteriorSum {
  uint32_t part[kClasses] = {};

  LADAR_INLINE PosteriorSum& operator+=(const PosteriorRecord<kClasses>& record) {
    for (int c = 0; c < kClasses; ++c) part[c] += record.part[c];
    return *this;
  }
  LADAR_INLINE PosteriorSum& operator-=(const PosteriorRecord<kClasses>& record) {
    for (int c = 0; c < kClasses; ++c) part[c] -= record.part[c];
    return *this;
  }
  LADAR_INLINE PosteriorSum& operator+=(const PosteriorSum& other) {
    for (int c = 0; c < kClasses; ++c) part[c] += other.part[c];
    return *this;
  }
  LADAR_INLINE PosteriorSum& operator-=(const PosteriorSum& other) {
    for (int c = 0; c < kClasses; ++c) part[c] -= other.part[c];
    return *this;
  }
  /// Of all classes together.
  LADAR_INLINE uint32_t count() const {
    uint32_t total = 0;
    for (int c = 0; c < kClasses; ++c) total += part[c];
    return total;
  }
};

/// A map's voxels with posteriors for records, as SlidingBoxSums wants a map.
template <int kClasses>
class PosteriorField {
 public:
  using Record = PosteriorRecord<kClasses>;

  /// `records` by slot of the map; both must outlive the field.
  PosteriorField(const VoxelMap& map, const Record* records) : map_(map), records_(records) {}

  const MapShape& shape() const { return map_.shape(); }
  LADAR_INLINE int columnAt(int x_local, int y_local) const {
    return map_.columnAt(x_local, y_local);
  }
  int maskWords() const { return map_.maskWords(); }
  LADAR_INLINE const uint64_t* mask(int column) const { return map_.mask(column); }
  int recordCount(int column) const { return map_.recordCount(column); }
  std::size_t firstSlot(int column) const { return map_.firstSlot(column); }
  const Record* records(int column) const { return records_ + map_.firstSlot(column); }
  const Record& record(std::size_t slot) const { return records_[slot]; }

 private:
  const VoxelMap& map_;
  const Record* records_;
};

}  // namespace ladar_perception
