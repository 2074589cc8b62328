// SPDX-License-Identifier: BSD-3-Clause
#include "terrain_processor.h"

namespace ladar_perception {

TerrainProcessor::TerrainProcessor(const TerrainNodeConfig& config, const ClassifierModel& model,
                                   tf2::BufferCore* buffer)
    : placer_(config.map_frame, config.vehicle_frame, config.motion_compensation, buffer),
      pipeline_(config.pipeline, model) {}

ScanOutcome TerrainProcessor::process(const sensor_msgs::PointCloud2& scan, const Wait& wait) {
  ScanOutcome outcome;
  outcome.drop = placer_.place(scan, wait, &outcome.detail);
  outcome.map_reset = placer_.takeTimeJump();
  if (outcome.map_reset) pipeline_.reset();
  if (outcome.drop) return outcome;
  const CloudView cloud{placer_.layout(), scan.data.data(), scan.data.size()};
  const PlacedScan placed = placer_.placed(cloud);
  outcome.p_map_vehicle = placed.T_map_vehicle.translation();
  pipeline_.process(cloud, placed.fields, placed.time_offsets_s, placed.motion,
                    outcome.p_map_vehicle, scan.header.stamp.toSec());
  return outcome;
}

void TerrainProcessor::reset() {
  pipeline_.reset();
  placer_.forgetTime();
}

}  // namespace ladar_perception
