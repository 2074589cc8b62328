// SPDX-License-Identifier: BSD-3-Clause
// From a PointCloud2 and tf to a scan whose place is known.
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ladar_perception/cloud/placed_scan.h"
#include "scan_drop.h"

namespace ladar_perception {

/// Places scans one after the other. Not thread-safe, but for what `Wait` says; the tf buffer may
/// be fed meanwhile.
class ScanPlacer {
 public:
  /// Calls its argument until it returns true or time is up; returns what it returned last.
  /// forgetTime() may be called meanwhile.
  using Wait = std::function<bool(const std::function<bool()>& ready)>;

  /// An empty `vehicle_frame` is the cloud's own frame.
  ScanPlacer(std::string map_frame, std::string vehicle_frame, bool motion_compensation,
             tf2::BufferCore* buffer);

  /// Reads the layout and the times of a scan and looks up where it was measured. Returns why it
  /// cannot be used, with what was expected and what was there in `*detail`, or nothing.
  std::optional<ScanDrop> place(const sensor_msgs::PointCloud2& scan, const Wait& wait,
                                std::string* detail);
  /// Whether a scan since the last call was stamped before the one of its frame before it. Dropped
  /// scans and ones whose placing threw jump as well.
  bool takeTimeJump() { return std::exchange(time_jumped_, false); }
  /// Forgets the stamps there were, so that no scan after this one jumps.
  void forgetTime() { last_stamp_.clear(); }

  /// The last scan that was placed; for as long as its message lives and until the next.
  PlacedScan placed(const CloudView& cloud) const {
    return {cloud, fields_, time_offsets_s_, motion_, T_map_vehicle_, stamp_.toNSec()};
  }
  const CloudLayout& layout() const { return layout_; }
  /// The vehicle frame, resolved for the last scan.
  const std::string& vehicleFrame() const { return placed_vehicle_frame_; }

 private:
  void checkTime(const std::string& frame, const ros::Time& stamp);
  void readTimes(const CloudView& cloud);
  std::vector<double> knotOffsets() const;
  bool canTransform(const std::string& frame, const ros::Time& stamp,
                    const std::vector<double>& offsets_s, std::string* why) const;
  Eigen::Isometry3d lookUp(const std::string& frame, const ros::Time& stamp) const;

  std::string map_frame_;
  std::string vehicle_frame_;
  bool motion_compensation_;
  tf2::BufferCore* buffer_;
  std::map<std::string, ros::Time> last_stamp_;  // by the cloud's frame
  bool time_jumped_ = false;

  CloudLayout layout_;
  PointFields fields_;
  ros::Time stamp_;
  std::vector<float> time_offsets_s_;
  SensorMotion motion_{Eigen::Isometry3d::Identity()};
  std::string placed_vehicle_frame_;
  Eigen::Isometry3d T_map_vehicle_ = Eigen::Isometry3d::Identity();
};

}  // namespace ladar_perception
