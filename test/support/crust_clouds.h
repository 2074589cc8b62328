// SPDX-License-Identifier: BSD-3-Clause
// Clouds for the tests of the re-sampling: pieces of plane, corners, scan rings, foliage, wires.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ladar_perception/resample/grid_points.h"
#include "ladar_perception/resample/surface_fit.h"
#include "ladar_perception/resample/voxel_pyramid.h"
#include "test_random.h"

namespace ladar_perception::test {

using Cloud = std::vector<Eigen::Vector3d>;

/// A plane with two unit vectors along it.
struct PlaneFrame {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d v = Eigen::Vector3d::UnitY();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();

  PlaneFrame() = default;
  PlaneFrame(const Eigen::Vector3d& middle, const Eigen::Vector3d& across)
      : center(middle), u(across.unitOrthogonal()), normal(across.normalized()) {
    v = normal.cross(u);
  }
  double height(const Eigen::Vector3d& p) const { return normal.dot(p - center); }
};

/// Points spread evenly by chance over a rectangle around the plane's middle; `noise` is the
/// standard deviation along the normal.
inline Cloud patch(const PlaneFrame& plane, double size_u, double size_v, std::size_t count,
                   double noise, TestRandom* random) {
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const double s = random->real(-0.5 * size_u, 0.5 * size_u);
    const double t = random->real(-0.5 * size_v, 0.5 * size_v);
    cloud.emplace_back(plane.center + s * plane.u + t * plane.v +
                       noise * random->normal() * plane.normal);
  }
  return cloud;
}

inline Cloud segment(const Eigen::Vector3d& from, const Eigen::Vector3d& to, std::size_t count,
                     double noise, TestRandom* random) {
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    cloud.emplace_back(from + t * (to - from) + noise * random->normal3());
  }
  return cloud;
}

/// Points in a ball, of the same density everywhere.
inline Cloud ball(const Eigen::Vector3d& center, double radius, std::size_t count,
                  TestRandom* random) {
  Cloud cloud;
  while (cloud.size() < count) {
    const double x = random->real(-1.0, 1.0);
    const double y = random->real(-1.0, 1.0);
    const Eigen::Vector3d p(x, y, random->real(-1.0, 1.0));
    if (p.squaredNorm() <= 1.0) cloud.emplace_back(center + radius * p);
  }
  return cloud;
}

inline Cloud sphere(const Eigen::Vector3d& center, double radius, std::size_t count, double noise,
                    TestRandom* random) {
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d direction = random->normal3().normalized();
    cloud.emplace_back(center + (radius + noise * random->normal()) * direction);
  }
  return cloud;
}

/// Circles around the z axis on the plane z = 0, as a spinning ladar's beams draw them.
inline Cloud rings(const std::vector<double>& radii, std::size_t points_a_ring, double noise,
                   TestRandom* random) {
  Cloud cloud;
  for (const double radius : radii) {
    for (std::size_t i = 0; i < points_a_ring; ++i) {
      const double angle = 2.0 * M_PI * static_cast<double>(i) / static_cast<double>(points_a_ring);
      cloud.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                         noise * random->normal());
    }
  }
  return cloud;
}

inline Cloud joined(Cloud a, const Cloud& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline GridFrame gridFrame(double cell_m, const Eigen::Vector3d& origin_m = {0, 0, 0}) {
  GridFrame frame;
  frame.cell_m = cell_m;
  frame.origin_m = origin_m;
  return frame;
}

/// What the crust is made from.
struct GriddedCloud {
  GridPoints points;
  VoxelPyramid pyramid;

  explicit GriddedCloud(const Cloud& cloud, const GridFrame& frame = gridFrame(1.0),
                        const std::vector<float>& weights = {}, int levels = kBridgeLevels + 1)
      : points(sortIntoGrid(cloud, frame)), pyramid(points, weights, levels) {}
};

/// The direction that a normal of a plane with these slants has: tilted from z by `tilt_deg`, to
/// the side of `azimuth_deg`.
inline Eigen::Vector3d tilted(double tilt_deg, double azimuth_deg) {
  const double tilt = tilt_deg * M_PI / 180.0;
  const double azimuth = azimuth_deg * M_PI / 180.0;
  return {std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt)};
}

}  // namespace ladar_perception::test
