// SPDX-License-Identifier: BSD-3-Clause
#include "pose_statistics.h"

#include <utility>

#include "statistics_parts.h"

namespace ladar_perception {
namespace {

struct ResampleStage {
  const char* name;
  double ResampleTimes::*milliseconds;
};

constexpr ResampleStage kResampleStages[] = {
    {"voxels", &ResampleTimes::voxels},   {"attributes", &ResampleTimes::attributes},
    {"crust", &ResampleTimes::crust},     {"fronts", &ResampleTimes::fronts},
    {"samples", &ResampleTimes::samples}, {"total", &ResampleTimes::total},
};

}  // namespace

const char* poseDropName(PoseDrop reason) {
  switch (reason) {
    case PoseDrop::kNoSamples:
      return "no_samples";
    case PoseDrop::kMissingField:
      return "missing_field";
    case PoseDrop::kError:
      return "error";
  }
  return "";
}

PoseStatisticsLog::PoseStatisticsLog(std::string policies, std::size_t window)
    : policies_(std::move(policies)),
      lag_ms_(window),
      stage_ms_(std::size(kResampleStages), SampleWindow(window)) {}

void PoseStatisticsLog::addScan(const ScanUse& use) {
  ++scans_;
  scans_between_ += use.taken ? 0 : 1;
  poses_ += use.joined ? 1 : 0;
  points_kept_ += use.points_kept;
  points_in_ += use.points_kept + sumOf(use.dropped);
  for (int i = 0; i < kGatherDrops; ++i) points_dropped_[i] += use.dropped[i];
}

void PoseStatisticsLog::addScanDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason) {
  const uint64_t points = pointsReceived(scan);
  ++scans_dropped_[static_cast<int>(reason)];
  scan_points_dropped_[static_cast<int>(reason)] += points;
  points_in_ += points;
}

void PoseStatisticsLog::addPublished(uint64_t id, const std_msgs::Header& header,
                                     const ResampledCloud& samples) {
  header_ = header;
  ++published_;
  samples_ += samples.size();
  lag_ms_.add((ros::WallTime::now() - waiting_since_[id]).toSec() * 1e3);
  waiting_since_.erase(id);
  for (std::size_t i = 0; i < stage_ms_.size(); ++i) {
    stage_ms_[i].add(samples.times_ms.*kResampleStages[i].milliseconds);
  }
}

void PoseStatisticsLog::addPoseDrop(uint64_t id, PoseDrop reason) {
  ++poses_dropped_[static_cast<int>(reason)];
  waiting_since_.erase(id);
}

uint64_t PoseStatisticsLog::scansDropped() const { return sumOf(scans_dropped_); }

uint64_t PoseStatisticsLog::posesDropped() const { return sumOf(poses_dropped_); }

PoseResamplerStatistics PoseStatisticsLog::message() const {
  PoseResamplerStatistics message;
  message.header = header_;
  message.policies = policies_;
  message.scans = scans_;
  message.scans_between = scans_between_;
  appendDrops(scans_dropped_, scanDropName, &message.scans_dropped);
  message.points_in = points_in_;
  message.points_kept = points_kept_;
  appendDrops(scan_points_dropped_, scanDropName, &message.points_dropped);
  appendDrops(points_dropped_, gatherDropName, &message.points_dropped);
  message.poses = poses_;
  message.poses_published = published_;
  appendDrops(poses_dropped_, poseDropName, &message.poses_dropped);
  message.poses_waiting = static_cast<uint32_t>(posesWaiting());
  if (!waiting_since_.empty()) {
    // Poses are completed in the order of their ids.
    const ros::WallDuration waited = ros::WallTime::now() - waiting_since_.begin()->second;
    message.backlog_s = static_cast<float>(waited.toSec());
  }
  message.samples = samples_;
  message.lag_p50_ms = static_cast<float>(lag_ms_.percentile(0.5));
  message.lag_p95_ms = static_cast<float>(lag_ms_.percentile(0.95));
  message.lag_p99_ms = static_cast<float>(lag_ms_.percentile(0.99));
  message.lag_max_ms = static_cast<float>(lag_ms_.max());
  for (std::size_t i = 0; i < stage_ms_.size(); ++i) {
    message.stages.push_back(stageTime(kResampleStages[i].name, stage_ms_[i]));
  }
  message.resets = static_cast<uint32_t>(resets_);
  return message;
}

}  // namespace ladar_perception
