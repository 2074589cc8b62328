// SPDX-License-Identifier: BSD-3-Clause
// A record that knows more of its points than where they are: how to give BasicVoxelMap one's own.
#pragma once

#include <cstdint>

#include "ladar_perception/map/fixed_point.h"
#include "ladar_perception/map/moments.h"
#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {

/// What one point looked like, in whole numbers: sums of them are exact in any order, and so are
/// scrolling, forgetting and box sums.
struct Appearance {
  uint16_t intensity = 0;
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  uint8_t returns = 1;  ///< of its pulse
};

/// Sums over points: intensity and its square, colour, returns. Means are sums over the number of
/// points, which the moments count.
struct AppearanceSums {
  LADAR_INLINE void add(const Appearance& appearance) {
    const uint64_t i = appearance.intensity;
    intensity += i;
    intensity_squared += i * i;
    red += appearance.red;
    green += appearance.green;
    blue += appearance.blue;
    returns += appearance.returns;
  }
  LADAR_INLINE AppearanceSums& operator+=(const AppearanceSums& other) {
    intensity += other.intensity;
    intensity_squared += other.intensity_squared;
    red += other.red;
    green += other.green;
    blue += other.blue;
    returns += other.returns;
    return *this;
  }
  LADAR_INLINE AppearanceSums& operator-=(const AppearanceSums& other) {
    intensity -= other.intensity;
    intensity_squared -= other.intensity_squared;
    red -= other.red;
    green -= other.green;
    blue -= other.blue;
    returns -= other.returns;
    return *this;
  }
  LADAR_INLINE AppearanceSums& operator*=(uint32_t weight) {
    intensity *= weight;
    intensity_squared *= weight;
    red *= weight;
    green *= weight;
    blue *= weight;
    returns *= weight;
    return *this;
  }
  bool operator==(const AppearanceSums& other) const {
    return intensity == other.intensity && intensity_squared == other.intensity_squared &&
           red == other.red && green == other.green && blue == other.blue &&
           returns == other.returns;
  }

  uint64_t intensity = 0;
  uint64_t intensity_squared = 0;
  uint64_t red = 0;
  uint64_t green = 0;
  uint64_t blue = 0;
  uint64_t returns = 0;
};

/// Moments in the first cache line, appearance in the second. With
///   BasicVoxelMap<AppearanceRecord> map(shape, maxPointsPerVoxel(radius));
///   map.insert(q, &cell, appearance);
///   SlidingBoxSums<AppearanceRecord> box_sums(cube(radius));
/// every support volume has its mean intensity and colour beside its shape.
class AppearanceRecord {
 public:
  LADAR_INLINE void add(const FixedPoint& q, const Appearance& appearance) {
    moments_.add(q);
    sums_.add(appearance);
  }
  LADAR_INLINE AppearanceRecord& operator+=(const AppearanceRecord& other) {
    moments_ += other.moments_;
    sums_ += other.sums_;
    return *this;
  }
  LADAR_INLINE AppearanceRecord& operator-=(const AppearanceRecord& other) {
    moments_ -= other.moments_;
    sums_ -= other.sums_;
    return *this;
  }
  LADAR_INLINE AppearanceRecord& operator*=(uint32_t weight) {
    moments_ *= weight;
    sums_ *= weight;
    return *this;
  }
  bool operator==(const AppearanceRecord& other) const {
    return moments_ == other.moments_ && sums_ == other.sums_;
  }

  LADAR_INLINE uint32_t count() const { return moments_.count(); }
  LADAR_INLINE const Moments& moments() const { return moments_; }
  LADAR_INLINE const AppearanceSums& sums() const { return sums_; }
  /// 0 without points.
  double meanIntensity() const {
    return count() == 0 ? 0.0 : static_cast<double>(sums_.intensity) / count();
  }

 private:
  Moments moments_;
  AppearanceSums sums_;
};
static_assert(sizeof(AppearanceRecord) == 2 * sizeof(Moments), "two cache lines");

}  // namespace ladar_perception
