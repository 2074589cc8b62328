// SPDX-License-Identifier: BSD-3-Clause
#include "judgement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ladar_perception/register/twist.h"

namespace ladar_perception {
namespace {

/// Six unknowns need more than six pairs; with fewer than these anything fits.
constexpr std::size_t kMinPairs = 20;
/// Share of a motion that pairs see: nothing but rounding.
constexpr double kNoInformation = 1e-6;
/// Squared, of the points' extent: lines are not thinner.
constexpr double kLeastLever = 1e-6;
/// Of the robust kernel, on average; there it says nothing of how pairs spread.
constexpr double kLeastCurvature = 0.1;
/// Ranges are not better than this, however well two clouds (or one, twice) fit.
constexpr double kLeastNoise_m = 1e-3;

Eigen::Isometry3d translated(const Eigen::Vector3d& by) {
  return Eigen::Isometry3d(Eigen::Translation3d(by));
}

/// Takes twists about the middle of the pairs to twists about their origin.
Matrix6d fromCenter(const PairInformation& pairs) { return adjoint(translated(pairs.center_m)); }

/// Sum of squares of the gradient's independent parts: errors of a point of a are in all its pairs.
Matrix6d gradientSpread(const FinalPairs& final_pairs) {
  int last = -1;
  for (const Pair& pair : final_pairs.pairs) last = std::max(last, pair.partner);
  std::vector<Vector6d> of_partner(static_cast<std::size_t>(last + 1), Vector6d::Zero());
  for (std::size_t i = 0; i < final_pairs.pairs.size(); ++i) {
    of_partner[static_cast<std::size_t>(final_pairs.pairs[i].partner)] +=
        final_pairs.details.gradients[i];
  }
  Matrix6d spread = Matrix6d::Zero();
  for (const Vector6d& part : of_partner) spread += part * part.transpose();
  return spread;
}

/// Covariance of the twist about the local origin, in a's axes. The sandwich of the gradient's
/// spread between inverse informations needs no guess of the noise; along weak directions it would
/// be the noise of normals that speaks.
Matrix6d localCovariance(const PairSums& sums, const Matrix6d& gradient_spread,
                         const PairInformation& pairs, int weak) {
  const Matrix6d directions = fromCenter(pairs) * pairs.eigenvectors;
  const Eigen::MatrixXd known = directions.rightCols(6 - weak);
  // Iterations go by weights, but what a disturbance moves the minimum by depends on the curvature.
  const double flatter = std::clamp(sums.curvatures / sums.weights, kLeastCurvature, 1.0);
  const Eigen::MatrixXd inverse =
      (flatter * known.transpose() * sums.information * known).inverse();
  const Matrix6d spread = gradient_spread + kLeastNoise_m * kLeastNoise_m * sums.information;
  Matrix6d covariance =
      known * inverse * (known.transpose() * spread * known) * inverse * known.transpose();
  for (int i = 0; i < weak; ++i) {
    covariance += kWeakSigma_m * kWeakSigma_m * directions.col(i) * directions.col(i).transpose();
  }
  return 0.5 * (covariance + covariance.transpose());
}

std::string text(const char* format, double value, double limit) {
  char buffer[160];
  std::snprintf(buffer, sizeof(buffer), format, value, limit);
  return buffer;
}

/// Why it is no registration, or "".
std::string failure(const RegistrationConfig& config, const PairSums& sums, const Ending& ending,
                    double overlap) {
  if (!ending.T_a_b.matrix().allFinite()) return "the transform is not finite";
  // Many points may have one partner: it is the lesser number that counts.
  const std::size_t pairs = std::min({sums.pairs, ending.targets, ending.samples});
  if (pairs < kMinPairs) {
    return text("%.0f pairs, at least %.0f are needed", static_cast<double>(pairs),
                static_cast<double>(kMinPairs));
  }
  if (overlap < config.min_overlap) {
    return text("overlap %.2f, at least %.2f is needed", overlap, config.min_overlap);
  }
  if (!ending.settled) return "the iterations did not settle";
  return "";
}

}  // namespace

PairInformation pairInformation(const PairSums& sums, const Matrix6d& information) {
  PairInformation pairs;
  if (sums.pairs == 0) return pairs;
  const auto count = static_cast<double>(sums.pairs);
  pairs.center_m = sums.positions / count;
  const Eigen::Matrix3d second =
      sums.position_squares / count - pairs.center_m * pairs.center_m.transpose();
  // Squared motion of the points for a turn about an axis, on average; about the axis of points on
  // a line it vanishes.
  const Eigen::Matrix3d inertia =
      second.trace() * Eigen::Matrix3d::Identity() - second +
      (kLeastLever * second.trace() + 1e-12) * Eigen::Matrix3d::Identity();
  Matrix6d whitening = Matrix6d::Identity();
  whitening.topLeftCorner<3, 3>() =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).operatorInverseSqrt();
  const Matrix6d from_center = fromCenter(pairs) * whitening;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(from_center.transpose() * information *
                                                       from_center / count);
  pairs.eigenvalues = solver.eigenvalues();
  pairs.eigenvectors = whitening * solver.eigenvectors();
  return pairs;
}

Vector6d gaussNewtonStep(const PairSums& sums) {
  const PairInformation pairs = pairInformation(sums, sums.information);
  const Matrix6d directions = fromCenter(pairs) * pairs.eigenvectors;
  Vector6d step = Vector6d::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector6d direction = directions.col(i);
    const double value = pairs.eigenvalues[i];
    if (value < kNoInformation) continue;
    step -= direction * (direction.dot(sums.gradient) / (value * static_cast<double>(sums.pairs)));
  }
  return step;
}

RegistrationResult judge(const RegistrationConfig& config, const RegistrationCloud& a,
                         const RegistrationCloud& b, const FinalPairs& final_pairs,
                         const Ending& ending) {
  const PairSums& sums = final_pairs.sums;
  RegistrationResult result;
  result.iterations = ending.iterations;
  result.T_a_b = translated(a.origin_m()) * ending.T_a_b * translated(-b.origin_m());
  const auto pairs = static_cast<double>(sums.pairs);
  result.overlap = ending.overlap;
  if (sums.pairs > 0) result.residual_m = std::sqrt(sums.squared_residuals / pairs);
  const PairInformation information = pairInformation(sums, final_pairs.details.normals);
  result.information = information.eigenvalues;
  result.directions = information.eigenvectors;
  result.center_m = information.center_m + a.origin_m();
  while (result.weak_directions < 6 &&
         result.information[result.weak_directions] < config.min_information) {
    ++result.weak_directions;
  }
  result.reason = failure(config, sums, ending, result.overlap);
  if (!result.reason.empty()) return result;  // diverged
  result.verdict = Verdict::kConverged;
  if (result.weak_directions > 0) {
    result.verdict = Verdict::kDegenerate;
    result.reason = text("%.0f directions with less information than %g",
                         static_cast<double>(result.weak_directions), config.min_information);
  }
  const Matrix6d to_b = adjoint(result.T_a_b.inverse() * translated(a.origin_m()));
  result.covariance =
      to_b *
      localCovariance(sums, gradientSpread(final_pairs), information, result.weak_directions) *
      to_b.transpose();
  return result;
}

}  // namespace ladar_perception
