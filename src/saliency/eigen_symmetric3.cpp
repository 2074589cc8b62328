// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/eigen_symmetric3.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace ladar_perception {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Greatest root of b^3 - 3 b - 2 r = 0 for r in [0, 1]; it lies in [sqrt(3), 2].
double isolatedRoot(double r) {
  constexpr double kSqrt3 = 1.7320508075688772;
  double b = kSqrt3 + (2.0 - kSqrt3) * r;
  // The chord is within 0.004 of the root, so Newton's error is 1e-5, 1e-11, below rounding.
  for (int i = 0; i < 4; ++i) b -= (b * b * b - 3.0 * b - 2.0 * r) / (3.0 * b * b - 3.0);
  return b;
}

/// Unit vector across all rows of a singular matrix of rank 2: the longest of the cross products.
Vector3d nullVector(const Matrix3d& m) {
  const Vector3d candidates[3] = {m.row(0).cross(m.row(1)), m.row(0).cross(m.row(2)),
                                  m.row(1).cross(m.row(2))};
  const Vector3d* longest = &candidates[0];
  for (const Vector3d& candidate : candidates) {
    if (candidate.squaredNorm() > longest->squaredNorm()) longest = &candidate;
  }
  return longest->normalized();
}

/// Two unit vectors that complete `w` to an orthonormal basis.
void completeBasis(const Vector3d& w, Vector3d* u, Vector3d* v) {
  int least = 0;
  w.cwiseAbs().minCoeff(&least);
  *u = w.cross(Vector3d::Unit(least)).normalized();
  *v = w.cross(*u);
}

}  // namespace

EigenSymmetric3 eigenSymmetric3(const SymmetricMatrix3& a) {
  EigenSymmetric3 result;
  Matrix3d m;
  m << a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz;
  // B = (A - q I) / p has trace 0 and Frobenius norm sqrt(6): its eigenvalues lie in [-2, 2].
  // Scaling by the greatest entry first keeps the squares from overflowing or vanishing.
  const double scale = m.cwiseAbs().maxCoeff();
  if (!(scale > 0.0)) return result;
  m /= scale;
  const double q = m.trace() / 3.0;
  m.diagonal().array() -= q;
  const double p = std::sqrt(m.squaredNorm() / 6.0);
  if (!(p > 1e-18)) {
    result.l0 = result.l1 = result.l2 = q * scale;
    return result;
  }
  m /= p;
  const double half_determinant = std::clamp(m.determinant() / 2.0, -1.0, 1.0);
  const double sign = half_determinant >= 0.0 ? 1.0 : -1.0;
  const double isolated = isolatedRoot(std::abs(half_determinant));
  const Vector3d w = nullVector(sign * m - isolated * Matrix3d::Identity());

  Vector3d u;
  Vector3d v;
  completeBasis(w, &u, &v);
  const double uu = u.dot(m * u);
  const double uv = u.dot(m * v);
  const double vv = v.dot(m * v);
  const double mean = (uu + vv) / 2.0;
  const double d = (uu - vv) / 2.0;
  const double h = std::sqrt(d * d + uv * uv);  // entries are of order 1
  // Eigenvector of mean + h in the (u, v) plane, from the sum that does not cancel.
  Eigen::Vector2d upper = d >= 0.0 ? Eigen::Vector2d(d + h, uv) : Eigen::Vector2d(uv, h - d);
  upper = h > 0.0 ? Eigen::Vector2d(upper.normalized()) : Eigen::Vector2d::UnitX();
  const Vector3d e_upper = upper.x() * u + upper.y() * v;
  const Vector3d e_lower = upper.x() * v - upper.y() * u;

  // The isolated value as w' B w: w is accurate, the root itself carries the determinant's error.
  const double w_value = w.dot(m * w);
  const auto value = [&](double b) { return (b * p + q) * scale; };
  if (sign > 0.0) {
    result = {value(mean - h), value(mean + h), value(w_value), e_lower, w};
  } else {
    result = {value(w_value), value(mean - h), value(mean + h), w, e_upper};
  }
  return result;
}

}  // namespace ladar_perception
