// SPDX-License-Identifier: BSD-3-Clause
// The terrain method as one façade: a scan in, labels of its points and of the map's voxels out.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/classify/label_smoother.h"
#include "ladar_perception/cloud/labeled_cloud.h"
#include "ladar_perception/cloud/point_reader.h"
#include "ladar_perception/cloud/sensor_motion.h"
#include "ladar_perception/map/column_set.h"
#include "ladar_perception/map/evidence_slices.h"
#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/saliency/box_stack.h"
#include "ladar_perception/saliency/saliency.h"
#include "ladar_perception/terrain/feature_plan.h"
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
enum class Stage { kRead, kInsert, kSum, kClassify, kSmooth, kLabel };
constexpr int kStages = 6;
const char* stageName(Stage stage);

/// What happened to one scan.
struct ScanReport {
  std::size_t points_in = 0;
  std::size_t points_inserted = 0;  ///< points_in minus all drops
  std::array<std::size_t, kPointDrops> dropped{};
  std::array<double, kStages> stage_ms{};
  std::vector<std::size_t> label_counts;  ///< of points, by label: unknown, then the classes
  std::size_t occupied_voxels = 0;
  std::size_t updated_voxels = 0;  ///< of them, computed anew: the scan could have changed them
  std::size_t memory_bytes = 0;    ///< map, sums and per-voxel results
};

/// Labels ladar scans by a scrolling voxel map (Lalonde, Vandapel, Hebert 2005).
class TerrainPipeline {
 public:
  /// `config` for which `validate()` is empty and that `model` fits (`modelMisfit`).
  TerrainPipeline(const TerrainConfig& config, const ClassifierModel& model);

  /// Takes one scan: centres the map on `p_map_vehicle`, inserts the points at the places the
  /// sensor's motion puts them (`time_offsets_s` per point; empty: all at the stamp), forgets what
  /// is too old, sums the moments over the support volumes, classifies the voxels, smooths their
  /// labels, labels the points. Only voxels whose features can have changed are computed anew; what
  /// is known of all of them is the same, bit by bit, as if all were. `stamp_s` is looked at only
  /// for forgetting. Every coordinate of the motion and of `p_map_vehicle` must be finite and
  /// within kMaxCoordinate_m / 2. `fields` must come from findPointFields for this very cloud.
  const ScanReport& process(const CloudView& cloud, const PointFields& fields,
                            const std::vector<float>& time_offsets_s, const SensorMotion& motion,
                            const Eigen::Vector3d& p_map_vehicle, double stamp_s = 0.0);
  /// Computes every voxel anew, not only those a scan has changed. Changes nothing that is known;
  /// for measuring, and to compare with.
  void updateAllVoxels();
  /// Forgets all points.
  void reset();

  /// Whether the features of voxels computed from now on are kept (false at first). They are for
  /// learning and looking at; labels need none of it, and while off it costs nothing.
  void keepFeatures(bool keep);

  const TerrainConfig& config() const { return config_; }
  const ClassifierModel& model() const { return model_; }
  const VoxelMap& map() const { return map_; }
  const ScanReport& report() const { return report_; }
  /// Of the last scan's points, in message order.
  const std::vector<PointLabel>& pointLabels() const { return point_labels_; }
  /// Voxel of each of the last scan's points, kNoCell if it is in none.
  const std::vector<CellId>& pointCells() const { return point_cells_; }
  /// What is known of the occupied voxel whose record lies at this slot of the map.
  const SaliencyF& saliency(std::size_t slot) const { return saliencies_[slot]; }
  const Classification& classification(std::size_t slot) const { return classifications_[slot]; }
  /// What the classifier saw of the occupied voxel at this slot: one value per feature of the
  /// model, in its order. Only while features are kept, and of no meaning where
  /// `saliency(slot).defined` is false.
  const float* features(std::size_t slot) const {
    return kept_features_.data() + slot * model_.features.size();
  }
  /// What smoothing multiplies, for calibration: logarithms of the voxel's posterior and of the
  /// means by radius, each by class. Only while features are kept and labels smoothed.
  const float* smoothingTerms(std::size_t slot) const {
    const std::size_t terms = model_.calibration.smoothing.exponents.size();
    return kept_terms_.data() + slot * terms * model_.classes.size();
  }

 private:
  class VoxelClassifier;

  void insertPoints(const std::vector<float>& time_offsets_s, const SensorMotion& motion);
  void locatePoints(const Eigen::Vector3d* p_sensor, const float* offsets_s, std::size_t count,
                    FixedPoint* q, CellId* cells);
  void insertLocated(const FixedPoint* q, const CellId* cells, std::size_t count, VoxelMap* slice);
  void drop(PointDrop reason) { ++report_.dropped[static_cast<int>(reason)]; }
  void scrollTo(const Eigen::Vector3d& p_map_vehicle);
  void forgetOldPoints(double stamp_s);
  /// Of the columns in `affected_`.
  void updateVoxels();
  void smoothLabels();
  void labelPoints();
  std::size_t memoryBytes() const;

  TerrainConfig config_;
  ClassifierModel model_;
  Classifier classifier_;
  ThreadPool pool_;
  VoxelMap map_;
  EvidenceSlices slices_;
  uint64_t scans_ = 0;  // since the last reset
  BoxStack stack_;
  FeaturePlan plan_;
  // One per thread: of the first for a single box, of the second for several.
  std::vector<SlidingBoxSums<Moments>> box_sums_;
  std::vector<BoxStackSums<Moments>> stack_sums_;
  MotionTable motion_table_;
  ScanReport report_;
  std::vector<Eigen::Vector3d> positions_m_;  // in the sensor frame
  std::vector<CellId> point_cells_;
  std::vector<PointLabel> point_labels_;
  ColumnSet affected_;
  std::vector<SaliencyF> saliencies_;            // by slot of the map
  std::vector<Classification> classifications_;  // by slot of the map
  std::unique_ptr<LabelSmoother> smoother_;      // none without smoothing
  ColumnSet relabelled_;
  ColumnSet near_changes_;  // empty while labels see no farther than features
  bool keep_features_ = false;
  std::vector<float> kept_features_;  // by slot of the map, then by feature of the model
  std::vector<float> kept_terms_;     // by slot of the map, then by exponent, then by class
};

}  // namespace ladar_perception
