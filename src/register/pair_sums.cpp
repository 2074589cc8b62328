// SPDX-License-Identifier: BSD-3-Clause
#include "pair_sums.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "ladar_perception/register/twist.h"

namespace ladar_perception {
namespace {

/// Variance across a surface over that along it, in generalised ICP.
constexpr double kFlatness = 1e-3;

/// Weight of a squared residual under Geman and McClure's kernel r^2 / (r^2 + c^2).
double robustWeight(double squared_m2, double scale_m, PairSums* sums) {
  const double ratio = squared_m2 / (scale_m * scale_m);
  const double share = 1.0 / (1.0 + ratio);
  sums->weights += share * share;
  sums->curvatures += share * share * share * (1.0 - 3.0 * ratio);
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

Vector6d addGeneralized(double robust_scale_m, const Eigen::Vector3d& q, const Eigen::Vector3d& n,
                        const Eigen::Vector3d& p, const Eigen::Vector3d& m, PairSums* sums) {
  const Eigen::Vector3d error = q - p;
  const Eigen::Matrix3d weights = generalizedWeights(n, m);
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << -skew(q), Eigen::Matrix3d::Identity();
  const Eigen::Vector3d weighted = weights * error;
  const double weight = robustWeight(error.dot(weighted), robust_scale_m, sums);
  sums->information += weight * (jacobian.transpose() * weights * jacobian);
  return weight * (jacobian.transpose() * weighted);
}

}  // namespace

Vector6d addPair(const Matching& matching, const Eigen::Vector3d& q, const Eigen::Vector3d& n,
                 const Eigen::Vector3d& p, const Eigen::Vector3d& m, PairSums* sums) {
  const double distance_m = m.dot(q - p);
  const double squared_m2 = distance_m * distance_m;
  Vector6d gradient;
  if (matching.generalized) {
    gradient = addGeneralized(matching.robust_scale_m, q, n, p, m, sums);
  } else {
    const double weight = robustWeight(squared_m2, matching.robust_scale_m, sums);
    const Vector6d jacobian = planeJacobian(q, m);
    const Vector6d weighted = weight * jacobian;
    sums->information.noalias() += weighted * jacobian.transpose();
    gradient = distance_m * weighted;
  }
  sums->gradient += gradient;
  sums->positions += q;
  sums->position_squares.noalias() += q * q.transpose();
  sums->squared_residuals += squared_m2;
  ++sums->pairs;
  return gradient;
}

std::vector<Pair> findPairs(const Matching& matching, const Eigen::Isometry3d& T_a_b,
                            std::vector<SurfaceIndex::Memory>* memories) {
  const Eigen::Matrix3f rotation = T_a_b.linear().cast<float>();
  const Eigen::Vector3f translation = T_a_b.translation().cast<float>();
  const auto radius_squared = static_cast<float>(matching.radius_m * matching.radius_m);
  const auto min_cosine = static_cast<float>(matching.min_normal_cosine);
  const std::size_t count = std::min(matching.samples, matching.source->positions.size());
  memories->resize(matching.source->positions.size());
  std::vector<Pair> pairs;
  pairs.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f q = rotation * matching.source->positions[i] + translation;
    const Eigen::Vector3f n = rotation * matching.source->normals[i];
    const int j = matching.index->nearest(q, n, radius_squared, &(*memories)[i]);
    if (j == SurfaceIndex::kNone) continue;
    if (n.dot(matching.target->normals[static_cast<std::size_t>(j)]) < min_cosine) continue;
    pairs.push_back({static_cast<int>(i), j});
  }
  return pairs;
}

double planeDistance(const Matching& matching, const Pair& pair, const Eigen::Isometry3d& T_a_b) {
  const auto i = static_cast<std::size_t>(pair.sample);
  const auto j = static_cast<std::size_t>(pair.partner);
  const Eigen::Vector3d q = T_a_b * matching.source->positions[i].cast<double>();
  const Eigen::Vector3d offset = q - matching.target->positions[j].cast<double>();
  return std::abs(matching.target->normals[j].cast<double>().dot(offset));
}

PairSums sumPairs(const Matching& matching, const std::vector<Pair>& pairs,
                  const Eigen::Isometry3d& T_a_b, PairDetails* details) {
  PairSums sums;
  for (const Pair& pair : pairs) {
    const auto i = static_cast<std::size_t>(pair.sample);
    const auto j = static_cast<std::size_t>(pair.partner);
    const Eigen::Vector3d q = T_a_b * matching.source->positions[i].cast<double>();
    const Eigen::Vector3d n = T_a_b.linear() * matching.source->normals[i].cast<double>();
    const Eigen::Vector3d m = matching.target->normals[j].cast<double>();
    const Vector6d gradient =
        addPair(matching, q, n, matching.target->positions[j].cast<double>(), m, &sums);
    if (details == nullptr) continue;
    details->gradients.push_back(gradient);
    const Vector6d jacobian = planeJacobian(q, m);
    details->normals += jacobian * jacobian.transpose();
  }
  return sums;
}

}  // namespace ladar_perception
