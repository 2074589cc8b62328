// SPDX-License-Identifier: BSD-3-Clause
#include "slam_report.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ladar_perception/slam/graph_covariance.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;

Json vectorJson(const Eigen::VectorXd& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

void putPose(const Eigen::Isometry3d& T, Json* json) {
  (*json)["position"] = vectorJson(T.translation());
  (*json)["orientation_xyzw"] = vectorJson(Eigen::Quaterniond(T.linear()).coeffs());
}

Json posesJson(const DelayedState& state) {
  std::vector<Matrix6d> covariances;
  try {
    covariances = GraphCovariance(state.graph()).marginals();
  } catch (const std::runtime_error&) {
    covariances.clear();  // odometry of unknown covariance: sigmas are left out
  }
  Json poses = Json::array();
  for (int i = 0; i < state.size(); ++i) {
    Json json;
    json["id"] = i;
    json["stamp_s"] = state.pose(i).stamp_s;
    putPose(state.graph().pose(i), &json);
    if (!covariances.empty()) {
      json["sigma"] =
          vectorJson(covariances[static_cast<std::size_t>(i)].diagonal().cwiseMax(0).cwiseSqrt());
    }
    poses.push_back(json);
  }
  return poses;
}

Json constraintJson(const PoseConstraint& constraint, const PoseGraph& graph) {
  Json json;
  json["from"] = constraint.from;
  json["to"] = constraint.to;
  json["kind"] = constraintKindName(constraint.kind);
  json["enabled"] = constraint.enabled;
  putPose(constraint.T_from_to, &json);
  Json upper = Json::array();
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) upper.push_back(constraint.information(i, j));
  }
  json["information_upper"] = upper;
  json["chi2"] = constraintChi2(constraint, graph.pose(constraint.from), graph.pose(constraint.to));
  return json;
}

Json oneError(const Trajectory& poses, const Trajectory& truth) {
  const TrajectoryError from_start = errorFromStart(poses, truth);
  const TrajectoryError aligned = errorAligned(poses, truth);
  return {{"rms_m", from_start.rms_m},
          {"max_m", from_start.max_m},
          {"aligned_rms_m", aligned.rms_m},
          {"aligned_max_m", aligned.max_m}};
}

}  // namespace

Json graphJson(const DelayedState& state) {
  Json json;
  json["about"] =
      "poses in the map frame; sigma: standard deviations of x y z (m), roll pitch yaw (rad) in "
      "the frame of the pose; transforms of constraints take `to` into `from`; information_upper: "
      "upper triangle by rows, same order";
  json["poses"] = posesJson(state);
  json["constraints"] = Json::array();
  for (const PoseConstraint& constraint : state.graph().constraints()) {
    json["constraints"].push_back(constraintJson(constraint, state.graph()));
  }
  return json;
}

Json countsJson(const DelayedState& state) {
  const ConstraintCounts& counts = state.counts();
  uint64_t odometry = 0;
  uint64_t retired = 0;
  for (const PoseConstraint& constraint : state.graph().constraints()) {
    odometry += constraint.kind == ConstraintKind::kOdometry ? 1 : 0;
    retired += constraint.enabled ? 0 : 1;
  }
  return {{"odometry", odometry},
          {"tried", counts.tried},
          {"accepted", counts.accepted},
          {"rejected", counts.rejected()},
          {"diverged", counts.diverged},
          {"low_overlap", counts.low_overlap},
          {"inconsistent", counts.inconsistent},
          {"unconfirmed", counts.unconfirmed},
          {"waiting", counts.waiting},
          {"retired", retired}};
}

Json percentilesJson(std::vector<double> values) {
  if (values.empty()) return Json::object();
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    return values[static_cast<std::size_t>(std::lround(place))];
  };
  return {{"p50", at(0.5)}, {"p95", at(0.95)}, {"max", values.back()}};
}

Json errorJson(const Trajectory& odometry, const Trajectory& estimate, const Trajectory& truth) {
  return {{"poses_with_truth", truth.size()},
          {"odometry", oneError(odometry, truth)},
          {"estimate", oneError(estimate, truth)}};
}

}  // namespace ladar_perception
