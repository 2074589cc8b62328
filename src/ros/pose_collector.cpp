// SPDX-License-Identifier: BSD-3-Clause
#include "pose_collector.h"

#include <utility>

namespace ladar_perception {

PoseCollector::PoseCollector(const PoseResamplerNodeConfig& config, tf2::BufferCore* buffer)
    : placer_(config.odom_frame, config.vehicle_frame, config.motion_compensation, buffer),
      keeper_(config.keeper) {}

CollectOutcome PoseCollector::process(const sensor_msgs::PointCloud2& scan,
                                      const ScanPlacer::Wait& wait) {
  CollectOutcome outcome;
  outcome.drop = placer_.place(scan, wait, &outcome.detail);
  outcome.time_jumped = placer_.takeTimeJump();
  if (outcome.time_jumped) {
    if (auto before = beginJourney()) outcome.complete.push_back(std::move(*before));
  }
  if (outcome.drop) return outcome;

  const CloudView cloud{placer_.layout(), scan.data.data(), scan.data.size()};
  std::vector<KeptPose> complete;
  outcome.use = keeper_.add(placer_.placed(cloud), &complete);
  if (!outcome.use.refused.empty()) {
    outcome.drop = ScanDrop::kBadCloud;
    outcome.detail = outcome.use.refused;
  }
  for (KeptPose& pose : complete) {
    // One that was being gathered has the frame of the scan it joined with.
    const bool joined_now = outcome.use.joined && pose.id + 1 == keeper_.joined();
    outcome.complete.push_back(
        {std::move(pose), joined_now ? placer_.vehicleFrame() : vehicle_frame_, journey_});
  }
  if (outcome.use.joined) vehicle_frame_ = placer_.vehicleFrame();
  return outcome;
}

std::optional<CollectedPose> PoseCollector::close() {
  auto pose = keeper_.close();
  if (!pose) return std::nullopt;
  return CollectedPose{std::move(*pose), vehicle_frame_, journey_};
}

std::optional<CollectedPose> PoseCollector::reset() {
  placer_.forgetTime();
  return beginJourney();
}

std::optional<CollectedPose> PoseCollector::beginJourney() {
  auto pose = close();
  keeper_.forgetLastPose();
  ++journey_;
  return pose;
}

}  // namespace ladar_perception
