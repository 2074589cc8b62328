// SPDX-License-Identifier: BSD-3-Clause
// The estimate that all poses are kept in: a new pose is registered to earlier ones that its cloud
// may overlap, and what agrees with the estimate becomes a constraint.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ladar_perception/slam/delayed_state_config.h"
#include "ladar_perception/slam/pose_graph.h"
#include "ladar_perception/slam/registration_function.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// What is kept of a pose besides its estimate.
struct StatePose {
  double stamp_s = 0.0;
  Eigen::Isometry3d T_odom_pose = Eigen::Isometry3d::Identity();
  std::shared_ptr<const PoseSamples> samples;
  /// Covariance of the odometry's step from the pose before; the configuration's if it is not
  /// known.
  std::optional<Matrix6d> step_covariance;
};

/// What became of registrations. A waiting one is counted when it is decided.
struct ConstraintCounts {
  uint64_t tried = 0;
  uint64_t accepted = 0;
  uint64_t diverged = 0;  ///< by the registration's own verdict
  uint64_t low_overlap = 0;
  uint64_t inconsistent = 0;  ///< with the estimate, under both covariances
  uint64_t unconfirmed = 0;   ///< no other agreed in time
  uint64_t waiting = 0;

  uint64_t rejected() const { return diverged + low_overlap + inconsistent + unconfirmed; }
};

/// What adding a pose did.
struct AddReport {
  int pose = 0;
  int tried = 0;
  int accepted = 0;
  bool closed_loop = false;
  bool optimized_everything = false;
  int64_t residual_evaluations = 0;
  double search_ms = 0.0;
  double registration_ms = 0.0;
  double optimization_ms = 0.0;
  double total_ms = 0.0;
};

/// A pair of poses that a registration may constrain.
struct Candidate {
  int from = 0;
  int to = 0;
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_from_to, by the path of least uncertainty
  int hops = 0;                            ///< constraints on this path
};

/// Not thread-safe; registrations run on its own threads. Results are the same bits for any number
/// of them.
class DelayedState {
 public:
  /// Throws std::invalid_argument with every violation of `config`, or if there is no function.
  DelayedState(const DelayedStateConfig& config, RegistrationFunction registration);

  /// Adds a pose: predicts it by the odometry, registers it to the pose before, then to those
  /// earlier ones that tell most, and optimises. The first pose is where the odometry says. Throws
  /// std::invalid_argument for a stamp that is not after the one before, or a pose that is not
  /// finite.
  AddReport add(const StatePose& pose);
  /// Optimises everything, as at the end of a drive.
  OptimizeReport optimize();
  /// Forgets everything.
  void reset();

  int size() const { return graph_.size(); }
  const StatePose& pose(int index) const { return poses_.at(index); }
  const std::vector<StatePose>& poses() const { return poses_; }
  const PoseGraph& graph() const { return graph_; }
  const ConstraintCounts& counts() const { return counts_; }
  const DelayedStateConfig& config() const { return config_; }
  /// Corrects the odometry: by the newest pose; identity if there is none.
  Eigen::Isometry3d T_map_odom() const;
  /// Earlier poses that a pose may overlap, those that a registration would tell most of first.
  std::vector<Candidate> candidates(int pose) const;
  /// Bytes of the poses' clouds.
  std::size_t cloudBytes() const;

  /// Writes poses, clouds, constraints and what waits for confirmation to one file (state_file.h).
  /// Throws std::runtime_error that names the path if it cannot; then no file is left half written.
  void save(const std::string& path) const;
  /// Replaces everything by what save() wrote: what is added afterwards gives the same bits as if
  /// there had been no break. Throws std::runtime_error that says what is wrong with the file, and
  /// changes nothing then.
  void load(const std::string& path);

 private:
  /// Accepted by the gate, but the gate was wide.
  struct Waiting {
    PoseConstraint constraint;
    int hops = 0;
  };

  /// The odometry's constraint; throws as add() does.
  PoseConstraint stepTo(const StatePose& pose) const;
  std::vector<RegistrationOutcome> registerAll(const std::vector<Candidate>& candidates,
                                               AddReport* report);
  /// Registers and judges. Returns the most hops that an accepted constraint spans, 0 if there is
  /// none.
  int tryCandidates(const std::vector<Candidate>& candidates, AddReport* report);
  /// Accepts, refuses or sets aside. Returns the hops as tryCandidates() does.
  int judge(const Candidate& candidate, const RegistrationOutcome& outcome, AddReport* report);
  /// Index of a waiting constraint that agrees with this one, -1 if there is none.
  int findConfirming(const PoseConstraint& constraint) const;
  void accept(const PoseConstraint& constraint, AddReport* report);
  void dropOldWaiting();
  void optimizeAfter(int hops, AddReport* report);
  bool moveWindow(int pose, AddReport* report);

  DelayedStateConfig config_;
  RegistrationFunction registration_;
  std::unique_ptr<ThreadPool> threads_;
  std::vector<StatePose> poses_;
  PoseGraph graph_;
  std::vector<Waiting> waiting_;
  ConstraintCounts counts_;
};

}  // namespace ladar_perception
