// SPDX-License-Identifier: BSD-3-Clause
// Clouds and plain loops that the tests of the re-sampling compare with.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "ladar_perception/resample/cloud_resampler.h"
#include "test_random.h"

namespace ladar_perception::test {

/// Points on the inner sides of a box from the origin to `size_m`, at random.
inline PoseCloudData boxCloud(const Eigen::Vector3d& size_m, int points, double noise_m,
                              uint64_t seed = 1) {
  PoseCloudData cloud;
  cloud.sensor_m = 0.5 * size_m;
  TestRandom random(seed);
  const Eigen::Vector3d areas(size_m.y() * size_m.z(), size_m.x() * size_m.z(),
                              size_m.x() * size_m.y());
  for (int i = 0; i < points; ++i) {
    double side = random.real(0.0, 2.0 * areas.sum());
    int axis = 0;
    while (axis < 2 && side > 2.0 * areas[axis]) side -= 2.0 * areas[axis++];
    Eigen::Vector3d p(random.real(0.0, size_m.x()), random.real(0.0, size_m.y()),
                      random.real(0.0, size_m.z()));
    p[axis] = (side < areas[axis] ? 0.0 : size_m[axis]) + noise_m * random.normal();
    cloud.positions_m.push_back(p);
  }
  return cloud;
}

/// Greatest distance of a point of `places` to the nearest of the first `count` samples.
inline double coveringRadius(const std::vector<Eigen::Vector3d>& places,
                             const std::vector<Eigen::Vector3d>& samples, std::size_t count) {
  double radius2 = 0.0;
  for (const Eigen::Vector3d& place : places) {
    double nearest2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count && nearest2 > radius2; ++i) {
      nearest2 = std::min(nearest2, (samples[i] - place).squaredNorm());
    }
    radius2 = std::max(radius2, nearest2);
  }
  return std::sqrt(radius2);
}

}  // namespace ladar_perception::test
