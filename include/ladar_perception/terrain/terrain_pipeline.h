// SPDX-License-Identifier: BSD-3-Clause
// The terrain method as one façade: a scan in, labels of its points and of the map's voxels out.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/cloud/labeled_cloud.h"
#include "ladar_perception/cloud/point_reader.h"
#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/saliency/box_sums.h"
#include "ladar_perception/saliency/saliency.h"
#include "ladar_perception/terrain/sensor_motion.h"
#include "ladar_perception/terrain/terrain_config.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Why a point did not go into the map. Its label is unknown, but for saturated ones.
enum class PointDrop {
  kNotFinite,  ///< NaN or infinite
  kTooNear,    ///< nearer than min_range_m
  kTooFar,     ///< farther than max_range_m
  kOutsideMap,
  kSaturated,  ///< its voxel holds as many points as exact sums allow; labelled all the same
};
constexpr int kPointDrops = 5;
const char* pointDropName(PointDrop reason);

/// Stages of a scan, in order.
enum class Stage { kRead, kInsert, kSum, kClassify, kLabel };
constexpr int kStages = 5;
const char* stageName(Stage stage);

/// What happened to one scan.
struct ScanReport {
  std::size_t points_in = 0;
  std::size_t points_inserted = 0;  ///< points_in minus all drops
  std::array<std::size_t, kPointDrops> dropped{};
  std::array<double, kStages> stage_ms{};
  std::vector<std::size_t> label_counts;  ///< of points, by label: unknown, then the classes
  std::size_t occupied_voxels = 0;
  std::size_t memory_bytes = 0;  ///< map, sums and per-voxel results
};

/// What is known of one occupied voxel.
struct VoxelResult {
  Saliency saliency;
  Classification classification;
};

/// Labels ladar scans by a scrolling voxel map (Lalonde, Vandapel, Hebert 2005).
class TerrainPipeline {
 public:
  /// `config` for which `validate()` is empty and that `model` fits (`modelMisfit`).
  TerrainPipeline(const TerrainConfig& config, const ClassifierModel& model);

  /// Takes one scan: centres the map on `p_map_vehicle`, inserts the points at the places the
  /// sensor's motion puts them (`time_offsets_s` per point; empty: all at the stamp), sums the
  /// moments over every occupied voxel's support volume, classifies the voxels, labels the points.
  /// Every coordinate of the motion and of `p_map_vehicle` must be finite and within
  /// kMaxCoordinate_m / 2. `fields` must come from findPointFields for this very cloud.
  const ScanReport& process(const CloudView& cloud, const PointFields& fields,
                            const std::vector<float>& time_offsets_s, const SensorMotion& motion,
                            const Eigen::Vector3d& p_map_vehicle);
  /// Forgets all points.
  void reset();

  const TerrainConfig& config() const { return config_; }
  const ClassifierModel& model() const { return model_; }
  const VoxelMap& map() const { return map_; }
  const ScanReport& report() const { return report_; }
  /// Of the last scan's points, in message order.
  const std::vector<PointLabel>& pointLabels() const { return point_labels_; }
  /// Voxel of each of the last scan's points (kNoCell if it is in none), and its row below.
  const std::vector<CellId>& pointCells() const { return point_cells_; }
  /// Order of the voxels in `voxels()`.
  const VoxelOrder& voxelOrder() const { return order_; }
  const std::vector<VoxelResult>& voxels() const { return voxels_; }

 private:
  void insertPoints(const std::vector<float>& time_offsets_s, const SensorMotion& motion);
  void scrollTo(const Eigen::Vector3d& p_map_vehicle);
  void classifyVoxels();
  void classifyRows(std::size_t begin, std::size_t end);
  void labelPoints();

  TerrainConfig config_;
  ClassifierModel model_;
  Classifier classifier_;
  ThreadPool pool_;
  VoxelMap map_;
  SlidingBoxSums box_sums_;
  MotionTable motion_table_;
  VoxelOrder order_;
  ScanReport report_;
  std::vector<Eigen::Vector3d> positions_m_;  // in the sensor frame
  std::vector<CellId> point_cells_;
  std::vector<PointLabel> point_labels_;
  std::vector<VoxelIndex> voxel_indices_;
  std::vector<Moments> sums_;
  std::vector<VoxelResult> voxels_;
};

}  // namespace ladar_perception
