// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "bench_scenes.h"
#include "ladar_perception/sim/random.h"
#include "scan_order.h"

namespace ladar_perception::bench {

/// Draws the points of a scene part by part until there are exactly as many as asked for. What
/// falls outside the window is drawn anew: a map is smaller than the reach of its sensor.
class CloudMaker {
 public:
  /// Window of `shape` voxels of 10 cm with its lowest corner at the origin.
  CloudMaker(const std::string& name, const MapShape& shape, std::size_t points, uint64_t seed)
      : size_m_(0.1 * Eigen::Vector3d(shape.nx, shape.ny, shape.nz)),
        points_(points),
        random_(seed) {
    scene_.name = name;
    scene_.shape = shape;
    scene_.points.reserve(points);
  }

  sim::Random& random() { return random_; }

  /// A part of the scene, on which that share of all points falls. `draw()` gives one of them.
  template <typename Draw>
  void add(double share, Draw&& draw) {
    fill(scene_.points.size() + static_cast<std::size_t>(share * static_cast<double>(points_)),
         draw);
  }

  /// The part that gets the rest; then the scene, in scan order.
  template <typename Draw>
  Scene finish(Draw&& draw) {
    fill(points_, draw);
    sortInScanOrder(size_m_, random_.bits(), &scene_.points);
    return std::move(scene_);
  }

  /// A place in the window's plane, any as likely as another.
  Eigen::Vector2d place() { return placeWithin(0.0, size_m_.y()); }
  Eigen::Vector2d placeWithin(double y_begin_m, double y_end_m) {
    const double x = random_.uniform(0.0, size_m_.x());
    return {x, random_.uniform(y_begin_m, y_end_m)};
  }

  /// A place on the ground a ladar hits that drives along the middle of the window: half as dense
  /// at a distance of `half_m`, falling with the distance squared.
  Eigen::Vector2d groundHit(double half_m) {
    while (true) {
      const Eigen::Vector2d p = place();
      const double distance = (p.y() - 0.5 * size_m_.y()) / half_m;
      if (random_.uniform() * (1.0 + distance * distance) < 1.0) return p;
    }
  }

  /// Uniform in a ball.
  Eigen::Vector3d inBall(const Eigen::Vector3d& center, double radius_m) {
    while (true) {
      const double x = random_.uniform(-1.0, 1.0);
      const double y = random_.uniform(-1.0, 1.0);
      const Eigen::Vector3d p(x, y, random_.uniform(-1.0, 1.0));
      if (p.squaredNorm() < 1.0) return center + radius_m * p;
    }
  }

  /// The point with the range noise of the ladar.
  Eigen::Vector3d noisy(const Eigen::Vector3d& p) {
    constexpr double kSigma_m = 0.01;
    const double x = p.x() + random_.normal(0.0, kSigma_m);
    const double y = p.y() + random_.normal(0.0, kSigma_m);
    return {x, y, p.z() + random_.normal(0.0, kSigma_m)};
  }

  /// On the mantle of an upright cylinder.
  Eigen::Vector3d onMantle(const Eigen::Vector2d& center, double radius_m, double z_begin,
                           double z_end) {
    const double angle = random_.uniform(0.0, 6.283185307179586);
    return {center.x() + radius_m * std::cos(angle), center.y() + radius_m * std::sin(angle),
            random_.uniform(z_begin, z_end)};
  }

 private:
  template <typename Draw>
  void fill(std::size_t count, Draw&& draw) {
    while (scene_.points.size() < count) {
      const Eigen::Vector3d p = draw();
      if ((p.array() >= 0.0).all() && (p.array() < size_m_.array()).all()) {
        scene_.points.push_back(p);
      }
    }
  }

  Eigen::Vector3d size_m_;
  std::size_t points_;
  sim::Random random_;
  Scene scene_;
};

}  // namespace ladar_perception::bench
