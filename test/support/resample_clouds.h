// SPDX-License-Identifier: BSD-3-Clause
// Clouds whose surface is known, for the tests of the re-sampling.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "ladar_perception/resample/cloud_resampler.h"
#include "test_random.h"

namespace ladar_perception::test {

/// A flat piece of surface with its corner at the origin of `pose`, along the x and y axes of it.
struct Sheet {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  double length_m = 10.0;  ///< along x
  double width_m = 10.0;   ///< along y
  int points = 100000;
  double noise_m = 0.0;  ///< standard deviation along z

  double area() const { return length_m * width_m; }
  Eigen::Vector3d toSheet(const Eigen::Vector3d& p) const { return pose.inverse() * p; }
  /// Whether the foot of a point is at least `margin_m` inside of the rim.
  bool isInside(const Eigen::Vector3d& on_sheet, double margin_m) const {
    return on_sheet.x() >= margin_m && on_sheet.x() <= length_m - margin_m &&
           on_sheet.y() >= margin_m && on_sheet.y() <= width_m - margin_m;
  }
};

/// Points of a sheet at random places.
inline void addSheet(const Sheet& sheet, TestRandom* random, PoseCloudData* cloud) {
  for (int i = 0; i < sheet.points; ++i) {
    const double x = random->real(0.0, sheet.length_m);
    const double y = random->real(0.0, sheet.width_m);
    cloud->positions_m.push_back(sheet.pose *
                                 Eigen::Vector3d(x, y, sheet.noise_m * random->normal()));
  }
}

/// One sheet, seen from 5 m above its middle.
inline PoseCloudData sheetCloud(const Sheet& sheet, uint64_t seed = 1) {
  PoseCloudData cloud;
  TestRandom random(seed);
  addSheet(sheet, &random, &cloud);
  cloud.sensor_m = sheet.pose * Eigen::Vector3d(0.5 * sheet.length_m, 0.5 * sheet.width_m, 5.0);
  return cloud;
}

/// A sheet whose points stand in rows and columns.
inline PoseCloudData latticeCloud(int columns, int rows, double spacing_m) {
  PoseCloudData cloud;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i)
      cloud.positions_m.emplace_back(i * spacing_m, j * spacing_m, 0);
  }
  cloud.sensor_m = Eigen::Vector3d(0.0, 0.0, 5.0);
  return cloud;
}

inline ResampleConfig countConfig(int count, const std::string& engine = "fast_marching") {
  ResampleConfig config;
  config.engine = engine;
  config.count = count;
  return config;
}

inline ResampledCloud resampled(const ResampleConfig& config, const PoseCloudData& cloud,
                                const Policies& policies = {}) {
  return CloudResampler(config).resample(cloud, policies);
}

/// Slope of the straight line through (x, y).
inline double slopeOf(const std::vector<double>& x, const std::vector<double>& y) {
  double sum_x = 0.0;
  double sum_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum_x += x[i];
    sum_y += y[i];
  }
  const auto n = static_cast<double>(x.size());
  double above = 0.0;
  double below = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    above += (x[i] - sum_x / n) * (y[i] - sum_y / n);
    below += (x[i] - sum_x / n) * (x[i] - sum_x / n);
  }
  return above / below;
}

}  // namespace ladar_perception::test
