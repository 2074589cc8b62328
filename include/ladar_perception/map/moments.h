// SPDX-License-Identifier: BSD-3-Clause
// Count and first and second moments of points, as exact integers in one cache line.
#pragma once

#include <cstdint>

#include "ladar_perception/map/fixed_point.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// Moments about a reference position, in quantisation steps. Exact.
struct CenteredMoments {
  int64_t n = 0;
  int64_t x = 0, y = 0, z = 0;
  int64_t xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

/// Sums of the scatter matrix over a set of points, in world coordinates modulo 2^64.
///
/// Adding and subtracting are exact in any order and at any distance from the origin, because
/// modular arithmetic forgets the overflow that re-centring takes out again. What must hold is only
/// that the re-centred sums fit: |sum of (x - centre)| < 2^31 (see `maxPointsPerVoxel`).
class alignas(64) Moments {
 public:
  LADAR_INLINE void add(const FixedPoint& q) {
    const auto x = static_cast<uint64_t>(q.x);
    const auto y = static_cast<uint64_t>(q.y);
    const auto z = static_cast<uint64_t>(q.z);
    word_[0] += 1 + (x << 32);
    word_[1] += y + (z << 32);
    word_[2] += x * x;
    word_[3] += x * y;
    word_[4] += x * z;
    word_[5] += y * y;
    word_[6] += y * z;
    word_[7] += z * z;
  }

  LADAR_INLINE Moments& operator+=(const Moments& other) {
    for (int i = 0; i < 8; ++i) word_[i] += other.word_[i];
    return *this;
  }
  LADAR_INLINE Moments& operator-=(const Moments& other) {
    for (int i = 0; i < 8; ++i) word_[i] -= other.word_[i];
    return *this;
  }
  /// Every point counts `weight` times. Sums of what is weighted must still fit (see the class).
  LADAR_INLINE Moments& operator*=(uint32_t weight) {
    for (uint64_t& word : word_) word *= weight;
    return *this;
  }
  bool operator==(const Moments& other) const {
    for (int i = 0; i < 8; ++i) {
      if (word_[i] != other.word_[i]) return false;
    }
    return true;
  }
  bool operator!=(const Moments& other) const { return !(*this == other); }

  LADAR_INLINE uint32_t count() const { return static_cast<uint32_t>(word_[0]); }

  /// Moments about `center`, which must lie within the points' neighbourhood (see the class).
  LADAR_INLINE CenteredMoments about(const FixedPoint& center) const {
    const auto cx = static_cast<uint64_t>(center.x);
    const auto cy = static_cast<uint64_t>(center.y);
    const auto cz = static_cast<uint64_t>(center.z);
    const uint64_t n = count();
    CenteredMoments m;
    m.n = static_cast<int64_t>(n);
    m.x = static_cast<int32_t>((word_[0] >> 32) - n * cx);
    const uint64_t yz = word_[1] - n * (cy + (cz << 32));
    m.y = static_cast<int32_t>(yz);
    m.z = static_cast<int32_t>((yz - static_cast<uint64_t>(m.y)) >> 32);
    const auto sx = static_cast<uint64_t>(m.x);
    const auto sy = static_cast<uint64_t>(m.y);
    const auto sz = static_cast<uint64_t>(m.z);
    // sum (x-cx)(y-cy) = Sxy - cy sum(x-cx) - cx (sum(y-cy) + n cy)
    const uint64_t full_x = sx + n * cx;
    const uint64_t full_y = sy + n * cy;
    const uint64_t full_z = sz + n * cz;
    m.xx = static_cast<int64_t>(word_[2] - cx * (sx + full_x));
    m.xy = static_cast<int64_t>(word_[3] - cy * sx - cx * full_y);
    m.xz = static_cast<int64_t>(word_[4] - cz * sx - cx * full_z);
    m.yy = static_cast<int64_t>(word_[5] - cy * (sy + full_y));
    m.yz = static_cast<int64_t>(word_[6] - cz * sy - cy * full_z);
    m.zz = static_cast<int64_t>(word_[7] - cz * (sz + full_z));
    return m;
  }

 private:
  template <int kBytes>
  friend class MomentsInRegisters;

  // n + (Sx << 32), Sy + (Sz << 32), Sxx, Sxy, Sxz, Syy, Syz, Szz
  uint64_t word_[8] = {};
};
static_assert(sizeof(Moments) == 64, "one record is one cache line");

/// Moments that are added to many times, within `dispatchWide`: in vectors of kBytes, which the
/// compiler keeps in registers. (Eight words it may take apart into eight numbers, and a vector
/// wider than the level's it keeps in memory.)
template <int kBytes>
class MomentsInRegisters {
 public:
  LADAR_INLINE MomentsInRegisters& operator+=(const Moments& other) {
    for (int i = 0; i < kVectors; ++i) vectors_[i] += of(other)[i];
    return *this;
  }
  LADAR_INLINE MomentsInRegisters& operator-=(const Moments& other) {
    for (int i = 0; i < kVectors; ++i) vectors_[i] -= of(other)[i];
    return *this;
  }
  /// *result = *this + other
  LADAR_INLINE void addTo(const Moments& other, Moments* result) const {
    for (int i = 0; i < kVectors; ++i) {
      reinterpret_cast<Vector*>(result->word_)[i] = vectors_[i] + of(other)[i];
    }
  }

 private:
  using Vector [[gnu::vector_size(kBytes), gnu::may_alias]] = uint64_t;
  static constexpr int kVectors = static_cast<int>(sizeof(Moments)) / kBytes;

  LADAR_INLINE static const Vector* of(const Moments& moments) {
    return reinterpret_cast<const Vector*>(moments.word_);
  }

  Vector vectors_[kVectors] = {};
};

/// Centre of a voxel, the reference its moments are read about.
LADAR_INLINE FixedPoint centerOf(const VoxelIndex& voxel) {
  constexpr int64_t kHalf = kStepsPerVoxel / 2;
  return {voxel.x * kStepsPerVoxel + kHalf, voxel.y * kStepsPerVoxel + kHalf,
          voxel.z * kStepsPerVoxel + kHalf};
}

/// Points a voxel may hold so that sums over k x k x k voxels stay exact, k = 2 r + 1: every
/// re-centred coordinate is at most 128 k steps, and n times that must stay below 2^31.
constexpr uint32_t maxPointsPerVoxel(int support_radius_voxels) {
  const int64_t k = 2 * support_radius_voxels + 1;
  return static_cast<uint32_t>((int64_t{1} << 31) / (kStepsPerVoxel / 2 * k * k * k * k));
}

}  // namespace ladar_perception
