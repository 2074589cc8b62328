// SPDX-License-Identifier: BSD-3-Clause
#include "scan_bag_writer.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdio>
#include <stdexcept>
#include <utility>

#include "cloud_message.h"

namespace ladar_perception {
namespace {

geometry_msgs::TransformStamped makeTransform(const ros::Time& stamp, const std::string& parent,
                                              const std::string& child,
                                              const Eigen::Isometry3d& T_parent_child) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  const Eigen::Vector3d& p = T_parent_child.translation();
  const Eigen::Quaterniond q(T_parent_child.rotation());
  message.transform.translation.x = p.x();
  message.transform.translation.y = p.y();
  message.transform.translation.z = p.z();
  message.transform.rotation.x = q.x();
  message.transform.rotation.y = q.y();
  message.transform.rotation.z = q.z();
  message.transform.rotation.w = q.w();
  return message;
}

}  // namespace

ScanBagWriter::ScanBagWriter(const std::string& path, const std::string& cloud_topic)
    : path_(path), partial_path_(path + ".partial"), cloud_topic_(cloud_topic) {
  try {
    bag_.open(partial_path_, rosbag::bagmode::Write);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": cannot be written: " + error.what());
  }
}

ScanBagWriter::~ScanBagWriter() {
  if (!bag_.isOpen()) return;
  // Not completed: leave nothing that looks like a whole bag.
  try {
    bag_.close();
  } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): already failing
  }
  std::remove(partial_path_.c_str());
}

void ScanBagWriter::writeStaticTransform(const ros::Time& stamp, const std::string& parent,
                                         const std::string& child,
                                         const Eigen::Isometry3d& T_parent_child) {
  // /tf_static is latched, one message per publisher: each message carries all of them.
  static_transforms_.push_back(makeTransform(stamp, parent, child, T_parent_child));
  tf2_msgs::TFMessage message;
  message.transforms = static_transforms_;
  auto header = boost::make_shared<ros::M_string>();
  (*header)["latching"] = "1";
  (*header)["callerid"] = "/ladar_perception";
  (*header)["topic"] = "/tf_static";
  (*header)["type"] = ros::message_traits::datatype(message);
  (*header)["md5sum"] = ros::message_traits::md5sum(message);
  (*header)["message_definition"] = ros::message_traits::definition(message);
  bag_.write("/tf_static", stamp, message, header);
}

void ScanBagWriter::writeTransform(const ros::Time& stamp, const std::string& parent,
                                   const std::string& child,
                                   const Eigen::Isometry3d& T_parent_child) {
  tf2_msgs::TFMessage message;
  message.transforms.push_back(makeTransform(stamp, parent, child, T_parent_child));
  bag_.write("/tf", stamp, message);
}

void ScanBagWriter::writePose(const ros::Time& stamp, const std::string& topic,
                              const std::string& frame, const Eigen::Isometry3d& T_frame_pose) {
  geometry_msgs::PoseStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  const Eigen::Vector3d& p = T_frame_pose.translation();
  const Eigen::Quaterniond q(T_frame_pose.rotation());
  message.pose.position.x = p.x();
  message.pose.position.y = p.y();
  message.pose.position.z = p.z();
  message.pose.orientation.x = q.x();
  message.pose.orientation.y = q.y();
  message.pose.orientation.z = q.z();
  message.pose.orientation.w = q.w();
  bag_.write(topic, stamp, message);
}

void ScanBagWriter::writeCloud(const ros::Time& stamp, const ros::Time& record_time,
                               const std::string& frame, const CloudLayout& layout,
                               std::vector<uint8_t> data, bool is_dense) {
  sensor_msgs::PointCloud2 message;
  message.header.seq = cloud_seq_++;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.is_dense = is_dense;
  setLayout(layout, &message);
  message.data = std::move(data);
  bag_.write(cloud_topic_, record_time, message);
}

void ScanBagWriter::close() {
  try {
    bag_.close();
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path_ + ": cannot be completed: " + error.what());
  }
  if (std::rename(partial_path_.c_str(), path_.c_str()) != 0) {
    std::remove(partial_path_.c_str());
    throw std::runtime_error(path_ + ": cannot be renamed from " + partial_path_);
  }
}

}  // namespace ladar_perception
