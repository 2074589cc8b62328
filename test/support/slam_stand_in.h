// SPDX-License-Identifier: BSD-3-Clause
// A registration that knows the truth: clouds carry the index of their pose.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "ladar_perception/slam/delayed_state.h"
#include "slam_cases.h"

namespace ladar_perception::test {

/// Samples of pose `index`: the first says which pose it is.
inline std::shared_ptr<const PoseSamples> samplesOf(int index) {
  auto samples = std::make_shared<PoseSamples>();
  samples->positions_m = {Eigen::Vector3f(static_cast<float>(index), 0, 0), {1, 2, 3}};
  samples->normals = {{0, 0, 1}, {0, 1, 0}};
  samples->rgb = {0x102030, static_cast<uint32_t>(index)};
  samples->labels = {1, 3};
  return samples;
}

inline int indexOf(const PoseSamples& samples) {
  return static_cast<int>(samples.positions_m.at(0).x());
}

/// Changes what a registration of two poses says.
using SpoilOutcome = std::function<void(int from, int to, RegistrationOutcome*)>;

/// Says the truth with a little noise that depends on the pair alone. Overlap falls with distance.
inline RegistrationFunction standIn(const std::vector<Eigen::Isometry3d>& truth,
                                    const SpoilOutcome& spoil = {}) {
  return [truth, spoil](const RegistrationRequest& request) {
    const int from = indexOf(*request.from);
    const int to = indexOf(*request.to);
    TestRandom random(static_cast<uint64_t>(1000 * from + to));
    RegistrationOutcome outcome;
    const Eigen::Isometry3d T_from_to = truth[from].inverse(Eigen::Isometry) * truth[to];
    outcome.T_from_to = plus(T_from_to, normal6(&random, 0.005, 0.0005));
    outcome.covariance = diagonalCovariance(0.005, 0.0005);
    outcome.overlap = std::max(0.0, 1.0 - T_from_to.translation().norm() / 20.0);
    outcome.verdict = RegistrationVerdict::kConverged;
    if (spoil) spoil(from, to, &outcome);
    return outcome;
  };
}

/// Odometry that turns `drift_deg_per_m` too far and goes `scale` times as far.
inline std::vector<Eigen::Isometry3d> driftingOdometry(const std::vector<Eigen::Isometry3d>& truth,
                                                       double scale, double drift_deg_per_m) {
  std::vector<Eigen::Isometry3d> odometry = {truth.front()};
  for (std::size_t i = 1; i < truth.size(); ++i) {
    Eigen::Isometry3d step = truth[i - 1].inverse(Eigen::Isometry) * truth[i];
    const double distance_m = step.translation().norm();
    step.translation() *= scale;
    step.rotate(
        Eigen::AngleAxisd(distance_m * drift_deg_per_m * M_PI / 180.0, Eigen::Vector3d::UnitZ()));
    odometry.push_back(odometry.back() * step);
  }
  return odometry;
}

inline StatePose statePose(int index, const Eigen::Isometry3d& T_odom_pose) {
  return {100.0 + index, T_odom_pose, samplesOf(index), std::nullopt};
}

}  // namespace ladar_perception::test
