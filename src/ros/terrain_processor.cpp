// SPDX-License-Identifier: BSD-3-Clause
#include "terrain_processor.h"

#include <tf2/exceptions.h>

#include <algorithm>
#include <cmath>

#include "cloud_message.h"

namespace ladar_perception {
namespace {

// Points measured farther than this from their scan's stamp are a driver's mistake.
constexpr double kMaxTimeOffset_s = 1.0;
// Poses are sampled at least this densely over a scan; a pose source is rarely faster.
constexpr double kKnotSpacing_s = 0.01;

/// tf2 refuses the leading slash that logs of old have.
std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

Eigen::Isometry3d toIsometry(const geometry_msgs::Transform& transform) {
  const auto& p = transform.translation;
  const auto& q = transform.rotation;
  Eigen::Isometry3d result(Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized());
  result.translation() = Eigen::Vector3d(p.x, p.y, p.z);
  return result;
}

bool withinReach(const Eigen::Vector3d& p_map) {
  return p_map.allFinite() && p_map.cwiseAbs().maxCoeff() < kMaxCoordinate_m / 2;
}

ScanOutcome dropped(ScanDrop reason, std::string detail) {
  ScanOutcome outcome;
  outcome.drop = reason;
  outcome.detail = std::move(detail);
  return outcome;
}

ros::Time shifted(const ros::Time& stamp, double offset_s) {
  // Past the start of time there is nothing to look up; 0 would mean "the latest".
  const double total = stamp.toSec() + offset_s;
  return total > 0.0 ? stamp + ros::Duration(offset_s) : stamp;
}

}  // namespace

const char* scanDropName(ScanDrop reason) {
  switch (reason) {
    case ScanDrop::kEmpty:
      return "empty";
    case ScanDrop::kBadCloud:
      return "bad_cloud";
    case ScanDrop::kNoStamp:
      return "no_stamp";
    case ScanDrop::kNoTransform:
      return "no_transform";
    case ScanDrop::kBadPose:
      return "bad_pose";
    case ScanDrop::kQueueFull:
      return "queue_full";
    case ScanDrop::kError:
      return "error";
  }
  return "";
}

TerrainProcessor::TerrainProcessor(const TerrainNodeConfig& config, const ClassifierModel& model,
                                   tf2::BufferCore* buffer)
    : config_(config), buffer_(buffer), pipeline_(config.pipeline, model) {}

ScanOutcome TerrainProcessor::process(const sensor_msgs::PointCloud2& scan, const Wait& wait) {
  const ros::Time& stamp = scan.header.stamp;
  if (std::size_t{scan.width} * scan.height == 0) return dropped(ScanDrop::kEmpty, "no points");
  layout_ = layoutOf(scan);
  const CloudView cloud{layout_, scan.data.data(), scan.data.size()};
  std::string error;
  const auto fields = findPointFields(cloud, &error);
  if (!fields) return dropped(ScanDrop::kBadCloud, error);
  if (stamp.isZero())
    return dropped(ScanDrop::kNoStamp, "stamp is 0, expected the time of the scan");

  ScanOutcome outcome;
  outcome.map_reset = resetIfTimeJumped(scan);
  readTimes(cloud, *fields, stamp.toSec());
  const std::vector<double> offsets_s = knotOffsets(stamp.toSec());
  const std::string sensor_frame = withoutSlash(scan.header.frame_id);
  const std::string vehicle_frame = vehicleFrameFor(sensor_frame);
  const auto ready = [&] {
    return canTransform(sensor_frame, stamp, offsets_s, &error) &&
           canTransform(vehicle_frame, stamp, {0.0}, &error);
  };
  if (!wait(ready)) {
    outcome.drop = ScanDrop::kNoTransform;
    outcome.detail = error;
    return outcome;
  }
  std::vector<SensorMotion::Knot> knots;
  for (const double offset_s : offsets_s) {
    knots.push_back({offset_s, lookUp(sensor_frame, shifted(stamp, offset_s))});
  }
  outcome.p_map_vehicle = lookUp(vehicle_frame, stamp).translation();
  const bool reachable =
      withinReach(outcome.p_map_vehicle) &&
      std::all_of(knots.begin(), knots.end(), [](const SensorMotion::Knot& knot) {
        return withinReach(knot.T_map_sensor.translation()) &&
               knot.T_map_sensor.matrix().allFinite();
      });
  if (!reachable) {
    outcome.drop = ScanDrop::kBadPose;
    outcome.detail = "the pose in " + config_.map_frame + " is not finite or beyond 5e6 m";
    return outcome;
  }
  pipeline_.process(cloud, *fields, time_offsets_s_, SensorMotion(std::move(knots)),
                    outcome.p_map_vehicle, stamp.toSec());
  return outcome;
}

void TerrainProcessor::reset() {
  pipeline_.reset();
  last_stamp_.clear();
}

bool TerrainProcessor::resetIfTimeJumped(const sensor_msgs::PointCloud2& scan) {
  const ros::Time& stamp = scan.header.stamp;
  const std::string frame = withoutSlash(scan.header.frame_id);
  const auto last = last_stamp_.find(frame);
  const bool jumped = last != last_stamp_.end() && stamp < last->second;
  if (jumped) {
    // Transforms from after the jump's target would make tf refuse older ones as outdated. A
    // buffer that was cleared with the clock already holds none of them and is left alone.
    std::string why;
    const ros::Time later = last->second;
    const bool holds_future =
        later - stamp > ros::Duration(kMaxTimeOffset_s) && canTransform(frame, later, {0.0}, &why);
    if (holds_future) buffer_->clear();
    reset();
  }
  last_stamp_[frame] = stamp;
  return jumped;
}

void TerrainProcessor::readTimes(const CloudView& cloud, const PointFields& fields,
                                 double stamp_s) {
  time_offsets_s_.clear();
  if (!config_.motion_compensation || !fields.time) return;
  readTimeOffsets(cloud, *fields.time, stamp_s, kMaxTimeOffset_s, &time_offsets_s_);
}

std::vector<double> TerrainProcessor::knotOffsets(double stamp_s) {
  if (time_offsets_s_.empty() || stamp_s <= 0.0) return {0.0};
  const auto [first, last] = std::minmax_element(time_offsets_s_.begin(), time_offsets_s_.end());
  const double begin_s = *first;
  const double span_s = static_cast<double>(*last) - begin_s;
  if (span_s <= 0.0) return {begin_s};
  const int intervals = static_cast<int>(std::ceil(span_s / kKnotSpacing_s));
  std::vector<double> offsets_s;
  for (int i = 0; i <= intervals; ++i) offsets_s.push_back(begin_s + span_s * i / intervals);
  return offsets_s;
}

bool TerrainProcessor::canTransform(const std::string& frame, const ros::Time& stamp,
                                    const std::vector<double>& offsets_s, std::string* why) const {
  why->clear();  // tf2 appends
  return std::all_of(offsets_s.begin(), offsets_s.end(), [&](double offset_s) {
    return buffer_->canTransform(config_.map_frame, frame, shifted(stamp, offset_s), why);
  });
}

Eigen::Isometry3d TerrainProcessor::lookUp(const std::string& frame, const ros::Time& stamp) const {
  return toIsometry(buffer_->lookupTransform(config_.map_frame, frame, stamp).transform);
}

std::string TerrainProcessor::vehicleFrameFor(const std::string& sensor_frame) const {
  return config_.vehicle_frame.empty() ? sensor_frame : config_.vehicle_frame;
}

}  // namespace ladar_perception
