// SPDX-License-Identifier: BSD-3-Clause
#include "pair_sums.h"

#include <Eigen/LU>
#include <algorithm>

#include "ladar_perception/register/twist.h"

namespace ladar_perception {
namespace {

/// Variance across a surface over that along it, in generalised ICP.
constexpr double kFlatness = 1e-3;

/// Weight of a squared residual under Geman and McClure's kernel r^2 / (r^2 + c^2).
double robustWeight(double squared_m2, double scale_m) {
  const double share = 1.0 / (1.0 + squared_m2 / (scale_m * scale_m));
  return share * share;
}

/// The twist's effect on the distance of q from a plane of normal n.
Vector6d planeJacobian(const Eigen::Vector3d& q, const Eigen::Vector3d& n) {
  Vector6d jacobian;
  jacobian << q.cross(n), n;
  return jacobian;
}

/// Weights of q - p in generalised ICP, scaled so that two surfaces that look the same way weigh
/// their distance as point-to-plane does.
Eigen::Matrix3d generalizedWeights(const Eigen::Vector3d& n, const Eigen::Vector3d& m) {
  const Eigen::Matrix3d sum = 2.0 * Eigen::Matrix3d::Identity() -
                              (1.0 - kFlatness) * (n * n.transpose() + m * m.transpose());
  return 2.0 * kFlatness * sum.inverse();
}

void addGeneralized(double robust_scale_m, const Eigen::Vector3d& q, const Eigen::Vector3d& n,
                    const Eigen::Vector3d& p, const Eigen::Vector3d& m, PairSums* sums) {
  const Eigen::Vector3d error = q - p;
  const Eigen::Matrix3d weights = generalizedWeights(n, m);
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << -skew(q), Eigen::Matrix3d::Identity();
  const Eigen::Vector3d weighted = weights * error;
  const double weight = robustWeight(error.dot(weighted), robust_scale_m);
  const Vector6d gradient = weight * (jacobian.transpose() * weighted);
  sums->information += weight * (jacobian.transpose() * weights * jacobian);
  sums->gradient += gradient;
  sums->spread += gradient * gradient.transpose();
}

}  // namespace

void addPair(const Matching& matching, const Eigen::Vector3d& q, const Eigen::Vector3d& n,
             const Eigen::Vector3d& p, const Eigen::Vector3d& m, PairSums* sums) {
  const double distance_m = m.dot(q - p);
  const Vector6d jacobian = planeJacobian(q, m);
  const Matrix6d square = jacobian * jacobian.transpose();
  if (matching.generalized) {
    addGeneralized(matching.robust_scale_m, q, n, p, m, sums);
  } else {
    const double squared_m2 = distance_m * distance_m;
    const double weight = robustWeight(squared_m2, matching.robust_scale_m);
    sums->information += weight * square;
    sums->gradient += weight * distance_m * jacobian;
    sums->spread += weight * weight * squared_m2 * square;
  }
  sums->unweighted += square;
  sums->position_sum += q;
  sums->squared_position_sum += q.squaredNorm();
  sums->squared_residual_sum += distance_m * distance_m;
  ++sums->pairs;
}

PairSums sumPairs(const Matching& matching, const Eigen::Isometry3d& T_a_b) {
  PairSums sums;
  const Eigen::Matrix3f rotation = T_a_b.linear().cast<float>();
  const Eigen::Vector3f translation = T_a_b.translation().cast<float>();
  const auto radius_squared = static_cast<float>(matching.radius_m * matching.radius_m);
  const auto min_cosine = static_cast<float>(matching.min_normal_cosine);
  const std::size_t count = std::min(matching.samples, matching.source->positions.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f q = rotation * matching.source->positions[i] + translation;
    const Eigen::Vector3f n = rotation * matching.source->normals[i];
    const int j = matching.index->nearest(q, n, radius_squared);
    if (j == SurfaceIndex::kNone) continue;
    const auto partner = static_cast<std::size_t>(j);
    const Eigen::Vector3f& m = matching.target->normals[partner];
    if (n.dot(m) < min_cosine) continue;
    addPair(matching, q.cast<double>(), n.cast<double>(),
            matching.target->positions[partner].cast<double>(), m.cast<double>(), &sums);
  }
  return sums;
}

}  // namespace ladar_perception
