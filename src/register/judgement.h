// SPDX-License-Identifier: BSD-3-Clause
// What the pairs at the end of a registration tell about it.
#pragma once

#include "pair_sums.h"

namespace ladar_perception {

/// Information of a pair on average, about the middle of the pairs with rotation in units of
/// length.
struct PairInformation {
  Vector6d eigenvalues = Vector6d::Zero();  ///< ascending
  Matrix6d eigenvectors = Matrix6d::Identity();
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  double lever_m = 1.0;
};

/// Of `information` about the sums' local origin.
PairInformation pairInformation(const PairSums& sums, const Matrix6d& information);

/// The Gauss-Newton step; none along directions that pairs tell nothing about.
Vector6d gaussNewtonStep(const PairSums& sums);

/// How a registration ended, apart from its pairs.
struct Ending {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< between local origins
  std::size_t samples = 0;                                  ///< of b
  bool settled = false;                                     ///< the last steps were small
  int iterations = 0;
};

/// Fills everything of a result.
RegistrationResult judge(const RegistrationConfig& config, const RegistrationCloud& a,
                         const RegistrationCloud& b, const PairSums& sums, const Ending& ending);

}  // namespace ladar_perception
