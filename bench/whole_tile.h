// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "labeled_tile.h"
#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "position_cloud.h"

namespace ladar_perception::bench {

/// Our pipeline with a map that holds a whole cloud, which it gets as one scan.
class WholeTile {
 public:
  /// Throws std::runtime_error if the cloud is too large for a map or the model fits none.
  WholeTile(const std::vector<Eigen::Vector3d>& points_m, const ClassifierModel& model);

  /// Empties the map.
  void clear() { pipeline_.reset(); }
  /// From the bytes of the cloud to labels; one thread.
  void process();
  /// Of the points, after process().
  Labels labels() const;
  std::size_t size() const { return points_; }
  const ScanReport& report() const { return pipeline_.report(); }

 private:
  std::size_t points_;
  Eigen::Vector3d p_map_center_;
  Eigen::Isometry3d T_map_sensor_;
  TerrainPipeline pipeline_;
  PositionCloud cloud_;
  PointFields fields_;
};

}  // namespace ladar_perception::bench
