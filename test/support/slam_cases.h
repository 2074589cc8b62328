// SPDX-License-Identifier: BSD-3-Clause
// Poses, noise and drives for the tests of the delayed-state estimate.
#pragma once

#include <cmath>
#include <vector>

#include "ladar_perception/slam/pose_graph.h"
#include "test_random.h"

namespace ladar_perception::test {

inline Vector6d normal6(TestRandom* random, double sigma_m, double sigma_rad) {
  Vector6d d;
  d.head<3>() = sigma_m * random->normal3();
  d.tail<3>() = sigma_rad * random->normal3();
  return d;
}

inline Eigen::Isometry3d randomPose(TestRandom* random, double size_m, double angle_rad) {
  return plus(Eigen::Isometry3d::Identity(), normal6(random, size_m, angle_rad));
}

/// A positive definite matrix with eigenvalues of different sizes.
inline Matrix6d randomCovariance(TestRandom* random, double sigma) {
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i) = random->normal();
  return sigma * sigma * (A * A.transpose() / 6.0 + 0.1 * Matrix6d::Identity());
}

inline PoseConstraint makeConstraint(int from, int to, const Eigen::Isometry3d& T_from_to,
                                     const Matrix6d& covariance, ConstraintKind kind) {
  PoseConstraint constraint;
  constraint.from = from;
  constraint.to = to;
  constraint.T_from_to = T_from_to;
  constraint.information = covariance.inverse();
  constraint.information =
      (0.5 * (constraint.information + constraint.information.transpose())).eval();
  constraint.kind = kind;
  return constraint;
}

/// Poses `step_m` apart around a square of `side` steps, `laps` times, x forward.
inline std::vector<Eigen::Isometry3d> squareDrive(int side, int laps, double step_m) {
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 4 * side * laps; ++i) {
    poses.push_back(T);
    T.translate(Eigen::Vector3d(step_m, 0, 0));
    if ((i + 1) % side == 0) T.rotate(Eigen::AngleAxisd(M_PI_2, Eigen::Vector3d::UnitZ()));
  }
  return poses;
}

inline double rmsPositionError(const PoseGraph& graph,
                               const std::vector<Eigen::Isometry3d>& truth) {
  double sum = 0.0;
  for (int i = 0; i < graph.size(); ++i) {
    sum += (graph.pose(i).translation() - truth[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / graph.size());
}

/// Adds the drive's poses, each where the noisy step from the one before leads to.
inline void addDrive(const std::vector<Eigen::Isometry3d>& truth, double sigma_m, double sigma_rad,
                     TestRandom* random, PoseGraph* graph) {
  graph->addPose(truth.front());
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Eigen::Isometry3d step =
        plus(truth[i - 1].inverse(Eigen::Isometry) * truth[i], normal6(random, sigma_m, sigma_rad));
    const auto to = static_cast<int>(i);
    graph->addPose(graph->pose(to - 1) * step);
    graph->addConstraint(makeConstraint(to - 1, to, step, diagonalCovariance(sigma_m, sigma_rad),
                                        ConstraintKind::kOdometry));
  }
}

}  // namespace ladar_perception::test
