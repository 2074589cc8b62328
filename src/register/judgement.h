// SPDX-License-Identifier: BSD-3-Clause
// What the pairs at the end of a registration tell about it.
#pragma once

#include "pair_sums.h"

namespace ladar_perception {

/// What pairs tell of motions about their middle. Every eigenvector is a twist that moves the
/// pairs' points by a metre (root mean square); its eigenvalue is how much of that, squared, is
/// across their surfaces, and so is seen.
struct PairInformation {
  Vector6d eigenvalues = Vector6d::Zero();  ///< 0 to 1, ascending
  Matrix6d eigenvectors = Matrix6d::Zero();
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
};

/// `information`: a sum over the pairs, about the local origin.
PairInformation pairInformation(const PairSums& sums, const Matrix6d& information);

/// The Gauss-Newton step; none along directions that pairs tell nothing about.
Vector6d gaussNewtonStep(const PairSums& sums);

/// How a registration ended, apart from its pairs.
struct Ending {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();  ///< between local origins
  std::size_t targets = 0;                                  ///< points of a
  std::size_t samples = 0;                                  ///< of b
  double overlap = 0.0;  ///< share of b's points that lie on a's surfaces
  bool settled = false;  ///< the last steps were small
  int iterations = 0;
};

/// The pairs at the end.
struct FinalPairs {
  std::vector<Pair> pairs;
  PairSums sums;
  PairDetails details;
};

/// Fills everything of a result.
RegistrationResult judge(const RegistrationConfig& config, const RegistrationCloud& a,
                         const RegistrationCloud& b, const FinalPairs& pairs, const Ending& ending);

}  // namespace ladar_perception
