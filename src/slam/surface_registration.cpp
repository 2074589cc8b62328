// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/surface_registration.h"

#include <algorithm>
#include <cmath>

#include "ladar_perception/register/registrar.h"

namespace ladar_perception {
namespace {

// Pairs must be found at the far end of what the covariance allows.
constexpr double kSigmas = 3.0;
// Where a turn moves samples by its angle times this.
constexpr double kLeverM = 20.0;
// A start from nearer would find the partners of the wrong side of thin things.
constexpr double kLeastRadiusM = 1.0;

RegistrationCloud cloudOf(const PoseSamples& samples) {
  OrientedPoints points;
  points.positions_m.reserve(samples.size());
  for (const Eigen::Vector3f& p : samples.positions_m) {
    points.positions_m.push_back(p.cast<double>());
  }
  points.normals = samples.normals;
  return RegistrationCloud(points);
}

double initialRadius(const RegistrationConfig& config, const Matrix6d& covariance) {
  const double variance = covariance.topLeftCorner<3, 3>().trace() +
                          kLeverM * kLeverM * covariance.bottomRightCorner<3, 3>().trace();
  const double least = std::max(kLeastRadiusM, config.final_radius_m);
  return std::min(config.initial_radius_m, std::max(least, kSigmas * std::sqrt(variance)));
}

/// The solver's twists have the rotation first.
Matrix6d translationFirst(const Matrix6d& covariance) {
  Matrix6d result;
  result << covariance.bottomRightCorner<3, 3>(), covariance.bottomLeftCorner<3, 3>(),
      covariance.topRightCorner<3, 3>(), covariance.topLeftCorner<3, 3>();
  return result;
}

RegistrationVerdict verdictOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kConverged:
      return RegistrationVerdict::kConverged;
    case Verdict::kDegenerate:
      return RegistrationVerdict::kDegenerate;
    case Verdict::kDiverged:
      break;
  }
  return RegistrationVerdict::kDiverged;
}

RegistrationOutcome registerSurfaces(RegistrationConfig config,
                                     const RegistrationRequest& request) {
  config.initial_radius_m = initialRadius(config, request.covariance);
  const RegistrationResult result = SurfaceRegistrar(config).align(
      cloudOf(*request.from), cloudOf(*request.to), request.T_from_to);
  RegistrationOutcome outcome;
  outcome.T_from_to = result.T_a_b;
  outcome.covariance = translationFirst(result.covariance);
  outcome.verdict = verdictOf(result.verdict);
  outcome.overlap = result.overlap;
  outcome.residual_m = result.residual_m;
  return outcome;
}

}  // namespace

RegistrationFunction surfaceRegistration(const RegistrationConfig& config) {
  const SurfaceRegistrar checked(config);  // throws now, not on a thread
  return [config](const RegistrationRequest& request) { return registerSurfaces(config, request); };
}

}  // namespace ladar_perception
