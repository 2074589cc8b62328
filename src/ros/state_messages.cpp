// SPDX-License-Identifier: BSD-3-Clause
#include "state_messages.h"

#include <boost/make_shared.hpp>
#include <cstdlib>
#include <stdexcept>

#include "cloud_message.h"
#include "ladar_perception/slam/graph_covariance.h"
#include "map_cloud.h"
#include "pose_cloud_message.h"

namespace ladar_perception {
namespace {

constexpr double kBallSize_m = 0.35;
constexpr double kLineWidth_m = 0.08;

ros::Time stampOf(const StatePose& pose) { return ros::Time(pose.stamp_s); }

/// Of a perturbation in the frame of the pose, to one about axes of the map.
Matrix6d inMapAxes(const Eigen::Isometry3d& T_map_pose, const Matrix6d& covariance) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = T_map_pose.linear();
  turn.bottomRightCorner<3, 3>() = T_map_pose.linear();
  return turn * covariance * turn.transpose();
}

/// Covariances of all poses; none where constraints do not determine them.
std::vector<Matrix6d> covariancesOf(const PoseGraph& graph) {
  if (graph.size() == 0) return {};
  try {
    return GraphCovariance(graph).marginals();
  } catch (const std::runtime_error&) {
    return {};
  }
}

template <typename Values>
void putRows(const Matrix6d& matrix, Values* values) {
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) (*values)[6 * row + col] = matrix(row, col);
  }
}

GraphConstraint constraintMessage(const PoseConstraint& constraint, const PoseGraph& graph) {
  GraphConstraint message;
  message.kind = constraint.kind == ConstraintKind::kOdometry ? GraphConstraint::ODOMETRY
                                                              : GraphConstraint::REGISTRATION;
  message.from = static_cast<uint32_t>(constraint.from);
  message.to = static_cast<uint32_t>(constraint.to);
  message.transform = transformMessage(constraint.T_from_to);
  putRows(constraint.information, &message.information);
  message.enabled = constraint.enabled;
  message.chi2 = constraintChi2(constraint, graph.pose(constraint.from), graph.pose(constraint.to));
  return message;
}

std_msgs::ColorRGBA color(float r, float g, float b, float a) {
  std_msgs::ColorRGBA message;
  message.r = r;
  message.g = g;
  message.b = b;
  message.a = a;
  return message;
}

visualization_msgs::Marker marker(const StateSnapshot& state, const char* name, int32_t type,
                                  double size_m, const std_msgs::ColorRGBA& rgba) {
  visualization_msgs::Marker message;
  message.header.frame_id = state.header.frame_id;  // stamp 0: the map does not move
  message.ns = name;
  message.type = type;
  message.pose.orientation.w = 1.0;
  message.scale.x = size_m;
  message.scale.y = size_m;
  message.scale.z = size_m;
  message.color = rgba;
  return message;
}

const char* lineName(const PoseConstraint& constraint, int loop_hops) {
  if (constraint.kind == ConstraintKind::kOdometry) return "odometry";
  if (!constraint.enabled) return "retired";
  return std::abs(constraint.to - constraint.from) < loop_hops ? "registrations" : "loops";
}

}  // namespace

nav_msgs::PathPtr makePath(const StateSnapshot& state) {
  auto path = boost::make_shared<nav_msgs::Path>();
  path->header = state.header;
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = stampOf(state.poses[i]);
    pose.header.frame_id = state.header.frame_id;
    pose.pose = poseMessage(state.graph.pose(static_cast<int>(i)));
    path->poses.push_back(pose);
  }
  return path;
}

StateGraphPtr makeStateGraph(const StateSnapshot& state) {
  auto message = boost::make_shared<StateGraph>();
  message->header = state.header;
  message->odom_frame = state.odom_frame;
  message->vehicle_frame = state.vehicle_frame;
  const std::vector<Matrix6d> covariances = covariancesOf(state.graph);
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    const Eigen::Isometry3d& T_map_pose = state.graph.pose(static_cast<int>(i));
    GraphPose pose;
    pose.stamp = stampOf(state.poses[i]);
    pose.pose.pose = poseMessage(T_map_pose);
    if (!covariances.empty()) putRows(inMapAxes(T_map_pose, covariances[i]), &pose.pose.covariance);
    pose.odometry = poseMessage(state.poses[i].T_odom_pose);
    if (state.poses[i].samples) {
      pose.samples = static_cast<uint32_t>(state.poses[i].samples->size());
    }
    message->poses.push_back(pose);
  }
  for (const PoseConstraint& constraint : state.graph.constraints()) {
    message->constraints.push_back(constraintMessage(constraint, state.graph));
  }
  return message;
}

visualization_msgs::MarkerArrayPtr makeGraphMarkers(const StateSnapshot& state, int loop_hops) {
  using visualization_msgs::Marker;
  auto message = boost::make_shared<visualization_msgs::MarkerArray>();
  auto& markers = message->markers;
  markers.push_back(
      marker(state, "poses", Marker::SPHERE_LIST, kBallSize_m, color(0.3F, 0.6F, 1.0F, 1.0F)));
  markers.push_back(
      marker(state, "odometry", Marker::LINE_LIST, kLineWidth_m, color(0.7F, 0.7F, 0.7F, 0.8F)));
  markers.push_back(marker(state, "registrations", Marker::LINE_LIST, kLineWidth_m,
                           color(0.2F, 0.9F, 0.3F, 0.8F)));
  markers.push_back(marker(state, "loops", Marker::LINE_LIST, 2.0 * kLineWidth_m,
                           color(1.0F, 0.85F, 0.1F, 1.0F)));
  markers.push_back(
      marker(state, "retired", Marker::LINE_LIST, kLineWidth_m, color(1.0F, 0.2F, 0.2F, 1.0F)));
  for (int i = 0; i < state.graph.size(); ++i) {
    markers[0].points.push_back(poseMessage(state.graph.pose(i)).position);
  }
  for (const PoseConstraint& constraint : state.graph.constraints()) {
    const std::string name = lineName(constraint, loop_hops);
    for (Marker& lines : markers) {
      if (lines.ns != name) continue;
      lines.points.push_back(poseMessage(state.graph.pose(constraint.from)).position);
      lines.points.push_back(poseMessage(state.graph.pose(constraint.to)).position);
    }
  }
  // rviz complains of lists without points.
  for (Marker& list : markers) {
    if (list.points.empty()) list.action = Marker::DELETE;
  }
  return message;
}

sensor_msgs::PointCloud2Ptr makeMapCloudMessage(const StateSnapshot& state,
                                                std::size_t samples_per_pose) {
  auto message = boost::make_shared<sensor_msgs::PointCloud2>();
  MapCloud cloud = makeMapCloud(state.poses, state.graph, samples_per_pose);
  message->header = state.header;
  setLayout(cloud.layout, message.get());
  message->data = std::move(cloud.bytes);
  message->is_dense = true;
  return message;
}

}  // namespace ladar_perception
