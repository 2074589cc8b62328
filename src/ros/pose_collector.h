// SPDX-License-Identifier: BSD-3-Clause
// From PointCloud2 and tf to poses with their clouds.
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <tf2/buffer_core.h>

#include <optional>
#include <string>
#include <vector>

#include "ladar_perception/resample/pose_keeper.h"
#include "pose_resampler_node_config.h"
#include "scan_placer.h"

namespace ladar_perception {

/// A pose that is complete.
struct CollectedPose {
  KeptPose pose;
  std::string vehicle_frame;
  uint64_t journey = 0;  ///< counts up with every reset: poses of one belong together
};

/// What became of one scan.
struct CollectOutcome {
  std::optional<ScanDrop> drop;  ///< empty when the scan was taken or lay between poses
  std::string detail;            ///< of a drop: what was expected and what was there
  bool time_jumped = false;      ///< the stamp lay before the last one: a new journey began
  ScanUse use;
  std::vector<CollectedPose> complete;  ///< by this scan, in order
};

/// Takes scans one after the other. Not thread-safe; the tf buffer may be fed meanwhile.
class PoseCollector {
 public:
  PoseCollector(const PoseResamplerNodeConfig& config, tf2::BufferCore* buffer);

  CollectOutcome process(const sensor_msgs::PointCloud2& scan, const ScanPlacer::Wait& wait);
  /// The next scan makes a pose.
  void request() { keeper_.request(); }
  /// Completes the pose that is being gathered, if there is one.
  std::optional<CollectedPose> close();
  /// Completes the pose that is being gathered and begins a new journey.
  std::optional<CollectedPose> reset();

  bool gathering() const { return keeper_.gathering(); }
  uint64_t journey() const { return journey_; }

 private:
  std::optional<CollectedPose> beginJourney();

  ScanPlacer placer_;
  PoseKeeper keeper_;
  std::string vehicle_frame_;  // of the pose that is being gathered
  uint64_t journey_ = 0;
};

}  // namespace ladar_perception
