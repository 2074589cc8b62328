// SPDX-License-Identifier: BSD-3-Clause
// Decides which poses of a vehicle are kept and gathers the cloud of each.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ladar_perception/cloud/placed_scan.h"
#include "ladar_perception/params/param_table.h"
#include "ladar_perception/resample/policy.h"

namespace ladar_perception {

/// Configuration of a PoseKeeper.
struct PoseKeeperConfig {
  std::string join = "motion";
  double pose_distance_m = 1.0;
  double pose_angle_deg = 15.0;
  double pose_period_s = 0.0;
  std::string gather = "scan";
  int gather_max_points = 500000;
  double min_range_m = 0.5;
  double max_range_m = 100.0;

  /// Names, ranges, units and meanings of the fields above.
  void addTo(ParamTable* table);
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;
};

/// Why a point is in no pose's cloud.
enum class GatherDrop {
  kNotFinite,  ///< NaN or infinite
  kTooNear,    ///< nearer than min_range_m
  kTooFar,     ///< farther than max_range_m
  kBetween,    ///< its scan lay between two poses
};
constexpr int kGatherDrops = 4;
const char* gatherDropName(GatherDrop reason);

/// A pose that joined, with everything that was gathered for it.
struct KeptPose {
  uint64_t id = 0;        ///< counts up from 0, none is left out
  uint64_t stamp_ns = 0;  ///< of the scan it joined with
  Eigen::Isometry3d T_map_vehicle = Eigen::Isometry3d::Identity();
  uint64_t last_stamp_ns = 0;  ///< of the last scan gathered
  uint32_t scans = 0;          ///< gathered
  /// The points gathered as they came, in one row; x y z are still in the sensor's frame.
  CloudLayout layout;
  std::vector<uint8_t> bytes;
  /// The same points in the vehicle's frame at `stamp_ns`. Labels are those of a field `label`,
  /// colours those of cameraColorField().
  PoseCloudData points;

  CloudView view() const { return {layout, bytes.data(), bytes.size()}; }
};

/// What became of one scan.
struct ScanUse {
  bool joined = false;  ///< a pose joined with it
  bool taken = false;   ///< it is in a pose's cloud
  std::string refused;  ///< why it can be in none, if it had to be
  uint64_t points_kept = 0;
  std::array<uint64_t, kGatherDrops> dropped{};
};

/// Takes scans one after the other, by ascending stamps, and hands out poses that are complete.
class PoseKeeper {
 public:
  /// Throws std::invalid_argument with every violation of `config`.
  explicit PoseKeeper(const PoseKeeperConfig& config);

  /// The next scan makes a pose, whatever the rules say.
  void request() { requested_ = true; }
  /// Takes a scan; poses that it completed are appended. A pose joins with a scan that has points
  /// to give. A scan whose fields are not those of the cloud it would be gathered to is refused.
  ScanUse add(const PlacedScan& scan, std::vector<KeptPose>* complete);
  /// Completes the pose that is being gathered, if there is one; scans lie between poses then,
  /// until the next joins.
  std::optional<KeptPose> close();
  /// Forgets where the last pose was: the next scan makes one.
  void forgetLastPose() { has_last_ = false; }

  bool gathering() const { return open_.has_value(); }
  /// Poses that have joined so far.
  uint64_t joined() const { return next_id_; }

 private:
  bool joins(const PlacedScan& scan) const;
  /// Indices of the points that can be used; the others are counted.
  std::vector<uint32_t> usablePoints(const std::vector<Eigen::Vector3d>& p_sensor,
                                     ScanUse* use) const;
  void begin(const PlacedScan& scan);
  void append(const PlacedScan& scan, const std::vector<Eigen::Vector3d>& p_sensor,
              const std::vector<uint32_t>& kept);

  PoseKeeperConfig config_;
  bool requested_ = false;
  bool has_last_ = false;
  Eigen::Isometry3d T_map_last_ = Eigen::Isometry3d::Identity();
  uint64_t last_stamp_ns_ = 0;
  uint64_t next_id_ = 0;
  std::optional<KeptPose> open_;
};

}  // namespace ladar_perception
