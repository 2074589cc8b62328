// SPDX-License-Identifier: BSD-3-Clause
// Registration of two poses' clouds: the transform that lays one on the other, and how far it is to
// be trusted.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "ladar_perception/register/registration_cloud.h"
#include "ladar_perception/register/registration_config.h"

namespace ladar_perception {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

enum class Verdict {
  kConverged,
  kDegenerate,  ///< laid on, but pairs do not tell of every direction
  kDiverged,    ///< T_a_b is where the iterations ended and means nothing
};

/// "converged", "degenerate", "diverged"
const char* verdictName(Verdict verdict);

struct RegistrationResult {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
  /// Of a twist (rotation, rad; translation, m) in frame b: the true transform is T_a_b exp(twist).
  /// Weak directions have a standard deviation of kWeakSigma_m. Zero if diverged.
  Matrix6d covariance = Matrix6d::Zero();
  double overlap = 0.0;     ///< share of b's surface that lies on a's at the end; of its samples if
                            ///< these are all it has
  double residual_m = 0.0;  ///< root mean square distance of the last pairs, from partners' planes
  /// What the pairs tell of motions, least first: share of a motion of the pairs' points, squared,
  /// that is across their surfaces. Only such motion is seen.
  Vector6d information = Vector6d::Zero();
  /// These motions: a column is a twist of b in a's axes about `center_m`, by which points move 1 m
  /// (root mean square).
  Matrix6d directions = Matrix6d::Zero();
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< of the pairs, in frame a
  int weak_directions = 0;  ///< the first of `directions`, told less than min_information of
  Verdict verdict = Verdict::kDiverged;
  std::string reason;  ///< of a verdict other than converged
  int iterations = 0;
};

/// What a registration that sees nothing along a direction knows about it, m.
constexpr double kWeakSigma_m = 10.0;

/// A way to register. Implementations are immutable: threads may share one.
class Registrar {
 public:
  virtual ~Registrar() = default;
  /// Lays `b` on `a` from a guess of the transform that takes b's frame into a's.
  virtual RegistrationResult align(const RegistrationCloud& a, const RegistrationCloud& b,
                                   const Eigen::Isometry3d& T_a_b_guess) const = 0;
};

/// Point-to-plane (or generalised) iterations. Annealed: pairs are nearest points in the same bin
/// of normals, within a radius that shrinks every iteration; the first farthest-first samples while
/// it is large, then all; then with a robust kernel against the finest points there are; last, if
/// finish_points are wanted, these of b's surface against a's. The same bits every time.
class SurfaceRegistrar : public Registrar {
 public:
  /// Throws std::invalid_argument with every violation of `config`.
  explicit SurfaceRegistrar(const RegistrationConfig& config);

  RegistrationResult align(const RegistrationCloud& a, const RegistrationCloud& b,
                           const Eigen::Isometry3d& T_a_b_guess) const override;

 private:
  RegistrationConfig config_;
};

}  // namespace ladar_perception
