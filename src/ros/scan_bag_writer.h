// SPDX-License-Identifier: BSD-3-Clause
// Writes scans and transforms as a bag that the nodelets can play.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <rosbag/bag.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"

namespace ladar_perception {

/// Bag of one cloud topic with /tf and /tf_static.
class ScanBagWriter {
 public:
  /// Opens `path` for writing; throws std::runtime_error that names the path if it cannot.
  /// The bag appears under `path` only when close() succeeds.
  ScanBagWriter(const std::string& path, const std::string& cloud_topic);
  ~ScanBagWriter();

  /// A pose that never changes; call before the first cloud.
  void writeStaticTransform(const ros::Time& stamp, const std::string& parent,
                            const std::string& child, const Eigen::Isometry3d& T_parent_child);
  void writeTransform(const ros::Time& stamp, const std::string& parent, const std::string& child,
                      const Eigen::Isometry3d& T_parent_child);
  /// A pose in `frame`, as geometry_msgs/PoseStamped.
  void writePose(const ros::Time& stamp, const std::string& topic, const std::string& frame,
                 const Eigen::Isometry3d& T_frame_pose);
  /// Writes a cloud stamped `stamp`, recorded at `record_time` (when its last point was measured).
  /// `is_dense` says that no point is NaN or infinite.
  void writeCloud(const ros::Time& stamp, const ros::Time& record_time, const std::string& frame,
                  const CloudLayout& layout, std::vector<uint8_t> data, bool is_dense);
  /// Completes the bag; throws std::runtime_error if the disk refused it.
  void close();

 private:
  std::string path_;
  std::string partial_path_;
  std::string cloud_topic_;
  rosbag::Bag bag_;
  uint32_t cloud_seq_ = 0;
  std::vector<geometry_msgs::TransformStamped> static_transforms_;
};

}  // namespace ladar_perception
