// SPDX-License-Identifier: BSD-3-Clause
// From a PointCloud2 and tf to labels: what the nodelet and classify_bag share.
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>

#include <optional>
#include <string>

#include "ladar_perception/terrain/terrain_pipeline.h"
#include "scan_placer.h"
#include "terrain_node_config.h"

namespace ladar_perception {

/// What became of one scan.
struct ScanOutcome {
  std::optional<ScanDrop> drop;  ///< empty when the scan was labelled
  std::string detail;            ///< of a drop: what was expected and what was there
  bool map_reset = false;        ///< the stamp lay before the last one: the map was reset first
  Eigen::Vector3d p_map_vehicle = Eigen::Vector3d::Zero();
};

/// Takes scans one after the other. Not thread-safe; the tf buffer may be fed meanwhile.
class TerrainProcessor {
 public:
  /// reset() may be called while it waits.
  using Wait = ScanPlacer::Wait;

  TerrainProcessor(const TerrainNodeConfig& config, const ClassifierModel& model,
                   tf2::BufferCore* buffer);

  ScanOutcome process(const sensor_msgs::PointCloud2& scan, const Wait& wait);
  void reset();
  /// See TerrainPipeline::keepFeatures.
  void keepFeatures(bool keep) { pipeline_.keepFeatures(keep); }

  const TerrainPipeline& pipeline() const { return pipeline_; }
  /// Layout of the last labelled scan.
  const CloudLayout& scanLayout() const { return placer_.layout(); }

 private:
  ScanPlacer placer_;
  TerrainPipeline pipeline_;
};

}  // namespace ladar_perception
