// SPDX-License-Identifier: BSD-3-Clause
#include "scan_placer.h"

#include <tf2/exceptions.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "cloud_message.h"
#include "ladar_perception/map/fixed_point.h"

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

bool isUsable(const Eigen::Isometry3d& T_map) {
  return T_map.matrix().allFinite() &&
         T_map.translation().cwiseAbs().maxCoeff() < kMaxCoordinate_m / 2;
}

ros::Time shifted(const ros::Time& stamp, double offset_s) {
  // Past the start of time there is nothing to look up; 0 would mean "the latest".
  const double total = stamp.toSec() + offset_s;
  return total > 0.0 ? stamp + ros::Duration(offset_s) : stamp;
}

}  // namespace

ScanPlacer::ScanPlacer(std::string map_frame, std::string vehicle_frame, bool motion_compensation,
                       tf2::BufferCore* buffer)
    : map_frame_(std::move(map_frame)),
      vehicle_frame_(std::move(vehicle_frame)),
      motion_compensation_(motion_compensation),
      buffer_(buffer) {}

std::optional<ScanDrop> ScanPlacer::place(const sensor_msgs::PointCloud2& scan, const Wait& wait,
                                          std::string* detail) {
  if (std::size_t{scan.width} * scan.height == 0) {
    *detail = "no points";
    return ScanDrop::kEmpty;
  }
  layout_ = layoutOf(scan);
  const CloudView cloud{layout_, scan.data.data(), scan.data.size()};
  const auto fields = findPointFields(cloud, detail);
  if (!fields) return ScanDrop::kBadCloud;
  fields_ = *fields;
  stamp_ = scan.header.stamp;
  if (stamp_.isZero()) {
    *detail = "stamp is 0, expected the time of the scan";
    return ScanDrop::kNoStamp;
  }
  const std::string sensor_frame = withoutSlash(scan.header.frame_id);
  placed_vehicle_frame_ = vehicle_frame_.empty() ? sensor_frame : vehicle_frame_;
  checkTime(sensor_frame, stamp_);
  readTimes(cloud);
  const std::vector<double> offsets_s = knotOffsets();
  const auto ready = [&] {
    return canTransform(sensor_frame, stamp_, offsets_s, detail) &&
           canTransform(placed_vehicle_frame_, stamp_, {0.0}, detail);
  };
  if (!wait(ready)) return ScanDrop::kNoTransform;
  std::vector<SensorMotion::Knot> knots;
  for (const double offset_s : offsets_s) {
    knots.push_back({offset_s, lookUp(sensor_frame, shifted(stamp_, offset_s))});
  }
  T_map_vehicle_ = lookUp(placed_vehicle_frame_, stamp_);
  const bool usable = isUsable(T_map_vehicle_) &&
                      std::all_of(knots.begin(), knots.end(), [](const SensorMotion::Knot& knot) {
                        return isUsable(knot.T_map_sensor);
                      });
  if (!usable) {
    *detail = "the pose in " + map_frame_ + " is not finite or beyond 5e6 m";
    return ScanDrop::kBadPose;
  }
  motion_ = SensorMotion(std::move(knots));
  return std::nullopt;
}

void ScanPlacer::checkTime(const std::string& frame, const ros::Time& stamp) {
  const auto last = last_stamp_.find(frame);
  if (last != last_stamp_.end() && stamp < last->second) {
    time_jumped_ = true;
    // Transforms from after the jump's target would make tf refuse older ones as outdated. A
    // buffer that was cleared with the clock already holds none of them and is left alone.
    std::string why;
    const ros::Time later = last->second;
    const bool holds_future =
        later - stamp > ros::Duration(kMaxTimeOffset_s) && canTransform(frame, later, {0.0}, &why);
    if (holds_future) buffer_->clear();
    forgetTime();
  }
  last_stamp_[frame] = stamp;
}

void ScanPlacer::readTimes(const CloudView& cloud) {
  time_offsets_s_.clear();
  if (!motion_compensation_ || !fields_.time) return;
  readTimeOffsets(cloud, *fields_.time, stamp_.toSec(), kMaxTimeOffset_s, &time_offsets_s_);
}

std::vector<double> ScanPlacer::knotOffsets() const {
  if (time_offsets_s_.empty() || stamp_.toSec() <= 0.0) return {0.0};
  const auto [first, last] = std::minmax_element(time_offsets_s_.begin(), time_offsets_s_.end());
  const double begin_s = *first;
  const double span_s = static_cast<double>(*last) - begin_s;
  if (span_s <= 0.0) return {begin_s};
  const int intervals = static_cast<int>(std::ceil(span_s / kKnotSpacing_s));
  std::vector<double> offsets_s;
  for (int i = 0; i <= intervals; ++i) offsets_s.push_back(begin_s + span_s * i / intervals);
  return offsets_s;
}

bool ScanPlacer::canTransform(const std::string& frame, const ros::Time& stamp,
                              const std::vector<double>& offsets_s, std::string* why) const {
  why->clear();  // tf2 appends
  return std::all_of(offsets_s.begin(), offsets_s.end(), [&](double offset_s) {
    return buffer_->canTransform(map_frame_, frame, shifted(stamp, offset_s), why);
  });
}

Eigen::Isometry3d ScanPlacer::lookUp(const std::string& frame, const ros::Time& stamp) const {
  return toIsometry(buffer_->lookupTransform(map_frame_, frame, stamp).transform);
}

}  // namespace ladar_perception
