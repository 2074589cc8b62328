// SPDX-License-Identifier: BSD-3-Clause
// Re-sampled poses of a vehicle that drives round a yard, as messages, by an odometry that drifts.
#pragma once

#include <ladar_perception/PoseCloud.h>

#include <cmath>
#include <vector>

#include "cloud_message.h"
#include "pose_cloud_message.h"
#include "register_scenes.h"

namespace ladar_perception::test {

constexpr std::size_t kYardSamples = 600;
constexpr int kYardLap = 40;  // poses, a metre apart

/// A yard of 30 x 24 m with walls, and four things in it that fix every direction.
inline std::vector<Face> yardFaces() {
  std::vector<Face> faces = boxFaces({-15.0, -12.0, 0.0}, {15.0, 12.0, 4.0}, true);
  const auto add = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    for (const Face& face : boxFaces(low, high, false)) faces.push_back(face);
  };
  add({9.0, -1.0, 0.0}, {11.0, 3.0, 2.5});
  add({-2.0, 8.5, 0.0}, {1.0, 10.0, 1.5});
  add({-12.0, -7.0, 0.0}, {-10.0, -4.0, 3.0});
  add({-1.0, -1.0, 0.0}, {1.0, 1.5, 1.0});
  return faces;
}

/// A drive round a circle. Odometry measures 3 % too far and turns 0.5 degrees too far a metre.
class YardDrive {
 public:
  explicit YardDrive(double start_s = 1000.0) : start_(start_s) {}

  ros::Time stamp(int i) const { return start_ + ros::Duration(0.5 * i); }
  /// In the map, whose origin is the odometry's.
  static Eigen::Isometry3d truth(int i) {
    const double angle = 2.0 * M_PI * i / kYardLap;
    const double radius_m = kYardLap / (2.0 * M_PI);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() << radius_m * std::sin(angle), -radius_m * std::cos(angle), 0.0;
    T.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    return T;
  }
  static Eigen::Isometry3d odometry(int i) {
    Eigen::Isometry3d T = truth(0);
    for (int k = 1; k <= i; ++k) {
      Eigen::Isometry3d step = truth(k - 1).inverse(Eigen::Isometry) * truth(k);
      step.translation() *= 1.03;
      step.rotate(Eigen::AngleAxisd(0.5 * M_PI / 180.0, Eigen::Vector3d::UnitZ()));
      T = T * step;
    }
    return T;
  }
  PoseCloud pose(int i) const {
    PoseCloud message;
    message.header.stamp = stamp(i);
    message.header.frame_id = "odom";
    message.id = static_cast<uint64_t>(i);
    message.vehicle_frame = "base_link";
    message.pose.pose = poseMessage(odometry(i));
    message.scans = 1;
    message.last_scan = stamp(i);
    message.points_in = kYardSamples;
    message.cloud = cloudOf(moved(truth(i).inverse(Eigen::Isometry),
                                  pointsOn(yardFaces(), kYardSamples, 0.005, 100 + i)));
    message.cloud.header.stamp = stamp(i);
    message.cloud.header.frame_id = message.vehicle_frame;
    return message;
  }

 private:
  static sensor_msgs::PointCloud2 cloudOf(const OrientedPoints& points) {
    CloudLayout layout;
    for (const char* name : {"x", "y", "z", "normal_x", "normal_y", "normal_z"}) {
      layout.append(name, ScalarType::kFloat32);
    }
    layout.width = static_cast<uint32_t>(points.positions_m.size());
    layout.pack();
    sensor_msgs::PointCloud2 message;
    setLayout(layout, &message);
    message.data.resize(layout.row_step);
    for (std::size_t i = 0; i < points.positions_m.size(); ++i) {
      const Eigen::Vector3f p = points.positions_m[i].cast<float>();
      std::memcpy(&message.data[i * layout.point_step], p.data(), sizeof(p));
      std::memcpy(&message.data[i * layout.point_step + sizeof(p)], points.normals[i].data(),
                  sizeof(p));
    }
    message.is_dense = true;
    return message;
  }

  ros::Time start_;
};

}  // namespace ladar_perception::test
