// SPDX-License-Identifier: BSD-3-Clause
#include "scan_bag_reader.h"

#include <tf2_msgs/TFMessage.h>

#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace ladar_perception {
namespace {

constexpr const char* kCloudType = "sensor_msgs/PointCloud2";
constexpr const char* kAuthority = "bag";

void feed(const rosbag::MessageInstance& message, bool is_static, tf2::BufferCore* buffer) {
  const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
  if (!transforms) return;
  for (const auto& transform : transforms->transforms) {
    buffer->setTransform(transform, kAuthority, is_static);
  }
}

}  // namespace

ScanBagReader::ScanBagReader(const std::string& path, const std::string& topic,
                             tf2::BufferCore* buffer)
    : path_(path), buffer_(buffer) {
  if (!std::ifstream(path)) throw std::runtime_error(path + ": bag cannot be opened");
  try {
    bag_.open(path, rosbag::bagmode::Read);
    chooseTopic(topic);
    feedStaticTransforms();
    view_ = std::make_unique<rosbag::View>(bag_);
    at_ = view_->begin();
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": cannot be read as a bag: " + error.what() +
                             " (an unfinished recording needs 'rosbag reindex')");
  }
}

bool ScanBagReader::next(Scan* scan) {
  while (queue_.empty()) {
    if (!playOne(ros::TIME_MAX)) return false;
  }
  *scan = std::move(queue_.front());
  queue_.pop_front();
  return true;
}

bool ScanBagReader::playUntil(const std::function<bool()>& ready, const ros::Time& deadline) {
  while (!ready()) {
    if (!playOne(deadline)) return false;
  }
  return true;
}

void ScanBagReader::chooseTopic(const std::string& requested) {
  rosbag::View clouds(bag_, rosbag::TypeQuery(kCloudType));
  std::vector<std::string> topics;
  for (const rosbag::ConnectionInfo* connection : clouds.getConnections()) {
    bool known = false;
    for (const std::string& topic : topics) known = known || topic == connection->topic;
    if (!known) topics.push_back(connection->topic);
  }
  std::string list;
  for (const std::string& topic : topics) list += (list.empty() ? "" : ", ") + topic;
  if (topics.empty()) throw std::runtime_error(path_ + ": has no topic of type " + kCloudType);
  if (requested.empty()) {
    if (topics.size() > 1) {
      throw std::runtime_error(path_ + ": has several cloud topics, choose one: " + list);
    }
    topic_ = topics.front();
  } else {
    topic_ = requested;
    bool present = false;
    for (const std::string& topic : topics) present = present || topic == requested;
    if (!present) {
      throw std::runtime_error(path_ + ": has no clouds on topic '" + requested +
                               "', only on: " + list);
    }
  }
  scan_count_ = rosbag::View(bag_, rosbag::TopicQuery(topic_)).size();
}

void ScanBagReader::feedStaticTransforms() {
  // Latched, so whoever comes late still gets them: their place in the bag does not matter.
  rosbag::View statics(bag_,
                       rosbag::TopicQuery(std::vector<std::string>{"/tf_static", "tf_static"}));
  for (const rosbag::MessageInstance& message : statics) feed(message, true, buffer_);
}

bool ScanBagReader::playOne(const ros::Time& deadline) {
  try {
    return playMessage(deadline);
  } catch (const ros::Exception& error) {  // of rosbag and of deserialisation
    throw std::runtime_error(path_ + ": is damaged: " + error.what());
  }
}

bool ScanBagReader::playMessage(const ros::Time& deadline) {
  if (at_ == view_->end()) return false;
  const rosbag::MessageInstance& message = *at_;
  if (message.getTime() > deadline) return false;
  const std::string& topic = message.getTopic();
  if (topic == topic_) {
    auto cloud = message.instantiate<sensor_msgs::PointCloud2>();
    if (!cloud)
      throw std::runtime_error(path_ + ": a message on " + topic_ + " is no " + kCloudType);
    queue_.push_back({cloud, message.getTime()});
  } else {
    if (topic == "/tf" || topic == "tf") feed(message, false, buffer_);
    if (other_) other_(message);
  }
  ++at_;
  return true;
}

}  // namespace ladar_perception
