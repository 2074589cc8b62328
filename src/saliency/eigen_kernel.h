// SPDX-License-Identifier: BSD-3-Clause
// The eigen-solver without branches, so that a loop over many matrices is vectorised. See
// eigen_symmetric3.h for what it computes and why this way.
#pragma once

#include <algorithm>
#include <cmath>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception::eigen_kernel {

template <typename Scalar>
struct Vector {
  Scalar x, y, z;
};

template <typename Scalar>
struct Result {
  Scalar l0, l1, l2;
  Vector<Scalar> e0, e2;
};

template <typename Scalar>
LADAR_INLINE Scalar dot(const Vector<Scalar>& a, const Vector<Scalar>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename Scalar>
LADAR_INLINE Vector<Scalar> cross(const Vector<Scalar>& a, const Vector<Scalar>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <typename Scalar>
LADAR_INLINE Vector<Scalar> combine(Scalar s, const Vector<Scalar>& a, Scalar t,
                                    const Vector<Scalar>& b) {
  return {s * a.x + t * b.x, s * a.y + t * b.y, s * a.z + t * b.z};
}

template <typename Scalar>
LADAR_INLINE Vector<Scalar> select(bool first, const Vector<Scalar>& a, const Vector<Scalar>& b) {
  return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}

/// Greatest root of b^3 - 3 b - 2 r = 0 for r in [0, 1]; it lies in [sqrt(3), 2].
template <typename Scalar>
LADAR_INLINE Scalar isolatedRoot(Scalar r) {
  constexpr auto kSqrt3 = static_cast<Scalar>(1.7320508075688772);
  Scalar b = kSqrt3 + (2 - kSqrt3) * r;
  // The chord is within 0.02 of the root; Newton's error is then 2e-4, 2e-8, 2e-16.
  constexpr int kSteps = sizeof(Scalar) == sizeof(float) ? 2 : 3;
  for (int i = 0; i < kSteps; ++i) b -= (b * b * b - 3 * b - 2 * r) / (3 * b * b - 3);
  return b;
}

/// Unit vector across all rows of a singular matrix of rank 2: the longest of the cross products.
template <typename Scalar>
LADAR_INLINE Vector<Scalar> nullVector(const Vector<Scalar>& row0, const Vector<Scalar>& row1,
                                       const Vector<Scalar>& row2) {
  const Vector<Scalar> c01 = cross(row0, row1);
  const Vector<Scalar> c02 = cross(row0, row2);
  const Vector<Scalar> c12 = cross(row1, row2);
  const bool second = dot(c02, c02) > dot(c01, c01);
  Vector<Scalar> longest = select(second, c02, c01);
  const bool third = dot(c12, c12) > dot(longest, longest);
  longest = select(third, c12, longest);
  const Scalar inverse = 1 / std::sqrt(dot(longest, longest));
  return {longest.x * inverse, longest.y * inverse, longest.z * inverse};
}

/// `u` and `v` complete the unit vector `w` to an orthonormal basis (Duff et al., "Building an
/// Orthonormal Basis, Revisited", 2017).
template <typename Scalar>
LADAR_INLINE void completeBasis(const Vector<Scalar>& w, Vector<Scalar>* u, Vector<Scalar>* v) {
  const Scalar sign = w.z >= 0 ? Scalar{1} : Scalar{-1};
  const Scalar a = -1 / (sign + w.z);
  const Scalar b = w.x * w.y * a;
  *u = {1 + sign * w.x * w.x * a, sign * b, -sign * w.x};
  *v = {b, sign + w.y * w.y * a, -w.y};
}

template <typename Scalar>
LADAR_INLINE Result<Scalar> solve(Scalar xx, Scalar xy, Scalar xz, Scalar yy, Scalar yz,
                                  Scalar zz) {
  // B = (A - q I) / p has trace 0 and Frobenius norm sqrt(6): its eigenvalues lie in [-2, 2].
  // Scaling by the greatest entry first keeps the squares from overflowing or vanishing.
  const Scalar scale =
      std::max(std::max(std::max(std::abs(xx), std::abs(yy)), std::max(std::abs(zz), std::abs(xy))),
               std::max(std::abs(xz), std::abs(yz)));
  const Scalar by_scale = scale > 0 ? 1 / scale : Scalar{0};
  const Scalar q = (xx * by_scale + yy * by_scale + zz * by_scale) / 3;
  const Scalar dx = xx * by_scale - q;
  const Scalar dy = yy * by_scale - q;
  const Scalar dz = zz * by_scale - q;
  const Scalar ox = yz * by_scale;
  const Scalar oy = xz * by_scale;
  const Scalar oz = xy * by_scale;
  const Scalar p = std::sqrt((dx * dx + dy * dy + dz * dz + 2 * (ox * ox + oy * oy + oz * oz)) / 6);
  // A multiple of the identity: every vector is an eigenvector, B = 0 serves.
  const Scalar by_p = p > Scalar{1e-18F} ? 1 / p : Scalar{0};
  const Vector<Scalar> row_x = {dx * by_p, oz * by_p, oy * by_p};
  const Vector<Scalar> row_y = {oz * by_p, dy * by_p, ox * by_p};
  const Vector<Scalar> row_z = {oy * by_p, ox * by_p, dz * by_p};

  const Scalar half_determinant = Scalar{0.5} * dot(row_x, cross(row_y, row_z));
  const Scalar sign = half_determinant >= 0 ? Scalar{1} : Scalar{-1};
  const Scalar isolated = isolatedRoot(std::min(std::abs(half_determinant), Scalar{1}));
  const Vector<Scalar> w =
      nullVector<Scalar>({sign * row_x.x - isolated, sign * row_x.y, sign * row_x.z},
                         {sign * row_y.x, sign * row_y.y - isolated, sign * row_y.z},
                         {sign * row_z.x, sign * row_z.y, sign * row_z.z - isolated});
  Vector<Scalar> u;
  Vector<Scalar> v;
  completeBasis(w, &u, &v);

  const auto times = [&](const Vector<Scalar>& a) LADAR_INLINE_LAMBDA {
    return Vector<Scalar>{dot(row_x, a), dot(row_y, a), dot(row_z, a)};
  };
  const Vector<Scalar> bu = times(u);
  const Vector<Scalar> bv = times(v);
  const Scalar uv = dot(u, bv);
  const Scalar mean = Scalar{0.5} * (dot(u, bu) + dot(v, bv));
  const Scalar d = Scalar{0.5} * (dot(u, bu) - dot(v, bv));
  const Scalar h = std::sqrt(d * d + uv * uv);
  // Eigenvector of mean + h in the (u, v) plane, from the sum that does not cancel.
  const Scalar raw_c = d >= 0 ? d + h : uv;
  const Scalar raw_s = d >= 0 ? uv : h - d;
  const Scalar length = std::sqrt(raw_c * raw_c + raw_s * raw_s);
  const Scalar by_length = length > 0 ? 1 / length : Scalar{0};
  const Scalar c = length > 0 ? raw_c * by_length : Scalar{1};
  const Scalar s = raw_s * by_length;
  const Vector<Scalar> e_upper = combine(c, u, s, v);
  const Vector<Scalar> e_lower = combine(c, v, -s, u);

  const Scalar w_value = dot(w, times(w));
  const Scalar lower_value = mean - h;
  const Scalar upper_value = mean + h;
  const bool greatest = sign > 0;
  Result<Scalar> result;
  result.l0 = ((greatest ? lower_value : w_value) * p + q) * scale;
  result.l1 = ((greatest ? upper_value : lower_value) * p + q) * scale;
  result.l2 = ((greatest ? w_value : upper_value) * p + q) * scale;
  result.e0 = select(greatest, e_lower, w);
  result.e2 = select(greatest, w, e_upper);
  return result;
}

}  // namespace ladar_perception::eigen_kernel
