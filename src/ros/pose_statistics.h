// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ladar_perception/PoseResamplerStatistics.h>
#include <ros/time.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "ladar_perception/resample/cloud_resampler.h"
#include "ladar_perception/resample/pose_keeper.h"
#include "ladar_perception/util/sample_window.h"
#include "scan_drop.h"

namespace ladar_perception {

/// Why a pose that joined gave no samples.
enum class PoseDrop {
  kNoSamples,     ///< no part of its surface is large enough
  kMissingField,  ///< a policy needs a field that its cloud lacks
  kError,         ///< another exception, out of memory for example
};
constexpr int kPoseDrops = 3;
const char* poseDropName(PoseDrop reason);

/// Counts of every scan and every pose, and what became of them.
class PoseStatisticsLog {
 public:
  /// Percentiles are over the last `window` poses, 0 for all.
  PoseStatisticsLog(std::string policies, std::size_t window);

  /// A scan that is in a pose's cloud or lay between poses.
  void addScan(const ScanUse& use);
  /// A scan that is not; its points count as dropped for that reason.
  void addScanDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason);
  void addReset() { ++resets_; }
  /// A pose is complete; it waits since the arrival of the scan that completed it.
  void addComplete(uint64_t id, const ros::WallTime& arrival) { waiting_since_[id] = arrival; }
  /// Its samples are out.
  void addPublished(uint64_t id, const std_msgs::Header& header, const ResampledCloud& samples);
  void addPoseDrop(uint64_t id, PoseDrop reason);

  uint64_t scans() const { return scans_; }
  uint64_t scansDropped() const;
  uint64_t posesDropped() const;
  /// Poses that joined and are neither published nor dropped.
  uint64_t posesWaiting() const { return poses_ - published_ - posesDropped(); }
  /// The typed message; what the caller knows better is left for it.
  PoseResamplerStatistics message() const;

 private:
  std::string policies_;
  std_msgs::Header header_;
  uint64_t scans_ = 0;
  uint64_t scans_between_ = 0;
  std::array<uint64_t, kScanDrops> scans_dropped_{};
  std::array<uint64_t, kScanDrops> scan_points_dropped_{};
  uint64_t points_in_ = 0;
  uint64_t points_kept_ = 0;
  std::array<uint64_t, kGatherDrops> points_dropped_{};
  uint64_t poses_ = 0;
  uint64_t published_ = 0;
  std::array<uint64_t, kPoseDrops> poses_dropped_{};
  std::map<uint64_t, ros::WallTime> waiting_since_;  // by id
  uint64_t samples_ = 0;
  uint64_t resets_ = 0;
  SampleWindow lag_ms_;
  std::vector<SampleWindow> stage_ms_;
};

}  // namespace ladar_perception
