// SPDX-License-Identifier: BSD-3-Clause
#include "pose_cloud_reader.h"

#include <cmath>
#include <memory>
#include <vector>

#include "cloud_message.h"
#include "ladar_perception/cloud/labeled_cloud.h"
#include "ladar_perception/cloud/point_reader.h"

namespace ladar_perception {
namespace {

// Farther out no ladar sees; such positions come of bytes that are read as what they are not.
constexpr double kMaxRange_m = 1e5;
constexpr double kQuaternionTolerance = 1e-3;

using Column = std::vector<double>;

/// One component of positions or normals. False, with `detail`, if a value is not finite or greater
/// than the limit.
bool readComponent(const CloudView& cloud, const Field& field, double limit, Column* values,
                   std::string* detail) {
  readScalars(cloud, field, values);
  for (std::size_t i = 0; i < values->size(); ++i) {
    const double value = (*values)[i];
    if (std::abs(value) <= limit) continue;
    *detail = "field '" + field.name + "' of sample " + std::to_string(i) + " is " +
              std::to_string(value) + ", expected a finite number up to " +
              std::to_string(std::lround(limit));
    return false;
  }
  return true;
}

bool readVectors(const CloudView& cloud, const std::string& prefix, double limit,
                 std::vector<Eigen::Vector3f>* vectors, std::string* detail) {
  Column values;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = prefix + "xyz"[axis];
    const Field* field = cloud.layout.find(name);
    if (field == nullptr) {
      *detail = "no field '" + name + "' among " + cloud.layout.describeFields();
      return false;
    }
    if (!readComponent(cloud, *field, limit, &values, detail)) return false;
    vectors->resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      (*vectors)[i][axis] = static_cast<float>(values[i]);
    }
  }
  return true;
}

/// A value that is none is unknown.
void readLabels(const CloudView& cloud, std::vector<uint8_t>* labels) {
  const Field* field = cloud.layout.find("label");
  if (field == nullptr) return;
  Column values;
  readScalars(cloud, *field, &values);
  for (const double value : values) {
    const bool is_label = value >= 0.0 && value <= 255.0;
    labels->push_back(is_label ? static_cast<uint8_t>(value) : uint8_t{0});
  }
}

std::optional<StateDrop> readSamples(const sensor_msgs::PointCloud2& message, PoseSamples* samples,
                                     std::string* detail) {
  const CloudLayout layout = layoutOf(message);
  const CloudView cloud{layout, message.data.data(), message.data.size()};
  if (layout.pointCount() == 0) {
    *detail = "its cloud has no samples";
    return StateDrop::kEmpty;
  }
  // Before anything is read: a header may claim any size.
  *detail = layoutError(cloud);
  if (!detail->empty() || !readVectors(cloud, "", kMaxRange_m, &samples->positions_m, detail) ||
      !readVectors(cloud, "normal_", 2.0, &samples->normals, detail)) {
    return StateDrop::kBadCloud;
  }
  if (const Field* color = cameraColorField(layout)) readColors(cloud, *color, &samples->rgb);
  readLabels(cloud, &samples->labels);
  return std::nullopt;
}

}  // namespace

std::optional<Eigen::Isometry3d> isometryOf(const geometry_msgs::Pose& pose) {
  const auto& p = pose.position;
  const auto& q = pose.orientation;
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  const Eigen::Vector3d translation(p.x, p.y, p.z);
  // Negated, so that NaN is refused.
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1.0) < kQuaternionTolerance)) {
    return std::nullopt;
  }
  Eigen::Isometry3d T(rotation.normalized());
  T.translation() = translation;
  return T;
}

std::optional<StateDrop> readPoseCloud(const PoseCloud& message, StatePose* pose,
                                       std::string* detail) {
  if (message.header.stamp.isZero()) {
    *detail = "stamp is 0, expected the time of the pose";
    return StateDrop::kNoStamp;
  }
  const auto T_odom_pose = isometryOf(message.pose.pose);
  if (!T_odom_pose) {
    *detail = "its position is not finite, or its orientation is no unit quaternion";
    return StateDrop::kBadPose;
  }
  if (message.cloud.header.frame_id != message.vehicle_frame) {
    *detail = "its cloud is in frame '" + message.cloud.header.frame_id +
              "', expected the vehicle's, '" + message.vehicle_frame + "'";
    return StateDrop::kOtherFrame;
  }
  auto samples = std::make_shared<PoseSamples>();
  if (const auto drop = readSamples(message.cloud, samples.get(), detail)) return drop;
  pose->stamp_s = static_cast<double>(message.header.stamp.toNSec()) * 1e-9;
  pose->T_odom_pose = *T_odom_pose;
  pose->samples = std::move(samples);
  pose->step_covariance.reset();
  return std::nullopt;
}

}  // namespace ladar_perception
