// SPDX-License-Identifier: BSD-3-Clause
// The shapes scenes are built from, and where a ray meets them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "ladar_perception/sim/material.h"

namespace ladar_perception::sim {

/// Points `origin + t * direction`, t > 0. The direction need not have unit length: the same t
/// then holds in the world and in a scaled model.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// Returned by the intersection functions where a ray passes by.
constexpr double kMiss = std::numeric_limits<double>::infinity();

enum class Shape : uint8_t { kSphere, kCapsule, kCylinder, kBox, kDisc, kTriangle };

/// One shape of one material. Scenes hold many: single precision, no virtual functions.
struct Primitive {
  Eigen::Vector3f a = Eigen::Vector3f::Zero();  ///< centre, or first end, or first corner
  Eigen::Vector3f b = Eigen::Vector3f::Zero();  ///< half sizes, or second end, normal, corner
  Eigen::Vector3f c = Eigen::Vector3f::Zero();  ///< first box axis, or third corner
  Eigen::Vector3f d = Eigen::Vector3f::Zero();  ///< second box axis
  float radius_m = 0.0F;
  Shape shape = Shape::kSphere;
  Material material = Material::kSoil;
};

Primitive makeSphere(const Eigen::Vector3d& centre, double radius_m, Material material);
/// Cylinder with hemispheres on its ends.
Primitive makeCapsule(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_m,
                      Material material);
/// Cylinder with flat ends.
Primitive makeCylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_m,
                       Material material);
/// Box turned by `yaw_rad` about z after being tilted by `pitch_rad` about its own y.
Primitive makeBox(const Eigen::Vector3d& centre, const Eigen::Vector3d& size_m, double yaw_rad,
                  Material material, double pitch_rad = 0.0);
Primitive makeDisc(const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double radius_m,
                   Material material);
Primitive makeTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                       Material material);

/// Smallest t > 0 at which a ray from outside enters the shape, or kMiss. Solids are not seen from
/// within; discs and triangles are seen from both sides.
double intersect(const Primitive& primitive, const Ray& ray);

/// Unit normal at a point of the shape's surface. The sign of discs and triangles is arbitrary.
Eigen::Vector3d normalAt(const Primitive& primitive, const Eigen::Vector3d& point);

/// Axis-aligned box; the default is empty.
struct Bounds {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
  Eigen::Vector3f high = Eigen::Vector3f::Constant(-std::numeric_limits<float>::infinity());

  void add(const Eigen::Vector3f& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  void add(const Bounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
};

/// Box that contains the shape.
Bounds boundsOf(const Primitive& primitive);

}  // namespace ladar_perception::sim
