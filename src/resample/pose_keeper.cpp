// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/pose_keeper.h"

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "ladar_perception/cloud/labeled_cloud.h"

namespace ladar_perception {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;

/// A motion seen from `T_map_frame`, so that coordinates stay small however far the map's origin
/// is.
SensorMotion motionIn(const Eigen::Isometry3d& T_map_frame, const SensorMotion& motion) {
  const Eigen::Isometry3d T_frame_map = T_map_frame.inverse(Eigen::Isometry);
  std::vector<SensorMotion::Knot> knots = motion.knots();
  for (SensorMotion::Knot& knot : knots) knot.T_map_sensor = T_frame_map * knot.T_map_sensor;
  return SensorMotion(std::move(knots));
}

/// Labels of the points kept; a value that is none is unknown.
void appendLabels(const CloudView& cloud, const std::vector<uint32_t>& kept,
                  std::vector<uint8_t>* labels) {
  const Field* field = cloud.layout.find("label");
  if (field == nullptr) return;
  std::vector<double> values;
  readScalars(cloud, *field, &values);
  for (const uint32_t i : kept) {
    const bool is_label = values[i] >= 0.0 && values[i] <= 255.0;
    labels->push_back(is_label ? static_cast<uint8_t>(values[i]) : uint8_t{0});
  }
}

void appendColors(const CloudView& cloud, const std::vector<uint32_t>& kept,
                  std::vector<uint32_t>* rgb) {
  const Field* field = cameraColorField(cloud.layout);
  if (field == nullptr) return;
  std::vector<uint32_t> values;
  readColors(cloud, *field, &values);
  for (const uint32_t i : kept) rgb->push_back(values[i]);
}

void appendBytes(const CloudView& cloud, const std::vector<uint32_t>& kept,
                 std::vector<uint8_t>* bytes) {
  bytes->reserve(bytes->size() + kept.size() * cloud.layout.point_step);
  for (const uint32_t i : kept) {
    const uint8_t* point = cloud.point(i / cloud.layout.width, i % cloud.layout.width);
    bytes->insert(bytes->end(), point, point + cloud.layout.point_step);
  }
}

bool sameFields(const CloudLayout& a, const CloudLayout& b) {
  const auto same = [](const Field& x, const Field& y) {
    return x.name == y.name && x.offset == y.offset && x.type == y.type && x.count == y.count;
  };
  return a.point_step == b.point_step && a.big_endian == b.big_endian &&
         std::equal(a.fields.begin(), a.fields.end(), b.fields.begin(), b.fields.end(), same);
}

}  // namespace

void PoseKeeperConfig::addTo(ParamTable* table) {
  table->add("join", &join,
             "which scans make a pose: motion, every_scan, or on_request, by ~add_pose alone");
  table->add("pose_distance_m", &pose_distance_m, 0.0, 1000.0, "m",
             "by motion: this far from the last pose; 0: never");
  table->add("pose_angle_deg", &pose_angle_deg, 0.0, 180.0, "deg",
             "by motion: turned this much since the last pose; 0: never");
  table->add("pose_period_s", &pose_period_s, 0.0, 86400.0, "s",
             "by motion: this long after the last pose; 0: never");
  table->add("gather", &gather,
             "a pose's cloud: scan, the one it joined with, or until_next, all before the next");
  table->add("gather_max_points", &gather_max_points, 1, 10000000, "points",
             "until_next: a cloud with so many is complete");
  table->add("min_range_m", &min_range_m, 0.0, 100.0, "m",
             "nearer points are dropped: the vehicle itself, and invalid returns at 0");
  table->add("max_range_m", &max_range_m, 1.0, 1000.0, "m", "farther points are dropped");
}

std::vector<std::string> PoseKeeperConfig::validate() const {
  std::vector<std::string> violations;
  if (join != "motion" && join != "every_scan" && join != "on_request") {
    violations.push_back("join: '" + join + "', expected motion, every_scan or on_request");
  }
  if (join == "motion" && pose_distance_m == 0.0 && pose_angle_deg == 0.0 && pose_period_s == 0.0) {
    violations.emplace_back(
        "pose_distance_m, pose_angle_deg, pose_period_s: one of them at least must be greater "
        "than 0");
  }
  if (gather != "scan" && gather != "until_next") {
    violations.push_back("gather: '" + gather + "', expected scan or until_next");
  }
  if (min_range_m >= max_range_m) {
    violations.emplace_back("min_range_m: must be less than max_range_m");
  }
  return violations;
}

const char* gatherDropName(GatherDrop reason) {
  switch (reason) {
    case GatherDrop::kNotFinite:
      return "not_finite";
    case GatherDrop::kTooNear:
      return "too_near";
    case GatherDrop::kTooFar:
      return "too_far";
    case GatherDrop::kBetween:
      return "between";
  }
  return "";
}

PoseKeeper::PoseKeeper(const PoseKeeperConfig& config) : config_(config) {
  std::string report;
  for (const std::string& violation : config.validate()) report += "\n  - " + violation;
  if (!report.empty()) throw std::invalid_argument("pose keeper:" + report);
}

ScanUse PoseKeeper::add(const PlacedScan& scan, std::vector<KeptPose>* complete) {
  ScanUse use;
  const bool join = joins(scan);
  if (!join && !open_) {
    use.dropped[static_cast<int>(GatherDrop::kBetween)] = scan.cloud.layout.pointCount();
    return use;
  }
  if (!join && !sameFields(open_->layout, scan.cloud.layout)) {
    use.refused = "its fields are " + scan.cloud.layout.describeFields() +
                  ", those of the pose's first scan " + open_->layout.describeFields();
    return use;
  }
  std::vector<Eigen::Vector3d> p_sensor;
  readPositions(scan.cloud, scan.fields, &p_sensor);
  const std::vector<uint32_t> kept = usablePoints(p_sensor, &use);
  if (kept.empty() && join) {
    use.refused = "no point is finite and in range";
    return use;
  }
  if (join) {
    if (auto before = close()) complete->push_back(std::move(*before));
    begin(scan);
    use.joined = true;
  }
  append(scan, p_sensor, kept);
  use.taken = true;
  use.points_kept = kept.size();
  const bool full = open_->layout.width >= static_cast<uint32_t>(config_.gather_max_points);
  if (config_.gather == "scan" || full) complete->push_back(*close());
  return use;
}

std::optional<KeptPose> PoseKeeper::close() { return std::exchange(open_, std::nullopt); }

bool PoseKeeper::joins(const PlacedScan& scan) const {
  if (requested_ || config_.join == "every_scan") return true;
  if (config_.join == "on_request") return false;
  if (!has_last_) return true;
  const auto reached = [](double value, double limit) { return limit > 0.0 && value >= limit; };
  const double distance_m = (scan.T_map_vehicle.translation() - T_map_last_.translation()).norm();
  const Eigen::Quaterniond turned(T_map_last_.linear().transpose() * scan.T_map_vehicle.linear());
  const double angle_rad = 2.0 * std::atan2(turned.vec().norm(), std::abs(turned.w()));
  const double elapsed_s =
      static_cast<double>(static_cast<int64_t>(scan.stamp_ns - last_stamp_ns_)) / 1e9;
  return reached(distance_m, config_.pose_distance_m) ||
         reached(angle_rad, config_.pose_angle_deg * kRadians) ||
         reached(elapsed_s, config_.pose_period_s);
}

std::vector<uint32_t> PoseKeeper::usablePoints(const std::vector<Eigen::Vector3d>& p_sensor,
                                               ScanUse* use) const {
  std::vector<uint32_t> kept;
  kept.reserve(p_sensor.size());
  const auto drop = [use](GatherDrop reason) { ++use->dropped[static_cast<int>(reason)]; };
  for (uint32_t i = 0; i < p_sensor.size(); ++i) {
    const double range_m = p_sensor[i].norm();
    if (!std::isfinite(range_m)) {
      drop(GatherDrop::kNotFinite);
    } else if (range_m < config_.min_range_m) {
      drop(GatherDrop::kTooNear);
    } else if (range_m > config_.max_range_m) {
      drop(GatherDrop::kTooFar);
    } else {
      kept.push_back(i);
    }
  }
  return kept;
}

void PoseKeeper::begin(const PlacedScan& scan) {
  requested_ = false;
  has_last_ = true;
  T_map_last_ = scan.T_map_vehicle;
  last_stamp_ns_ = scan.stamp_ns;
  open_.emplace();
  open_->id = next_id_++;
  open_->stamp_ns = scan.stamp_ns;
  open_->T_map_vehicle = scan.T_map_vehicle;
  open_->layout = scan.cloud.layout;
  open_->layout.width = 0;
  open_->layout.height = 1;
  open_->points.sensor_m = motionIn(scan.T_map_vehicle, scan.motion).poseAt(0.0).translation();
}

void PoseKeeper::append(const PlacedScan& scan, const std::vector<Eigen::Vector3d>& p_sensor,
                        const std::vector<uint32_t>& kept) {
  const SensorMotion motion = motionIn(open_->T_map_vehicle, scan.motion);
  MotionTable poses;
  poses.assign(motion);
  const bool timed = !scan.time_offsets_s.empty();
  const Eigen::Isometry3d T_vehicle_sensor = motion.poseAt(0.0);
  std::vector<Eigen::Vector3d>& positions_m = open_->points.positions_m;
  positions_m.reserve(positions_m.size() + kept.size());
  for (const uint32_t i : kept) {
    positions_m.push_back((timed ? poses.nearest(scan.time_offsets_s[i]) : T_vehicle_sensor) *
                          p_sensor[i]);
  }
  appendLabels(scan.cloud, kept, &open_->points.labels);
  appendColors(scan.cloud, kept, &open_->points.rgb);
  appendBytes(scan.cloud, kept, &open_->bytes);
  open_->layout.width = static_cast<uint32_t>(positions_m.size());
  open_->layout.pack();
  open_->last_stamp_ns = scan.stamp_ns;
  ++open_->scans;
}

}  // namespace ladar_perception
