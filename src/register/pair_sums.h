// SPDX-License-Identifier: BSD-3-Clause
// Pairs of points of two clouds, and the sums over them that Gauss-Newton needs.
#pragma once

#include <Eigen/Geometry>
#include <limits>

#include "ladar_perception/register/registrar.h"
#include "registration_cloud_parts.h"

namespace ladar_perception {

/// How partners are found and what pairs cost.
struct Matching {
  const SurfaceIndex* index = nullptr;    ///< of `target`
  const IndexedPoints* target = nullptr;  ///< a's points
  const IndexedPoints* source = nullptr;  ///< b's samples
  std::size_t samples = 0;                ///< the first of these
  double radius_m = 0.0;
  double min_normal_cosine = -1.0;
  /// Of Geman and McClure's kernel; infinite: every pair counts the same.
  double robust_scale_m = std::numeric_limits<double>::infinity();
  bool generalized = false;
};

/// Sums over pairs; twists (rotation, translation) move b in a's axes, about the clouds' local
/// origin of a.
struct PairSums {
  Matrix6d information = Matrix6d::Zero();  ///< of weighted residuals, for unit noise
  Vector6d gradient = Vector6d::Zero();     ///< the step is -information^-1 gradient
  Matrix6d spread = Matrix6d::Zero();       ///< of the gradient's terms: their sum of squares
  Matrix6d unweighted = Matrix6d::Zero();   ///< information of the normals alone, all weights 1
  Eigen::Vector3d position_sum = Eigen::Vector3d::Zero();
  double squared_position_sum = 0.0;
  double squared_residual_sum = 0.0;  ///< m^2, distances from the partner's plane
  std::size_t pairs = 0;
};

/// `T_a_b`: between the clouds' local origins.
PairSums sumPairs(const Matching& matching, const Eigen::Isometry3d& T_a_b);

/// What one pair adds. `q`: b's point and `n`: its normal, both in a; `p`, `m`: the partner's.
void addPair(const Matching& matching, const Eigen::Vector3d& q, const Eigen::Vector3d& n,
             const Eigen::Vector3d& p, const Eigen::Vector3d& m, PairSums* sums);

}  // namespace ladar_perception
