// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/surface_point.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

/// `v` scaled to `length`; any direction at right angles to `axis` if `v` has none.
Vector3d withLength(const Vector3d& v, double length, const Vector3d& axis) {
  const double norm = v.norm();
  if (norm > 1e-12) return v * (length / norm);
  const Vector3d other =
      std::abs(axis.x()) < 0.9 * axis.norm() ? Vector3d::UnitX().eval() : Vector3d::UnitY().eval();
  return length * axis.cross(other).normalized();
}

Vector3d nearestOnSphere(const Vector3d& centre, double radius, const Vector3d& p) {
  return centre + withLength(p - centre, radius, Vector3d::UnitZ());
}

Vector3d nearestOnCapsule(const Primitive& capsule, const Vector3d& p) {
  const Vector3d from = capsule.a.cast<double>();
  const Vector3d axis = capsule.b.cast<double>() - from;
  const double along = axis.dot(p - from) / std::max(axis.squaredNorm(), 1e-18);
  const Vector3d foot = from + std::clamp(along, 0.0, 1.0) * axis;
  return foot + withLength(p - foot, capsule.radius_m, axis);
}

Vector3d nearestOnCylinder(const Primitive& cylinder, const Vector3d& p) {
  const Vector3d from = cylinder.a.cast<double>();
  const Vector3d axis = cylinder.b.cast<double>() - from;
  const double length = axis.norm();
  const Vector3d unit = axis / std::max(length, 1e-9);
  const double along = unit.dot(p - from);
  const Vector3d radial = p - from - along * unit;
  const double radius = cylinder.radius_m;
  // The three places: on the mantle, on either end.
  const Vector3d mantle =
      from + std::clamp(along, 0.0, length) * unit + withLength(radial, radius, unit);
  const Vector3d in_disc = radial.norm() > radius ? withLength(radial, radius, unit) : radial;
  Vector3d best = mantle;
  for (const Vector3d& end : {Vector3d(from + in_disc), Vector3d(from + axis + in_disc)}) {
    if ((end - p).squaredNorm() < (best - p).squaredNorm()) best = end;
  }
  return best;
}

Eigen::Matrix3d axesOf(const Primitive& box) {
  Eigen::Matrix3d axes;  // columns
  axes.col(0) = box.c.cast<double>();
  axes.col(1) = box.d.cast<double>();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

Vector3d nearestOnBox(const Primitive& box, const Vector3d& p) {
  const Eigen::Matrix3d axes = axesOf(box);
  const Vector3d half = box.b.cast<double>();
  const Vector3d local = axes.transpose() * (p - box.a.cast<double>());
  Vector3d nearest = local.cwiseMax(-half).cwiseMin(half);
  if (nearest == local) {  // inside: out through the nearest side
    int side = 0;
    (half - local.cwiseAbs()).minCoeff(&side);
    nearest[side] = std::copysign(half[side], local[side]);
  }
  return box.a.cast<double>() + axes * nearest;
}

Vector3d nearestOnDisc(const Primitive& disc, const Vector3d& p) {
  const Vector3d centre = disc.a.cast<double>();
  const Vector3d normal = disc.b.cast<double>();
  const Vector3d radial = p - centre - normal.dot(p - centre) * normal;
  if (radial.norm() <= disc.radius_m) return centre + radial;
  return centre + withLength(radial, disc.radius_m, normal);
}

Vector3d nearestOnSegment(const Vector3d& from, const Vector3d& to, const Vector3d& p) {
  const Vector3d axis = to - from;
  const double along = axis.dot(p - from) / std::max(axis.squaredNorm(), 1e-18);
  return from + std::clamp(along, 0.0, 1.0) * axis;
}

Vector3d nearestOnTriangle(const Primitive& triangle, const Vector3d& p) {
  const Vector3d a = triangle.a.cast<double>();
  const Vector3d b = triangle.b.cast<double>();
  const Vector3d c = triangle.c.cast<double>();
  const Vector3d normal = (b - a).cross(c - a);
  const Vector3d foot = p - normal.dot(p - a) / std::max(normal.squaredNorm(), 1e-18) * normal;
  const auto leftOf = [&](const Vector3d& from, const Vector3d& to) {
    return (to - from).cross(foot - from).dot(normal) >= 0.0;
  };
  if (leftOf(a, b) && leftOf(b, c) && leftOf(c, a)) return foot;
  Vector3d best = nearestOnSegment(a, b, p);
  for (const Vector3d& edge : {nearestOnSegment(b, c, p), nearestOnSegment(c, a, p)}) {
    if ((edge - p).squaredNorm() < (best - p).squaredNorm()) best = edge;
  }
  return best;
}

}  // namespace

Vector3d nearestOnShape(const Primitive& primitive, const Vector3d& p) {
  switch (primitive.shape) {
    case Shape::kSphere:
      return nearestOnSphere(primitive.a.cast<double>(), primitive.radius_m, p);
    case Shape::kCapsule:
      return nearestOnCapsule(primitive, p);
    case Shape::kCylinder:
      return nearestOnCylinder(primitive, p);
    case Shape::kBox:
      return nearestOnBox(primitive, p);
    case Shape::kDisc:
      return nearestOnDisc(primitive, p);
    case Shape::kTriangle:
      return nearestOnTriangle(primitive, p);
  }
  return p;
}

int sideOfBox(const Primitive& box, const Vector3d& point) {
  const Vector3d local = axesOf(box).transpose() * (point - box.a.cast<double>());
  const Vector3d depth = box.b.cast<double>() - local.cwiseAbs();
  int axis = 0;
  depth.minCoeff(&axis);
  return 2 * axis + (local[axis] < 0.0 ? 1 : 0);
}

Rectangle boxSide(const Primitive& box, int side) {
  const Eigen::Matrix3d axes = axesOf(box);
  const Vector3d half = box.b.cast<double>();
  const int axis = side / 2;
  const double sign = side % 2 == 0 ? 1.0 : -1.0;
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  Rectangle rectangle;
  rectangle.edge_u_m = 2.0 * half[u] * axes.col(u);
  rectangle.edge_v_m = 2.0 * half[v] * axes.col(v);
  if (sign < 0.0) std::swap(rectangle.edge_u_m, rectangle.edge_v_m);  // outward on this side, too
  rectangle.corner_m = box.a.cast<double>() + sign * half[axis] * axes.col(axis) -
                       0.5 * (rectangle.edge_u_m + rectangle.edge_v_m);
  return rectangle;
}

}  // namespace ladar_perception::sim
