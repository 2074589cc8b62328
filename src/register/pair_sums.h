// SPDX-License-Identifier: BSD-3-Clause
// Pairs of points of two clouds, and the sums over them that Gauss-Newton needs.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <vector>

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
  Eigen::Vector3d positions = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position_squares = Eigen::Matrix3d::Zero();
  double squared_residuals = 0.0;  ///< m^2, distances from the partner's plane
  double weights = 0.0;            ///< of the robust kernel: its slope over the residual
  double curvatures = 0.0;         ///< of the robust kernel: its second derivative
  std::size_t pairs = 0;
};

/// A sample of b and its partner in a.
struct Pair {
  int sample = 0;
  int partner = 0;
};

/// Pairs for `T_a_b` between the clouds' local origins. `memories`: of b's samples in the same
/// index from the iteration before, or empty; those of this one when it returns.
std::vector<Pair> findPairs(const Matching& matching, const Eigen::Isometry3d& T_a_b,
                            std::vector<SurfaceIndex::Memory>* memories);

/// How far a pair's sample is from its partner's plane, m.
double planeDistance(const Matching& matching, const Pair& pair, const Eigen::Isometry3d& T_a_b);

/// What is known of pairs only where it is asked for.
struct PairDetails {
  std::vector<Vector6d> gradients;      ///< what every pair adds to the gradient
  Matrix6d normals = Matrix6d::Zero();  ///< information of distances from planes, all weights 1
};

PairSums sumPairs(const Matching& matching, const std::vector<Pair>& pairs,
                  const Eigen::Isometry3d& T_a_b, PairDetails* details = nullptr);

/// Adds one pair and returns what it added to the gradient. `q`: b's point and `n`: its normal,
/// both in a; `p`, `m`: the partner's.
Vector6d addPair(const Matching& matching, const Eigen::Vector3d& q, const Eigen::Vector3d& n,
                 const Eigen::Vector3d& p, const Eigen::Vector3d& m, PairSums* sums);

}  // namespace ladar_perception
