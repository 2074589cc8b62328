// SPDX-License-Identifier: BSD-3-Clause
// What the delayed-state estimate asks of a registration.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "ladar_perception/slam/se3.h"

namespace ladar_perception {

/// The re-sampled cloud of a pose, in the frame of the pose. Arrays are as long as `positions_m`,
/// or empty where there is no such field (never `normals`).
struct PoseSamples {
  std::vector<Eigen::Vector3f> positions_m;  ///< farthest first
  std::vector<Eigen::Vector3f> normals;      ///< unit, towards the sensor; zero: no surface
  std::vector<uint32_t> rgb;                 ///< 0x00RRGGBB
  std::vector<uint8_t> labels;               ///< 0 unknown, else 1 + index of the class

  std::size_t size() const { return positions_m.size(); }
};

/// Two clouds and what is known of where they are to each other.
struct RegistrationRequest {
  std::shared_ptr<const PoseSamples> from;
  std::shared_ptr<const PoseSamples> to;
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of `T_from_to`
};

enum class RegistrationVerdict : uint8_t {
  kConverged,
  kDegenerate,  ///< laid on, but some direction is not determined: its variance is large
  kDiverged,    ///< the transform means nothing
};

struct RegistrationOutcome {
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();
  RegistrationVerdict verdict = RegistrationVerdict::kDiverged;
  double overlap = 0.0;  ///< share of the samples of `to` that found a partner
  double residual_m = 0.0;
};

/// Called by several threads at the same time; must not throw, and must give the same for the same.
using RegistrationFunction = std::function<RegistrationOutcome(const RegistrationRequest&)>;

}  // namespace ladar_perception
