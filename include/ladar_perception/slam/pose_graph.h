// SPDX-License-Identifier: BSD-3-Clause
// The delayed state: every pose that was ever added, and the constraints between them.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/slam/pose_constraint.h"

namespace ladar_perception {

struct PoseGraphOptions {
  /// Registrations whose error is this many standard deviations pull with half their weight,
  /// farther ones with less (Cauchy's kernel).
  double robust_width = 3.0;
  /// Registrations whose squared Mahalanobis distance is greater after optimising everything have
  /// no effect any more, until they agree again; 22.46 leaves one right one of a thousand out.
  double retire_chi2 = 22.46;
  int max_iterations = 50;
};

/// What an optimisation did.
struct OptimizeReport {
  int poses = 0;  ///< that could move
  int constraints = 0;
  int iterations = 0;
  int64_t residual_evaluations = 0;  ///< of single constraints
  double initial_cost = 0.0;         ///< half the sum of squared Mahalanobis distances, robust
  double final_cost = 0.0;
  bool converged = true;
  int retired = 0;  ///< constraints without effect afterwards (after optimising everything)
};

/// What is known of a pose relative to the root of a tree, by the constraints along one path only.
struct TreeNode {
  int parent = -1;  ///< -1 for the root and for what no constraint connects with it
  int hops = -1;    ///< constraints on the path, -1 if there is none
  /// Of T_root_pose. Never less than that by all constraints.
  Matrix6d covariance = Matrix6d::Zero();
};

/// Poses in the map frame, optimised by Ceres (Levenberg-Marquardt, sparse Cholesky, one thread, so
/// that results are the same bits on every run). Pose 0 never moves: it is the map.
class PoseGraph {
 public:
  explicit PoseGraph(const PoseGraphOptions& options = {}) : options_(options) {}

  /// Returns its index, the number of poses before.
  int addPose(const Eigen::Isometry3d& T_map_pose);
  /// Returns its index. Throws std::invalid_argument for ends that do not exist and for what
  /// constraintError() finds.
  int addConstraint(const PoseConstraint& constraint);

  int size() const { return static_cast<int>(T_map_poses_.size()); }
  const PoseGraphOptions& options() const { return options_; }
  const Eigen::Isometry3d& pose(int index) const { return T_map_poses_.at(index); }
  Eigen::Isometry3d relative(int from, int to) const {
    return pose(from).inverse(Eigen::Isometry) * pose(to);
  }
  const std::vector<PoseConstraint>& constraints() const { return constraints_; }
  /// Indices of the constraints that end at a pose, in the order they were added.
  const std::vector<int>& constraintsAt(int pose) const { return constraints_at_.at(pose); }
  /// Weight of a constraint at the present estimate: 1, less if it is far off, 0 if retired.
  double robustWeight(const PoseConstraint& constraint) const;

  /// Moves every pose, then retires registrations that contradict the rest, or takes them back, and
  /// repeats. Time is proportional to the number of poses.
  OptimizeReport optimize();
  /// Moves the `window` poses that the fewest constraints separate from `seeds` and holds all
  /// others, so that time does not grow with the number of poses.
  OptimizeReport optimizeAround(const std::vector<int>& seeds, int window);
  /// Those poses, without pose 0, nearest first.
  std::vector<int> around(const std::vector<int>& seeds, int window) const;

  /// The paths of least uncertainty from `root` to every pose, found greedily. About a microsecond
  /// a constraint.
  std::vector<TreeNode> treeFrom(int root) const;

  /// Marks a constraint as retired or not, as a saved state has it.
  void setEnabled(int constraint, bool enabled) { constraints_.at(constraint).enabled = enabled; }

 private:
  OptimizeReport solve(const std::vector<int>& free);
  /// The node of a pose that a constraint connects with a pose of the tree.
  void extendTree(int constraint, int pose, std::vector<TreeNode>* tree) const;
  /// How many constraints changed between retired and not.
  int reviewRegistrations();

  PoseGraphOptions options_;
  std::vector<Eigen::Isometry3d> T_map_poses_;
  std::vector<PoseConstraint> constraints_;
  /// Of a constraint, in the frames of its two ends.
  struct Step {
    Matrix6d forward;   // of T_from_to
    Matrix6d backward;  // of T_to_from
    double length = 0.0;
  };
  std::vector<Step> steps_;  // as many as constraints
  std::vector<std::vector<int>> constraints_at_;
};

}  // namespace ladar_perception
