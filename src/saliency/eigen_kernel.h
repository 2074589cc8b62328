// SPDX-License-Identifier: BSD-3-Clause
// The eigen-solver without branches, so that a loop over many matrices is vectorised. See
// eigen_symmetric3.h for what it computes and why this way.
#pragma once

#include <algorithm>
#include <cmath>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception::eigen_kernel {

struct Vector {
  double x, y, z;
};

struct Result {
  double l0, l1, l2;
  Vector e0, e2;
};

LADAR_INLINE double dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

LADAR_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

LADAR_INLINE Vector combine(double s, const Vector& a, double t, const Vector& b) {
  return {s * a.x + t * b.x, s * a.y + t * b.y, s * a.z + t * b.z};
}

LADAR_INLINE Vector select(bool first, const Vector& a, const Vector& b) {
  return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}

/// Greatest root of b^3 - 3 b - 2 r = 0 for r in [0, 1]; it lies in [sqrt(3), 2].
LADAR_INLINE double isolatedRoot(double r) {
  constexpr double kSqrt3 = 1.7320508075688772;
  double b = kSqrt3 + (2.0 - kSqrt3) * r;
  // The chord is within 0.02 of the root; Newton's error is then 2e-4, 2e-8, 2e-16.
  for (int i = 0; i < 3; ++i) b -= (b * b * b - 3.0 * b - 2.0 * r) / (3.0 * b * b - 3.0);
  return b;
}

/// Unit vector across all rows of a singular matrix of rank 2: the longest of the cross products.
LADAR_INLINE Vector nullVector(const Vector& row0, const Vector& row1, const Vector& row2) {
  const Vector c01 = cross(row0, row1);
  const Vector c02 = cross(row0, row2);
  const Vector c12 = cross(row1, row2);
  const bool second = dot(c02, c02) > dot(c01, c01);
  Vector longest = select(second, c02, c01);
  const bool third = dot(c12, c12) > dot(longest, longest);
  longest = select(third, c12, longest);
  const double inverse = 1.0 / std::sqrt(dot(longest, longest));
  return {longest.x * inverse, longest.y * inverse, longest.z * inverse};
}

/// `u` and `v` complete the unit vector `w` to an orthonormal basis (Duff et al., "Building an
/// Orthonormal Basis, Revisited", 2017).
LADAR_INLINE void completeBasis(const Vector& w, Vector* u, Vector* v) {
  const double sign = w.z >= 0.0 ? 1.0 : -1.0;
  const double a = -1.0 / (sign + w.z);
  const double b = w.x * w.y * a;
  *u = {1.0 + sign * w.x * w.x * a, sign * b, -sign * w.x};
  *v = {b, sign + w.y * w.y * a, -w.y};
}

LADAR_INLINE Result solve(double xx, double xy, double xz, double yy, double yz, double zz) {
  // B = (A - q I) / p has trace 0 and Frobenius norm sqrt(6): its eigenvalues lie in [-2, 2].
  // Scaling by the greatest entry first keeps the squares from overflowing or vanishing.
  const double scale =
      std::max(std::max(std::max(std::abs(xx), std::abs(yy)), std::max(std::abs(zz), std::abs(xy))),
               std::max(std::abs(xz), std::abs(yz)));
  const double by_scale = scale > 0.0 ? 1.0 / scale : 0.0;
  const double q = (xx * by_scale + yy * by_scale + zz * by_scale) / 3.0;
  const double dx = xx * by_scale - q;
  const double dy = yy * by_scale - q;
  const double dz = zz * by_scale - q;
  const double ox = yz * by_scale;
  const double oy = xz * by_scale;
  const double oz = xy * by_scale;
  const double p =
      std::sqrt((dx * dx + dy * dy + dz * dz + 2.0 * (ox * ox + oy * oy + oz * oz)) / 6.0);
  // A multiple of the identity: every vector is an eigenvector, B = 0 serves.
  const double by_p = p > 1e-18 ? 1.0 / p : 0.0;
  const Vector row_x = {dx * by_p, oz * by_p, oy * by_p};
  const Vector row_y = {oz * by_p, dy * by_p, ox * by_p};
  const Vector row_z = {oy * by_p, ox * by_p, dz * by_p};

  const double half_determinant = 0.5 * dot(row_x, cross(row_y, row_z));
  const double sign = half_determinant >= 0.0 ? 1.0 : -1.0;
  const double isolated = isolatedRoot(std::min(std::abs(half_determinant), 1.0));
  const Vector w = nullVector({sign * row_x.x - isolated, sign * row_x.y, sign * row_x.z},
                              {sign * row_y.x, sign * row_y.y - isolated, sign * row_y.z},
                              {sign * row_z.x, sign * row_z.y, sign * row_z.z - isolated});
  Vector u;
  Vector v;
  completeBasis(w, &u, &v);

  const auto times = [&](const Vector& a) {
    return Vector{dot(row_x, a), dot(row_y, a), dot(row_z, a)};
  };
  const Vector bu = times(u);
  const Vector bv = times(v);
  const double uv = dot(u, bv);
  const double mean = 0.5 * (dot(u, bu) + dot(v, bv));
  const double d = 0.5 * (dot(u, bu) - dot(v, bv));
  const double h = std::sqrt(d * d + uv * uv);
  // Eigenvector of mean + h in the (u, v) plane, from the sum that does not cancel.
  const double raw_c = d >= 0.0 ? d + h : uv;
  const double raw_s = d >= 0.0 ? uv : h - d;
  const double length = std::sqrt(raw_c * raw_c + raw_s * raw_s);
  const double by_length = length > 0.0 ? 1.0 / length : 0.0;
  const double c = length > 0.0 ? raw_c * by_length : 1.0;
  const double s = raw_s * by_length;
  const Vector e_upper = combine(c, u, s, v);
  const Vector e_lower = combine(c, v, -s, u);

  const double w_value = dot(w, times(w));
  const double lower_value = mean - h;
  const double upper_value = mean + h;
  const bool greatest = sign > 0.0;
  Result result;
  result.l0 = ((greatest ? lower_value : w_value) * p + q) * scale;
  result.l1 = ((greatest ? upper_value : lower_value) * p + q) * scale;
  result.l2 = ((greatest ? w_value : upper_value) * p + q) * scale;
  result.e0 = select(greatest, e_lower, w);
  result.e2 = select(greatest, w, e_upper);
  return result;
}

}  // namespace ladar_perception::eigen_kernel
