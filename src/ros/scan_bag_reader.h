// SPDX-License-Identifier: BSD-3-Clause
// Plays a bag into a tf buffer and hands out its clouds, without a ROS master and without a clock.
#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>

#include <deque>
#include <functional>
#include <memory>
#include <string>

namespace ladar_perception {

/// Reads every message of a bag once, in the order they were recorded.
class ScanBagReader {
 public:
  /// A message that is neither the clouds' topic nor a cloud; called for all of them, tf included.
  using OtherMessage = std::function<void(const rosbag::MessageInstance&)>;

  struct Scan {
    sensor_msgs::PointCloud2ConstPtr cloud;
    ros::Time recorded;
  };

  /// Opens `path` and feeds every static transform. `topic` "" takes the only PointCloud2 topic.
  /// Throws std::runtime_error that names the file and what is wrong (no bag, not indexed, no or
  /// several cloud topics, no such topic).
  ScanBagReader(const std::string& path, const std::string& topic, tf2::BufferCore* buffer);

  const std::string& topic() const { return topic_; }
  std::size_t scanCount() const { return scan_count_; }
  void setOtherMessageHandler(OtherMessage handler) { other_ = std::move(handler); }

  /// The next scan; false at the end of the bag.
  bool next(Scan* scan);
  /// Plays on, transforms into the buffer and scans into a queue, until `ready()` is true; gives up
  /// at messages recorded later than `deadline` or at the end of the bag.
  bool playUntil(const std::function<bool()>& ready, const ros::Time& deadline);

 private:
  void chooseTopic(const std::string& requested);
  void feedStaticTransforms();
  bool playOne(const ros::Time& deadline);
  bool playMessage(const ros::Time& deadline);

  std::string path_;
  std::string topic_;
  tf2::BufferCore* buffer_;
  rosbag::Bag bag_;
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator at_;
  std::size_t scan_count_ = 0;
  std::deque<Scan> queue_;
  OtherMessage other_;
};

}  // namespace ladar_perception
