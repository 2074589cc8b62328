// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/delayed_state.h"

#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "state_file.h"

namespace ladar_perception {
namespace {

// Candidates are no neighbours of each other: these would tell the same.
constexpr int kCandidateGap = 3;
// A registration between poses that are known this well already would tell nothing: the entropy
// that it takes away, in nats, of six degrees of freedom.
constexpr double kLeastGain = 2.0;

using Clock = std::chrono::steady_clock;

double msSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// What a measurement with this information takes away of the entropy of an estimate.
double informationGain(const Matrix6d& covariance, const Matrix6d& information) {
  const Matrix6d ratio = Matrix6d::Identity() + covariance * information;
  return std::log(std::max(ratio.determinant(), 1.0));
}

PoseGraphOptions graphOptions(const DelayedStateConfig& config) {
  PoseGraphOptions options;
  options.robust_width = config.robust_width;
  options.retire_chi2 = config.gate_chi2;
  return options;
}

PoseConstraint constraintOf(const Candidate& candidate, const Eigen::Isometry3d& T_from_to,
                            const Matrix6d& covariance) {
  PoseConstraint constraint;
  constraint.from = candidate.from;
  constraint.to = candidate.to;
  constraint.T_from_to = T_from_to;
  constraint.information = invertSymmetric(covariance);
  constraint.information =
      (0.5 * (constraint.information + constraint.information.transpose())).eval();
  constraint.kind = ConstraintKind::kRegistration;
  return constraint;
}

}  // namespace

DelayedState::DelayedState(const DelayedStateConfig& config, RegistrationFunction registration)
    : config_(config), registration_(std::move(registration)), graph_(graphOptions(config)) {
  std::string report;
  for (const std::string& violation : config.validate()) {
    report += (report.empty() ? "" : "\n") + violation;
  }
  if (!report.empty()) throw std::invalid_argument(report);
  if (!registration_) throw std::invalid_argument("there is no registration");
  threads_ = std::make_unique<ThreadPool>(config.threads);
}

PoseConstraint DelayedState::stepTo(const StatePose& pose) const {
  PoseConstraint step;
  step.from = size() - 1;
  step.to = size();
  const Eigen::Isometry3d T_odom_before =
      size() > 0 ? poses_.back().T_odom_pose : Eigen::Isometry3d::Identity();
  step.T_from_to = T_odom_before.inverse(Eigen::Isometry) * pose.T_odom_pose;
  const Matrix6d covariance =
      pose.step_covariance.value_or(config_.odometryCovariance(step.T_from_to));
  if (covariance.allFinite()) step.information = invertSymmetric(covariance);
  std::string error = constraintError(step);
  if (!covariance.allFinite()) error = "the covariance is not finite";
  if (!std::isfinite(pose.stamp_s) || (size() > 0 && pose.stamp_s <= poses_.back().stamp_s)) {
    error = "the stamp " + std::to_string(pose.stamp_s) + " is not after the one before";
  }
  if (pose.samples && pose.samples->normals.size() != pose.samples->size()) {
    error = "the samples have no normals";
  }
  if (!error.empty()) throw std::invalid_argument("pose " + std::to_string(size()) + ": " + error);
  return step;
}

AddReport DelayedState::add(const StatePose& pose) {
  const auto begin = Clock::now();
  const PoseConstraint step = stepTo(pose);
  AddReport report;
  if (size() == 0) {
    graph_.addPose(pose.T_odom_pose);
    poses_.push_back(pose);
    return report;
  }
  report.pose = graph_.addPose(graph_.pose(step.from) * step.T_from_to);
  graph_.addConstraint(step);
  poses_.push_back(pose);

  dropOldWaiting();
  // The pose before first: it makes the guesses for all others better. The new pose alone moves.
  int hops = tryCandidates({{step.from, step.to, invertSymmetric(step.information), 1}}, &report);
  if (hops > 0) {
    report.residual_evaluations += graph_.optimizeAround({report.pose}, 1).residual_evaluations;
  }
  const auto search_begin = Clock::now();
  const std::vector<Candidate> found = candidates(report.pose);
  report.search_ms = msSince(search_begin);
  hops = std::max(hops, tryCandidates(found, &report));
  if (hops > 0) optimizeAfter(hops, &report);
  report.total_ms = msSince(begin);
  return report;
}

OptimizeReport DelayedState::optimize() { return graph_.optimize(); }

void DelayedState::reset() {
  poses_.clear();
  waiting_.clear();
  counts_ = {};
  graph_ = PoseGraph(graphOptions(config_));
}

Eigen::Isometry3d DelayedState::T_map_odom() const {
  if (size() == 0) return Eigen::Isometry3d::Identity();
  return graph_.pose(size() - 1) * poses_.back().T_odom_pose.inverse(Eigen::Isometry);
}

std::size_t DelayedState::cloudBytes() const {
  std::size_t bytes = 0;
  for (const StatePose& pose : poses_) {
    if (!pose.samples) continue;
    bytes += pose.samples->positions_m.size() * sizeof(Eigen::Vector3f) +
             pose.samples->normals.size() * sizeof(Eigen::Vector3f) +
             pose.samples->rgb.size() * sizeof(uint32_t) + pose.samples->labels.size();
  }
  return bytes;
}

std::vector<Candidate> DelayedState::candidates(int pose) const {
  struct Scored {
    double score;
    Candidate candidate;
  };
  const std::vector<TreeNode> tree = graph_.treeFrom(pose);
  const Matrix6d information = config_.registrationFloor().inverse();
  const double overlap_m = config_.overlap_distance_m;
  std::vector<Scored> scored;
  // The pose before has been tried already.
  for (int i = 0; i + 1 < pose; ++i) {
    const double distance_m =
        (graph_.pose(i).translation() - graph_.pose(pose).translation()).norm();
    const double variance = tree[i].covariance.topLeftCorner<3, 3>().trace();
    if (tree[i].hops < 0) continue;
    if (distance_m - config_.search_sigmas * std::sqrt(variance) > overlap_m) continue;
    const double gain = informationGain(tree[i].covariance, information);
    if (gain < kLeastGain) continue;
    // The chance of an overlap falls with the distance, the slower the less is known of it.
    const double chance = std::exp(-distance_m * distance_m / (overlap_m * overlap_m + variance));
    Candidate candidate{i, pose, invertedCovariance(graph_.relative(pose, i), tree[i].covariance),
                        tree[i].hops};
    scored.push_back({gain * chance, candidate});
  }
  std::stable_sort(scored.begin(), scored.end(),
                   [](const Scored& a, const Scored& b) { return a.score > b.score; });
  std::vector<Candidate> chosen;
  for (const Scored& entry : scored) {
    if (static_cast<int>(chosen.size()) >= config_.max_candidates) break;
    const bool is_free = std::all_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
      return std::abs(other.from - entry.candidate.from) >= kCandidateGap;
    });
    if (is_free) chosen.push_back(entry.candidate);
  }
  return chosen;
}

std::vector<RegistrationOutcome> DelayedState::registerAll(const std::vector<Candidate>& candidates,
                                                           AddReport* report) {
  const auto begin = Clock::now();
  std::vector<RegistrationOutcome> outcomes(candidates.size());
  std::atomic<std::size_t> next{0};
  threads_->run([&](int) {
    for (std::size_t i = next++; i < candidates.size(); i = next++) {
      const Candidate& candidate = candidates[i];
      RegistrationRequest request;
      request.from = poses_[candidate.from].samples;
      request.to = poses_[candidate.to].samples;
      request.T_from_to = graph_.relative(candidate.from, candidate.to);
      request.covariance = candidate.covariance;
      outcomes[i] = registration_(request);
    }
  });
  report->registration_ms += msSince(begin);
  return outcomes;
}

int DelayedState::tryCandidates(const std::vector<Candidate>& candidates, AddReport* report) {
  const auto hasSamples = [&](int pose) {
    return poses_[pose].samples && poses_[pose].samples->size() > 0;
  };
  std::vector<Candidate> possible;
  for (const Candidate& candidate : candidates) {
    if (hasSamples(candidate.from) && hasSamples(candidate.to)) possible.push_back(candidate);
  }
  const std::vector<RegistrationOutcome> outcomes = registerAll(possible, report);
  int hops = 0;
  // In their order, not in that in which threads end. Nothing moves until all are judged.
  for (std::size_t i = 0; i < possible.size(); ++i) {
    hops = std::max(hops, judge(possible[i], outcomes[i], report));
  }
  return hops;
}

int DelayedState::judge(const Candidate& candidate, const RegistrationOutcome& outcome,
                        AddReport* report) {
  ++counts_.tried;
  ++report->tried;
  if (outcome.verdict == RegistrationVerdict::kDiverged || !outcome.covariance.allFinite() ||
      !outcome.T_from_to.matrix().allFinite()) {
    ++counts_.diverged;
    return 0;
  }
  if (outcome.overlap < config_.accept_overlap) {
    ++counts_.low_overlap;
    return 0;
  }
  const Matrix6d covariance = outcome.covariance + config_.registrationFloor();
  // Along what it does not see, a registration slides anywhere, and what it does see is then right
  // for that place only. So its large variances are no excuse there: it must end near the estimate.
  const bool is_degenerate = outcome.verdict == RegistrationVerdict::kDegenerate;
  const double chi2 =
      innovationChi2(outcome.T_from_to, is_degenerate ? config_.registrationFloor() : covariance,
                     graph_.relative(candidate.from, candidate.to), candidate.covariance);
  if (!(chi2 <= config_.gate_chi2)) {
    ++counts_.inconsistent;
    return 0;
  }
  const PoseConstraint constraint = constraintOf(candidate, outcome.T_from_to, covariance);
  if (candidate.hops == 1 || positionSigma(candidate.covariance) <= config_.confirm_sigma_m) {
    accept(constraint, report);
    return candidate.hops;
  }
  const int confirming = findConfirming(constraint);
  if (confirming < 0) {
    waiting_.push_back({constraint, candidate.hops});
    ++counts_.waiting;
    return 0;
  }
  const Waiting other = waiting_[confirming];
  waiting_.erase(waiting_.begin() + confirming);
  --counts_.waiting;
  accept(other.constraint, report);
  accept(constraint, report);
  return std::max(candidate.hops, other.hops);
}

int DelayedState::findConfirming(const PoseConstraint& constraint) const {
  if (waiting_.empty()) return -1;
  const std::vector<TreeNode> around_from = graph_.treeFrom(constraint.from);
  const std::vector<TreeNode> around_to = graph_.treeFrom(constraint.to);
  const Matrix6d covariance = invertSymmetric(constraint.information);
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const PoseConstraint& other = waiting_[i].constraint;
    // Two registrations of one cloud may be wrong in the same way.
    if (other.to == constraint.to) continue;
    // The same relative pose by way of the other: from -> other.from -> other.to -> to.
    const Eigen::Isometry3d T_other_to_to = graph_.relative(other.to, constraint.to);
    const Matrix6d last = invertedCovariance(graph_.relative(constraint.to, other.to),
                                             around_to[other.to].covariance);
    Matrix6d by_way = composedCovariance(around_from[other.from].covariance, other.T_from_to,
                                         invertSymmetric(other.information));
    by_way = composedCovariance(by_way, T_other_to_to, last);
    const Eigen::Isometry3d T_by_way =
        graph_.relative(constraint.from, other.from) * other.T_from_to * T_other_to_to;
    if (innovationChi2(constraint.T_from_to, covariance, T_by_way, by_way) <= config_.gate_chi2) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

void DelayedState::accept(const PoseConstraint& constraint, AddReport* report) {
  graph_.addConstraint(constraint);
  ++counts_.accepted;
  ++report->accepted;
}

void DelayedState::dropOldWaiting() {
  const int oldest = size() - 1 - config_.confirm_poses;
  const auto kept = std::remove_if(waiting_.begin(), waiting_.end(), [&](const Waiting& waiting) {
    return waiting.constraint.to < oldest;
  });
  const auto dropped = static_cast<uint64_t>(std::distance(kept, waiting_.end()));
  counts_.unconfirmed += dropped;
  counts_.waiting -= dropped;
  waiting_.erase(kept, waiting_.end());
}

void DelayedState::optimizeAfter(int hops, AddReport* report) {
  const auto begin = Clock::now();
  const bool closes_loop = hops >= config_.loop_hops;
  if (closes_loop || moveWindow(report->pose, report)) {
    report->residual_evaluations += graph_.optimize().residual_evaluations;
    report->optimized_everything = true;
  }
  report->closed_loop = report->closed_loop || closes_loop;
  report->optimization_ms += msSince(begin);
}

/// Optimises around the pose; true if an earlier one moved so far that others should, too.
bool DelayedState::moveWindow(int pose, AddReport* report) {
  const std::vector<int> window = graph_.around({pose}, config_.window_poses);
  std::vector<Eigen::Vector3d> before;
  for (const int index : window) before.push_back(graph_.pose(index).translation());
  report->residual_evaluations +=
      graph_.optimizeAround({pose}, config_.window_poses).residual_evaluations;
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    if (window[i] == pose) continue;
    farthest_m = std::max(farthest_m, (graph_.pose(window[i]).translation() - before[i]).norm());
  }
  return farthest_m > config_.full_update_m;
}

void DelayedState::save(const std::string& path) const {
  StateContents contents{poses_, graph_, {}, counts_};
  for (const Waiting& waiting : waiting_) {
    contents.waiting.emplace_back(waiting.constraint, waiting.hops);
  }
  writeStateFile(path, contents);
}

void DelayedState::load(const std::string& path) {
  StateContents contents = readStateFile(path, graphOptions(config_));
  poses_ = std::move(contents.poses);
  graph_ = std::move(contents.graph);
  counts_ = contents.counts;
  waiting_.clear();
  for (const auto& [constraint, hops] : contents.waiting) waiting_.push_back({constraint, hops});
}

}  // namespace ladar_perception
