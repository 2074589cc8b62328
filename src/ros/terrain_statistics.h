// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ladar_perception/TerrainStatistics.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/util/sample_window.h"
#include "terrain_processor.h"

namespace ladar_perception {

/// Counts of everything that came in and what became of it.
class TerrainStatisticsLog {
 public:
  /// Percentiles are over the last `window` scans, 0 for all.
  TerrainStatisticsLog(std::string model_name, std::size_t window);

  /// A scan that was labelled.
  void addScan(const sensor_msgs::PointCloud2& scan, const ScanReport& report, double latency_ms);
  /// A scan that was not; its points count as dropped for that reason.
  void addDrop(const sensor_msgs::PointCloud2& scan, ScanDrop reason);
  void addReset() { ++resets_; }

  uint64_t scans() const { return scans_; }
  uint64_t scansDropped() const;
  uint64_t scansDropped(ScanDrop reason) const { return scans_dropped_[static_cast<int>(reason)]; }
  /// The typed message; `model` names the labels.
  TerrainStatistics message(const ClassifierModel& model) const;
  const SampleWindow& latencyMs() const { return latency_ms_; }
  const SampleWindow& stageMs(Stage stage) const { return stage_ms_[static_cast<int>(stage)]; }
  std::size_t maxOccupiedVoxels() const { return max_occupied_voxels_; }

 private:
  std::string model_name_;
  std_msgs::Header header_;
  uint64_t scans_ = 0;
  std::array<uint64_t, kScanDrops> scans_dropped_{};
  std::array<uint64_t, kScanDrops> scan_points_dropped_{};
  uint64_t points_in_ = 0;
  uint64_t points_inserted_ = 0;
  std::array<uint64_t, kPointDrops> points_dropped_{};
  std::vector<uint64_t> label_counts_;
  uint64_t occupied_voxels_ = 0;
  std::size_t max_occupied_voxels_ = 0;
  uint64_t memory_bytes_ = 0;
  uint64_t resets_ = 0;
  SampleWindow latency_ms_;
  std::vector<SampleWindow> stage_ms_;
  SampleWindow scan_interval_s_;
  SampleWindow scan_points_;
};

}  // namespace ladar_perception
