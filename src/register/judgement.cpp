// SPDX-License-Identifier: BSD-3-Clause
#include "judgement.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>

#include "ladar_perception/register/twist.h"

namespace ladar_perception {
namespace {

/// Six unknowns need more than six pairs; with fewer than these anything fits.
constexpr std::size_t kMinPairs = 20;
/// Per pair, relative to one that is seen by every pair: nothing but rounding.
constexpr double kNoInformation = 1e-6;
/// Ranges are not better than this, however well two clouds (or one, twice) fit.
constexpr double kLeastNoise_m = 1e-3;

Eigen::Isometry3d translated(const Eigen::Vector3d& by) {
  return Eigen::Isometry3d(Eigen::Translation3d(by));
}

/// Takes scaled twists about the middle of the pairs to twists about their origin.
Matrix6d fromCenter(const PairInformation& pairs) {
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(1.0 / pairs.lever_m), Eigen::Vector3d::Ones();
  return adjoint(translated(pairs.center_m)) * scale.asDiagonal();
}

/// Covariance of the twist about the local origin, in a's axes. The sandwich of the gradient's
/// spread between inverse informations needs no guess of the noise; along weak directions it would
/// be the noise of normals that speaks.
Matrix6d localCovariance(const PairSums& sums, const PairInformation& pairs, int weak) {
  const Matrix6d to_local = fromCenter(pairs);
  const Matrix6d information = to_local.transpose() * sums.information * to_local;
  const Matrix6d spread =
      to_local.transpose() * sums.spread * to_local + kLeastNoise_m * kLeastNoise_m * information;
  const Matrix6d& v = pairs.eigenvectors;
  const int known = 6 - weak;
  const Eigen::MatrixXd k = v.rightCols(known);
  const Eigen::MatrixXd inverse = (k.transpose() * information * k).inverse();
  Matrix6d covariance = k * inverse * (k.transpose() * spread * k) * inverse * k.transpose();
  for (int i = 0; i < weak; ++i) {
    covariance += kWeakSigma_m * kWeakSigma_m * v.col(i) * v.col(i).transpose();
  }
  const Matrix6d local = to_local * covariance * to_local.transpose();
  return 0.5 * (local + local.transpose());
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
  if (sums.pairs < kMinPairs) {
    return text("%.0f pairs, at least %.0f are needed", static_cast<double>(sums.pairs),
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
  pairs.center_m = sums.position_sum / count;
  const double squared_m2 = sums.squared_position_sum / count - pairs.center_m.squaredNorm();
  pairs.lever_m = std::sqrt(std::max(squared_m2, 1e-6));
  const Matrix6d to_local = fromCenter(pairs);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(to_local.transpose() * information *
                                                       to_local / count);
  pairs.eigenvalues = solver.eigenvalues();
  pairs.eigenvectors = solver.eigenvectors();
  return pairs;
}

Vector6d gaussNewtonStep(const PairSums& sums) {
  const PairInformation pairs = pairInformation(sums, sums.information);
  const Matrix6d to_local = fromCenter(pairs);
  const Vector6d gradient = to_local.transpose() * sums.gradient;
  Vector6d step = Vector6d::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector6d direction = pairs.eigenvectors.col(i);
    const double value = pairs.eigenvalues[i];
    if (value < kNoInformation) continue;
    step -= direction * (direction.dot(gradient) / (value * static_cast<double>(sums.pairs)));
  }
  return to_local * step;
}

RegistrationResult judge(const RegistrationConfig& config, const RegistrationCloud& a,
                         const RegistrationCloud& b, const PairSums& sums, const Ending& ending) {
  RegistrationResult result;
  result.iterations = ending.iterations;
  result.T_a_b = translated(a.origin_m()) * ending.T_a_b * translated(-b.origin_m());
  const auto pairs = static_cast<double>(sums.pairs);
  if (ending.samples > 0) result.overlap = pairs / static_cast<double>(ending.samples);
  if (sums.pairs > 0) result.residual_m = std::sqrt(sums.squared_residual_sum / pairs);
  const PairInformation information = pairInformation(sums, sums.unweighted);
  result.information = information.eigenvalues;
  result.directions = information.eigenvectors;
  result.center_m = information.center_m + a.origin_m();
  result.lever_m = information.lever_m;
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
      to_b * localCovariance(sums, information, result.weak_directions) * to_b.transpose();
  return result;
}

}  // namespace ladar_perception
