// SPDX-License-Identifier: BSD-3-Clause
// Reads and rewrites bags for the tests of the programs, with rosbag alone.
#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <cstring>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace ladar_perception::test {

struct RecordedCloud {
  sensor_msgs::PointCloud2 cloud;
  ros::Time recorded;
};

inline std::vector<RecordedCloud> readClouds(const std::string& path, const std::string& topic) {
  std::vector<RecordedCloud> clouds;
  const rosbag::Bag bag(path);
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery(topic))) {
    const auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
    if (cloud) clouds.push_back({*cloud, message.getTime()});
  }
  return clouds;
}

/// "x:7 y:7 ..." of a cloud's fields and their PointField types.
inline std::string fieldsOf(const sensor_msgs::PointCloud2& cloud) {
  std::string text;
  for (const auto& field : cloud.fields) {
    text += (text.empty() ? "" : " ") + field.name + ":" + std::to_string(field.datatype);
  }
  return text;
}

inline const sensor_msgs::PointField* findField(const sensor_msgs::PointCloud2& cloud,
                                                const std::string& name) {
  for (const auto& field : cloud.fields) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

/// A field's values, one per point. T must be the field's type; the machine is little endian, as
/// the bags are.
template <typename T>
std::vector<T> valuesOf(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  const sensor_msgs::PointField* field = findField(cloud, name);
  if (field == nullptr) throw std::runtime_error("no field " + name + " in " + fieldsOf(cloud));
  std::vector<T> values;
  for (uint32_t row = 0; row < cloud.height; ++row) {
    for (uint32_t col = 0; col < cloud.width; ++col) {
      T value;
      std::memcpy(&value,
                  &cloud.data.at(std::size_t{row} * cloud.row_step +
                                 std::size_t{col} * cloud.point_step + field->offset),
                  sizeof(T));
      values.push_back(value);
    }
  }
  return values;
}

inline std::vector<Eigen::Vector3d> positionsOf(const sensor_msgs::PointCloud2& cloud) {
  const auto x = valuesOf<float>(cloud, "x");
  const auto y = valuesOf<float>(cloud, "y");
  const auto z = valuesOf<float>(cloud, "z");
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < x.size(); ++i) positions.emplace_back(x[i], y[i], z[i]);
  return positions;
}

inline Eigen::Isometry3d poseOf(const geometry_msgs::Transform& transform) {
  const auto& q = transform.rotation;
  Eigen::Isometry3d pose(Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized());
  const auto& p = transform.translation;
  pose.translation() = Eigen::Vector3d(p.x, p.y, p.z);
  return pose;
}

/// Poses of every child frame in its parent, by the stamps in the bag.
using Poses = std::map<std::pair<std::string, std::string>, std::map<ros::Time, Eigen::Isometry3d>>;

inline Poses readTransforms(const std::string& path, const std::string& topic) {
  Poses poses;
  const rosbag::Bag bag(path);
  for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery(topic))) {
    const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
    for (const auto& t : transforms->transforms) {
      poses[{t.header.frame_id, t.child_frame_id}][t.header.stamp] = poseOf(t.transform);
    }
  }
  return poses;
}

/// Every transform of the bag.
inline void fillBuffer(const std::string& path, tf2::BufferCore* buffer) {
  const rosbag::Bag bag(path);
  for (const std::string topic : {"/tf", "/tf_static"}) {
    for (const rosbag::MessageInstance& message : rosbag::View(bag, rosbag::TopicQuery(topic))) {
      const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
      for (const auto& transform : transforms->transforms) {
        buffer->setTransform(transform, "test", topic == "/tf_static");
      }
    }
  }
}

/// A message with all a bag knows of it: topic, type, time, latching, bytes.
using RawMessage = std::tuple<std::string, std::string, ros::Time, bool, std::string>;

inline std::vector<RawMessage> readRaw(const std::string& path,
                                       const std::vector<std::string>& topics_left_out) {
  std::vector<RawMessage> messages;
  const rosbag::Bag bag(path);
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    bool left_out = false;
    for (const std::string& topic : topics_left_out) left_out |= topic == message.getTopic();
    if (left_out) continue;
    std::string bytes(message.size(), '\0');
    ros::serialization::OStream stream(reinterpret_cast<uint8_t*>(bytes.data()), message.size());
    message.write(stream);
    messages.emplace_back(message.getTopic(), message.getDataType(), message.getTime(),
                          message.isLatching(), bytes);
  }
  return messages;
}

/// Copies the messages of `from` into an open bag. `edit` writes what becomes of each.
using EditMessage = std::function<void(const rosbag::MessageInstance&, rosbag::Bag*)>;

inline void copyBag(const std::string& from, const EditMessage& edit, rosbag::Bag* to) {
  const rosbag::Bag bag(from);
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) edit(message, to);
}

inline void writeAsItIs(const rosbag::MessageInstance& message, rosbag::Bag* to) {
  to->write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
}

/// A copy of `from` at `path`, whose messages `edit` writes.
inline std::string editedBag(const std::string& from, const std::string& path,
                             const EditMessage& edit) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  copyBag(from, edit, &bag);
  bag.close();
  return path;
}

}  // namespace ladar_perception::test
