// SPDX-License-Identifier: BSD-3-Clause
#include "state_statistics.h"

#include <cmath>

#include "statistics_parts.h"

namespace ladar_perception {
namespace {

struct AddStage {
  const char* name;
  double AddReport::*milliseconds;
};

constexpr AddStage kAddStages[] = {
    {"search", &AddReport::search_ms},
    {"registration", &AddReport::registration_ms},
    {"optimization", &AddReport::optimization_ms},
    {"total", &AddReport::total_ms},
};

DropCount refused(const char* reason, uint64_t count) {
  DropCount message;
  message.reason = reason;
  message.count = count;
  return message;
}

void describeConstraints(const DelayedState& state, DelayedStateStatistics* message) {
  message->odometry_constraints = 0;
  message->registrations_retired = 0;
  for (const PoseConstraint& constraint : state.graph().constraints()) {
    message->odometry_constraints += constraint.kind == ConstraintKind::kOdometry ? 1 : 0;
    message->registrations_retired += constraint.enabled ? 0 : 1;
  }
  const ConstraintCounts& counts = state.counts();
  message->registrations_tried = counts.tried;
  message->registrations_accepted = counts.accepted;
  message->registrations_waiting = counts.waiting;
  message->registrations_refused = {
      refused("diverged", counts.diverged), refused("low_overlap", counts.low_overlap),
      refused("inconsistent", counts.inconsistent), refused("unconfirmed", counts.unconfirmed)};
}

}  // namespace

StateStatisticsLog::StateStatisticsLog(std::size_t window)
    : lag_ms_(window), stage_ms_(std::size(kAddStages), SampleWindow(window)) {}

uint64_t StateStatisticsLog::addArrival() {
  waiting_since_[received_] = ros::WallTime::now();
  return received_++;
}

void StateStatisticsLog::addDrop(uint64_t number, StateDrop reason) {
  ++dropped_[static_cast<int>(reason)];
  waiting_since_.erase(number);
}

void StateStatisticsLog::addPose(uint64_t number, const AddReport& report, uint64_t missing) {
  ++added_;
  missing_ += missing;
  loops_closed_ += report.closed_loop ? 1 : 0;
  lag_ms_.add((ros::WallTime::now() - waiting_since_[number]).toSec() * 1e3);
  waiting_since_.erase(number);
  for (std::size_t i = 0; i < stage_ms_.size(); ++i) {
    stage_ms_[i].add(report.*kAddStages[i].milliseconds);
  }
}

void StateStatisticsLog::addReset() {
  ++resets_;
  loops_closed_ = 0;
}

void StateStatisticsLog::addLoad() {
  ++loads_;
  loops_closed_ = 0;
}

void StateStatisticsLog::describe(const DelayedState& state) {
  state_.poses = static_cast<uint32_t>(state.size());
  state_.cloud_bytes = state.cloudBytes();
  state_.samples = 0;
  for (const StatePose& pose : state.poses()) {
    if (pose.samples) state_.samples += pose.samples->size();
  }
  describeConstraints(state, &state_);
  state_.correction_m = 0.0F;
  state_.correction_deg = 0.0F;
  if (state.size() == 0) return;
  const Eigen::Isometry3d& T_map_pose = state.graph().pose(state.size() - 1);
  const Eigen::Isometry3d& T_odom_pose = state.poses().back().T_odom_pose;
  state_.correction_m =
      static_cast<float>((T_map_pose.translation() - T_odom_pose.translation()).norm());
  state_.correction_deg =
      static_cast<float>(Eigen::Quaterniond(T_map_pose.linear())
                             .angularDistance(Eigen::Quaterniond(T_odom_pose.linear())) *
                         180.0 / M_PI);
}

uint64_t StateStatisticsLog::dropped() const { return sumOf(dropped_); }

DelayedStateStatistics StateStatisticsLog::message() const {
  DelayedStateStatistics message = state_;
  message.poses_received = received_;
  message.poses_added = added_;
  appendDrops(dropped_, stateDropName, &message.poses_dropped);
  message.poses_missing = missing_;
  message.poses_waiting = static_cast<uint32_t>(waiting_since_.size());
  if (!waiting_since_.empty()) {
    const ros::WallDuration waited = ros::WallTime::now() - waiting_since_.begin()->second;
    message.backlog_s = static_cast<float>(waited.toSec());
  }
  message.lag_p50_ms = static_cast<float>(lag_ms_.percentile(0.5));
  message.lag_p95_ms = static_cast<float>(lag_ms_.percentile(0.95));
  message.lag_p99_ms = static_cast<float>(lag_ms_.percentile(0.99));
  message.lag_max_ms = static_cast<float>(lag_ms_.max());
  for (std::size_t i = 0; i < stage_ms_.size(); ++i) {
    message.stages.push_back(stageTime(kAddStages[i].name, stage_ms_[i]));
  }
  message.resets = static_cast<uint32_t>(resets_);
  message.loads = static_cast<uint32_t>(loads_);
  message.saves = static_cast<uint32_t>(saves_);
  message.loops_closed = static_cast<uint32_t>(loops_closed_);
  return message;
}

void addTo(const DelayedStateStatistics& statistics,
           diagnostic_updater::DiagnosticStatusWrapper* status) {
  status->add("poses", statistics.poses);
  status->add("poses received", statistics.poses_received);
  status->add("poses waiting", statistics.poses_waiting);
  status->add("backlog (s)", statistics.backlog_s);
  addDrops("poses dropped", statistics.poses_dropped, status);
  status->add("poses missing", statistics.poses_missing);
  status->add("lag p50 (ms)", statistics.lag_p50_ms);
  status->add("lag p99 (ms)", statistics.lag_p99_ms);
  for (const StageTime& stage : statistics.stages) {
    status->add("adding: " + stage.stage + " p50 (ms)", stage.p50_ms);
  }
  status->add("registrations tried", statistics.registrations_tried);
  status->add("registrations accepted", statistics.registrations_accepted);
  addDrops("registrations refused", statistics.registrations_refused, status);
  status->add("registrations retired", statistics.registrations_retired);
  status->add("loops closed", statistics.loops_closed);
  status->add("clouds (MB)", static_cast<double>(statistics.cloud_bytes) * 1e-6);
  status->add("correction (m)", statistics.correction_m);
  status->add("correction (deg)", statistics.correction_deg);
  status->add("resets", statistics.resets);
}

}  // namespace ladar_perception
