// SPDX-License-Identifier: BSD-3-Clause
// Clouds of simple places, whose surfaces and normals are known.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "ladar_perception/register/oriented_points.h"
#include "test_random.h"

namespace ladar_perception::test {

/// A rectangle: a corner, two edges, and the side it is seen from.
struct Face {
  Eigen::Vector3d corner_m;
  Eigen::Vector3d u_m;
  Eigen::Vector3d v_m;
  Eigen::Vector3d normal;
};

/// The six faces of a box, seen from inside (of a room) or outside (of furniture).
inline std::vector<Face> boxFaces(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                                  bool inside) {
  std::vector<Face> faces;
  const Eigen::Vector3d size = high - low;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    u[(axis + 1) % 3] = size[(axis + 1) % 3];
    v[(axis + 2) % 3] = size[(axis + 2) % 3];
    for (const bool upper : {false, true}) {
      Face face{low, u, v, Eigen::Vector3d::Zero()};
      if (upper) face.corner_m[axis] = high[axis];
      face.normal[axis] = upper == inside ? -1.0 : 1.0;
      faces.push_back(face);
    }
  }
  return faces;
}

/// A room of 8 x 6 x 3 m with two pieces of furniture that fix every direction.
inline std::vector<Face> roomFaces() {
  std::vector<Face> faces = boxFaces({-3.0, -2.0, 0.0}, {5.0, 4.0, 3.0}, true);
  for (const Face& face : boxFaces({2.0, 1.0, 0.0}, {4.0, 2.0, 1.0}, false)) faces.push_back(face);
  for (const Face& face : boxFaces({-2.0, 2.5, 0.0}, {-1.2, 3.3, 2.0}, false))
    faces.push_back(face);
  return faces;
}

/// Random points, evenly over the faces' area, with noise along normals.
inline OrientedPoints pointsOn(const std::vector<Face>& faces, std::size_t count, double noise_m,
                               uint64_t seed) {
  TestRandom random(seed);
  std::vector<double> sums;
  double area = 0.0;
  for (const Face& face : faces) sums.push_back(area += face.u_m.cross(face.v_m).norm());
  OrientedPoints points;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = random.real(0.0, area);
    std::size_t f = 0;
    while (f + 1 < faces.size() && at >= sums[f]) ++f;
    const double s = random.real(0.0, 1.0);
    const double t = random.real(0.0, 1.0);
    points.positions_m.emplace_back(faces[f].corner_m + s * faces[f].u_m + t * faces[f].v_m +
                                    noise_m * random.normal() * faces[f].normal);
    points.normals.push_back(faces[f].normal.cast<float>());
  }
  return points;
}

inline OrientedPoints moved(const Eigen::Isometry3d& T, const OrientedPoints& points) {
  OrientedPoints out = points;
  for (Eigen::Vector3d& p : out.positions_m) p = T * p;
  for (Eigen::Vector3f& n : out.normals) n = (T.linear() * n.cast<double>()).cast<float>();
  return out;
}

inline Eigen::Isometry3d motion(const Eigen::Vector3d& translation_m, double angle_deg,
                                const Eigen::Vector3d& axis = Eigen::Vector3d::UnitZ()) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(angle_deg * M_PI / 180.0, axis.normalized()).toRotationMatrix();
  T.translation() = translation_m;
  return T;
}

inline double angleDeg(const Eigen::Isometry3d& T) {
  return Eigen::AngleAxisd(T.linear()).angle() * 180.0 / M_PI;
}

}  // namespace ladar_perception::test
