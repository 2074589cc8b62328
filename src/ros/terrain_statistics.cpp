// SPDX-License-Identifier: BSD-3-Clause
#include "terrain_statistics.h"

#include <algorithm>
#include <utility>

#include "statistics_parts.h"

namespace ladar_perception {
TerrainStatisticsLog::TerrainStatisticsLog(std::string model_name, std::size_t window)
    : model_name_(std::move(model_name)),
      latency_ms_(window),
      stage_ms_(kStages, SampleWindow(window)),
      scan_interval_s_(window),
      scan_points_(window) {}

void TerrainStatisticsLog::addScan(const sensor_msgs::PointCloud2& scan, const ScanReport& report,
                                   double latency_ms) {
  const double interval_s = (scan.header.stamp - header_.stamp).toSec();
  if (scans_ > 0 && interval_s > 0.0) scan_interval_s_.add(interval_s);
  header_ = scan.header;
  ++scans_;
  points_in_ += report.points_in;
  points_inserted_ += report.points_inserted;
  for (int i = 0; i < kPointDrops; ++i) points_dropped_[i] += report.dropped[i];
  label_counts_.resize(report.label_counts.size());
  for (std::size_t i = 0; i < label_counts_.size(); ++i) label_counts_[i] += report.label_counts[i];
  occupied_voxels_ = report.occupied_voxels;
  max_occupied_voxels_ = std::max(max_occupied_voxels_, report.occupied_voxels);
  memory_bytes_ = report.memory_bytes;
  latency_ms_.add(latency_ms);
  for (int i = 0; i < kStages; ++i) stage_ms_[i].add(report.stage_ms[i]);
  scan_points_.add(static_cast<double>(report.points_in));
}

void TerrainStatisticsLog::addDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason) {
  const uint64_t points = pointsReceived(scan);
  ++scans_dropped_[static_cast<int>(reason)];
  scan_points_dropped_[static_cast<int>(reason)] += points;
  points_in_ += points;
}

uint64_t TerrainStatisticsLog::scansDropped() const { return sumOf(scans_dropped_); }

TerrainStatistics TerrainStatisticsLog::message(const ClassifierModel& model) const {
  TerrainStatistics message;
  message.header = header_;
  message.model = model_name_;
  message.scans = scans_;
  message.points_in = points_in_;
  message.points_inserted = points_inserted_;
  appendDrops(scans_dropped_, scanDropName, &message.scans_dropped);
  appendDrops(scan_points_dropped_, scanDropName, &message.points_dropped);
  appendDrops(points_dropped_, pointDropName, &message.points_dropped);
  const double interval_s = scan_interval_s_.percentile(0.5);
  message.scan_rate_hz = static_cast<float>(interval_s > 0.0 ? 1.0 / interval_s : 0.0);
  message.points_per_second =
      static_cast<float>(message.scan_rate_hz * scan_points_.percentile(0.5));
  message.latency_p50_ms = static_cast<float>(latency_ms_.percentile(0.5));
  message.latency_p95_ms = static_cast<float>(latency_ms_.percentile(0.95));
  message.latency_p99_ms = static_cast<float>(latency_ms_.percentile(0.99));
  message.latency_max_ms = static_cast<float>(latency_ms_.max());
  for (int i = 0; i < kStages; ++i) {
    message.stages.push_back(stageTime(stageName(static_cast<Stage>(i)), stage_ms_[i]));
  }
  message.occupied_voxels = static_cast<uint32_t>(occupied_voxels_);
  message.memory_bytes = memory_bytes_;
  message.resets = static_cast<uint32_t>(resets_);
  for (std::size_t label = 0; label < label_counts_.size(); ++label) {
    ClassCount count;
    count.label = static_cast<uint8_t>(label);
    count.name = model.labelName(count.label);
    count.count = label_counts_[label];
    message.labels.push_back(count);
  }
  return message;
}

}  // namespace ladar_perception
