// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "ladar_perception/register/oriented_points.h"

namespace ladar_perception {

/// A pose's cloud with what registrations need of it, made once and used many times. Immutable, so
/// that threads may share it; copies share their contents.
class RegistrationCloud {
 public:
  /// `samples`: in farthest-first order, so that the first of them are a sampling, too (or in
  /// random order). `surface`: more points of the same surfaces, for the last stages, where this
  /// cloud is the one registered to, or where finish_points of it are; the samples themselves if
  /// it is empty. Both in the frame of the pose. Points that are not finite or have no normal are
  /// left out.
  explicit RegistrationCloud(const OrientedPoints& samples, const OrientedPoints& surface = {});

  /// Mean of the samples: clouds may be far from the origin of their frame.
  const Eigen::Vector3d& origin_m() const;
  /// Of the samples, from the origin, in their order.
  const std::vector<Eigen::Vector3f>& positions() const;
  const std::vector<Eigen::Vector3f>& normals() const;
  std::size_t size() const;
  /// Samples that were left out.
  std::size_t dropped() const;
  /// Median distance of samples to the next one; 0 if there are fewer than two.
  double spacing_m() const;

  struct Parts;  ///< of the room itself
  const Parts& parts() const { return *parts_; }

 private:
  std::shared_ptr<const Parts> parts_;
};

}  // namespace ladar_perception
