// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/primitive.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ladar_perception::sim {
namespace {

using Eigen::Vector3d;

double intersectSphere(const Vector3d& centre, double radius_m, const Ray& ray) {
  const Vector3d offset = ray.origin - centre;
  const double a = ray.direction.squaredNorm();
  const double b = ray.direction.dot(offset);
  const double c = offset.squaredNorm() - radius_m * radius_m;
  const double discriminant = b * b - a * c;
  if (c <= 0.0 || b >= 0.0 || discriminant < 0.0) return kMiss;
  return (-b - std::sqrt(discriminant)) / a;
}

/// Where the ray enters the infinite cylinder about from..to, and the axis coordinate there
/// (0 at `from`, `length_squared` at `to`).
struct TubeEntry {
  double t = kMiss;
  double along = 0.0;
  double along_origin = 0.0;
  double along_rate = 0.0;
  double length_squared = 0.0;
};

TubeEntry intersectTube(const Vector3d& from, const Vector3d& axis, double radius_m,
                        const Ray& ray) {
  const Vector3d offset = ray.origin - from;
  TubeEntry entry;
  entry.length_squared = axis.squaredNorm();
  entry.along_rate = axis.dot(ray.direction);
  entry.along_origin = axis.dot(offset);
  const double ll = entry.length_squared;
  const double a = ll * ray.direction.squaredNorm() - entry.along_rate * entry.along_rate;
  const double b = ll * ray.direction.dot(offset) - entry.along_origin * entry.along_rate;
  const double c =
      ll * (offset.squaredNorm() - radius_m * radius_m) - entry.along_origin * entry.along_origin;
  const double discriminant = b * b - a * c;
  // Parallel to the axis the ray can only meet the ends.
  if (a <= 1e-14 * ll || discriminant < 0.0) return entry;
  entry.t = (-b - std::sqrt(discriminant)) / a;
  entry.along = entry.along_origin + entry.t * entry.along_rate;
  return entry;
}

double intersectCapsule(const Primitive& capsule, const Ray& ray) {
  const Vector3d from = capsule.a.cast<double>();
  const Vector3d to = capsule.b.cast<double>();
  const TubeEntry tube = intersectTube(from, to - from, capsule.radius_m, ray);
  if (tube.t != kMiss && tube.along >= 0.0 && tube.along <= tube.length_squared) {
    return tube.t > 0.0 ? tube.t : kMiss;
  }
  return std::min(intersectSphere(from, capsule.radius_m, ray),
                  intersectSphere(to, capsule.radius_m, ray));
}

double intersectCylinder(const Primitive& cylinder, const Ray& ray) {
  const Vector3d from = cylinder.a.cast<double>();
  const Vector3d to = cylinder.b.cast<double>();
  const TubeEntry tube = intersectTube(from, to - from, cylinder.radius_m, ray);
  if (tube.t != kMiss && tube.t > 0.0 && tube.along >= 0.0 && tube.along <= tube.length_squared) {
    return tube.t;
  }
  if (tube.along_rate == 0.0) return kMiss;
  const Vector3d& end = tube.along_rate > 0.0 ? from : to;
  const double target = tube.along_rate > 0.0 ? 0.0 : tube.length_squared;
  const double t = (target - tube.along_origin) / tube.along_rate;
  if (t <= 0.0) return kMiss;
  const double radius = cylinder.radius_m;
  const Vector3d p = ray.origin + t * ray.direction;
  return (p - end).squaredNorm() <= radius * radius ? t : kMiss;
}

Eigen::Matrix3d boxAxes(const Primitive& box) {
  Eigen::Matrix3d axes;  // rows: the box's axes in the model
  axes.row(0) = box.c.cast<double>();
  axes.row(1) = box.d.cast<double>();
  axes.row(2) = axes.row(0).cross(axes.row(1));
  return axes;
}

double intersectBox(const Primitive& box, const Ray& ray) {
  const Eigen::Matrix3d axes = boxAxes(box);
  const Vector3d origin = axes * (ray.origin - box.a.cast<double>());
  const Vector3d direction = axes * ray.direction;
  double t_in = 0.0;
  double t_out = kMiss;
  for (int i = 0; i < 3; ++i) {
    const double half = box.b[i];
    if (direction[i] == 0.0) {
      if (std::abs(origin[i]) > half) return kMiss;
      continue;
    }
    const double t1 = (-half - origin[i]) / direction[i];
    const double t2 = (half - origin[i]) / direction[i];
    t_in = std::max(t_in, std::min(t1, t2));
    t_out = std::min(t_out, std::max(t1, t2));
  }
  return t_in > 0.0 && t_in <= t_out ? t_in : kMiss;
}

double intersectDisc(const Primitive& disc, const Ray& ray) {
  const Vector3d centre = disc.a.cast<double>();
  const Vector3d normal = disc.b.cast<double>();
  const double rate = normal.dot(ray.direction);
  if (rate == 0.0) return kMiss;
  const double t = normal.dot(centre - ray.origin) / rate;
  if (t <= 0.0) return kMiss;
  const double radius = disc.radius_m;
  const Vector3d p = ray.origin + t * ray.direction;
  return (p - centre).squaredNorm() <= radius * radius ? t : kMiss;
}

/// Moeller and Trumbore (1997).
double intersectTriangle(const Primitive& triangle, const Ray& ray) {
  const Vector3d corner = triangle.a.cast<double>();
  const Vector3d edge1 = triangle.b.cast<double>() - corner;
  const Vector3d edge2 = triangle.c.cast<double>() - corner;
  const Vector3d p = ray.direction.cross(edge2);
  const double determinant = edge1.dot(p);
  if (determinant == 0.0) return kMiss;
  const Vector3d offset = ray.origin - corner;
  const double u = offset.dot(p) / determinant;
  if (u < 0.0 || u > 1.0) return kMiss;
  const Vector3d q = offset.cross(edge1);
  const double v = ray.direction.dot(q) / determinant;
  if (v < 0.0 || u + v > 1.0) return kMiss;
  const double t = edge2.dot(q) / determinant;
  return t > 0.0 ? t : kMiss;
}

Vector3d tubeNormal(const Primitive& tube, const Vector3d& point) {
  const Vector3d from = tube.a.cast<double>();
  const Vector3d axis = tube.b.cast<double>() - from;
  const double along = axis.dot(point - from) / std::max(axis.squaredNorm(), 1e-18);
  const Vector3d radial = point - from - std::clamp(along, 0.0, 1.0) * axis;
  const bool on_flat_end =
      tube.shape == Shape::kCylinder && radial.norm() < 0.9999 * double{tube.radius_m};
  if (on_flat_end) return axis.normalized() * (along < 0.5 ? -1.0 : 1.0);
  return radial.normalized();
}

Vector3d boxNormal(const Primitive& box, const Vector3d& point) {
  const Eigen::Matrix3d axes = boxAxes(box);
  const Vector3d local = axes * (point - box.a.cast<double>());
  const Vector3d depth = box.b.cast<double>() - local.cwiseAbs();
  int face = 0;
  depth.minCoeff(&face);
  return axes.row(face).transpose() * (local[face] < 0.0 ? -1.0 : 1.0);
}

Primitive makeTube(Shape shape, const Vector3d& from, const Vector3d& to, double radius_m,
                   Material material) {
  Primitive primitive;
  primitive.a = from.cast<float>();
  primitive.b = to.cast<float>();
  primitive.radius_m = static_cast<float>(radius_m);
  primitive.shape = shape;
  primitive.material = material;
  return primitive;
}

}  // namespace

Primitive makeSphere(const Vector3d& centre, double radius_m, Material material) {
  return makeTube(Shape::kSphere, centre, centre, radius_m, material);
}

Primitive makeCapsule(const Vector3d& from, const Vector3d& to, double radius_m,
                      Material material) {
  return makeTube(Shape::kCapsule, from, to, radius_m, material);
}

Primitive makeCylinder(const Vector3d& from, const Vector3d& to, double radius_m,
                       Material material) {
  return makeTube(Shape::kCylinder, from, to, radius_m, material);
}

Primitive makeBox(const Vector3d& centre, const Vector3d& size_m, double yaw_rad, Material material,
                  double pitch_rad) {
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(pitch_rad, Vector3d::UnitY()))
                                       .toRotationMatrix();
  Primitive box = makeTube(Shape::kBox, centre, 0.5 * size_m, 0.0, material);
  box.c = rotation.col(0).cast<float>();
  box.d = rotation.col(1).cast<float>();
  return box;
}

Primitive makeDisc(const Vector3d& centre, const Vector3d& normal, double radius_m,
                   Material material) {
  return makeTube(Shape::kDisc, centre, normal.normalized(), radius_m, material);
}

Primitive makeTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, Material material) {
  Primitive triangle = makeTube(Shape::kTriangle, a, b, 0.0, material);
  triangle.c = c.cast<float>();
  return triangle;
}

double intersect(const Primitive& primitive, const Ray& ray) {
  switch (primitive.shape) {
    case Shape::kSphere:
      return intersectSphere(primitive.a.cast<double>(), primitive.radius_m, ray);
    case Shape::kCapsule:
      return intersectCapsule(primitive, ray);
    case Shape::kCylinder:
      return intersectCylinder(primitive, ray);
    case Shape::kBox:
      return intersectBox(primitive, ray);
    case Shape::kDisc:
      return intersectDisc(primitive, ray);
    case Shape::kTriangle:
      return intersectTriangle(primitive, ray);
  }
  return kMiss;
}

Vector3d normalAt(const Primitive& primitive, const Vector3d& point) {
  switch (primitive.shape) {
    case Shape::kSphere:
      return (point - primitive.a.cast<double>()).normalized();
    case Shape::kCapsule:
    case Shape::kCylinder:
      return tubeNormal(primitive, point);
    case Shape::kBox:
      return boxNormal(primitive, point);
    case Shape::kDisc:
      return primitive.b.cast<double>();
    case Shape::kTriangle:
      return (primitive.b - primitive.a)
          .cross(primitive.c - primitive.a)
          .cast<double>()
          .normalized();
  }
  return Vector3d::UnitZ();
}

Bounds boundsOf(const Primitive& primitive) {
  Bounds bounds;
  bounds.add(primitive.a);
  if (primitive.shape == Shape::kTriangle) {
    bounds.add(primitive.b);
    bounds.add(primitive.c);
    return bounds;
  }
  Eigen::Vector3f reach = Eigen::Vector3f::Constant(primitive.radius_m);
  if (primitive.shape == Shape::kCapsule || primitive.shape == Shape::kCylinder) {
    bounds.add(primitive.b);
  } else if (primitive.shape == Shape::kBox) {
    reach = boxAxes(primitive).cast<float>().cwiseAbs().transpose() * primitive.b;
  } else if (primitive.shape == Shape::kDisc) {
    const Eigen::Array3f n = primitive.b.array();
    reach = primitive.radius_m * (1.0F - n * n).max(0.0F).sqrt();
  }
  bounds.low -= reach;
  bounds.high += reach;
  return bounds;
}

}  // namespace ladar_perception::sim
