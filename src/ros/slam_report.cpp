// SPDX-License-Identifier: BSD-3-Clause
#include "slam_report.h"

#include <algorithm>
#include <cmath>
#include <fstream>
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

template <typename T>
void put(const T& value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
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

void writeMapCloud(const std::string& path, const DelayedState& state) {
  bool has_rgb = false;
  bool has_labels = false;
  std::size_t count = 0;
  for (int i = 0; i < state.size(); ++i) {
    const auto& samples = state.pose(i).samples;
    if (!samples) continue;
    count += samples->size();
    has_rgb = has_rgb || !samples->rgb.empty();
    has_labels = has_labels || !samples->labels.empty();
  }
  std::string bytes;
  for (int i = 0; i < state.size(); ++i) {
    const auto& samples = state.pose(i).samples;
    if (!samples) continue;
    const Eigen::Isometry3d& T = state.graph().pose(i);
    for (std::size_t k = 0; k < samples->size(); ++k) {
      const Eigen::Vector3f p = (T * samples->positions_m[k].cast<double>()).cast<float>();
      const Eigen::Vector3f n = T.linear().cast<float>() * samples->normals[k];
      for (const float value : {p.x(), p.y(), p.z(), n.x(), n.y(), n.z()}) put(value, &bytes);
      if (has_rgb) put(samples->rgb.empty() ? uint32_t{0} : samples->rgb[k], &bytes);
      if (has_labels) put(samples->labels.empty() ? uint8_t{0} : samples->labels[k], &bytes);
      put(static_cast<uint32_t>(i), &bytes);
    }
  }
  const auto field = [&](const char* with, bool is_there) {
    return std::string(is_there ? with : "");
  };
  std::ofstream file(path, std::ios::binary);
  file << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
       << "FIELDS x y z normal_x normal_y normal_z" << field(" rgb", has_rgb)
       << field(" label", has_labels) << " pose\nSIZE 4 4 4 4 4 4" << field(" 4", has_rgb)
       << field(" 1", has_labels) << " 4\nTYPE F F F F F F" << field(" U", has_rgb)
       << field(" U", has_labels) << " U\nCOUNT 1 1 1 1 1 1" << field(" 1", has_rgb)
       << field(" 1", has_labels) << " 1\nWIDTH " << count << "\nHEIGHT 1\n"
       << "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << count << "\nDATA binary\n"
       << bytes;
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace ladar_perception
