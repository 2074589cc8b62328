// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/terrain/terrain_pipeline.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

#include "ladar_perception/util/dispatch.h"

namespace ladar_perception {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kPointBlock = 256;

/// Adds the time since the last call to a stage.
class StageTimer {
 public:
  explicit StageTimer(std::array<double, kStages>* stage_ms) : stage_ms_(stage_ms) {}
  void endOf(Stage stage) {
    const auto now = Clock::now();
    (*stage_ms_)[static_cast<int>(stage)] =
        std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  std::array<double, kStages>* stage_ms_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace

const char* pointDropName(PointDrop reason) {
  switch (reason) {
    case PointDrop::kNotFinite:
      return "not_finite";
    case PointDrop::kTooNear:
      return "too_near";
    case PointDrop::kTooFar:
      return "too_far";
    case PointDrop::kOutsideMap:
      return "outside_map";
    case PointDrop::kSaturated:
      return "saturated";
  }
  return "";
}

const char* stageName(Stage stage) {
  switch (stage) {
    case Stage::kRead:
      return "read";
    case Stage::kInsert:
      return "insert";
    case Stage::kSum:
      return "sum";
    case Stage::kClassify:
      return "classify";
    case Stage::kSmooth:
      return "smooth";
    case Stage::kLabel:
      return "label";
  }
  return "";
}

/// Turns box sums into features and posteriors, a block of voxels at a time: the output of
/// SlidingBoxSums and BoxStackSums. Call flush() when the last sums are there.
class TerrainPipeline::VoxelClassifier {
 public:
  explicit VoxelClassifier(TerrainPipeline* pipeline)
      : pipeline_(*pipeline),
        map_(pipeline->map_),
        step_m_(pipeline->config_.voxel_size_m / static_cast<double>(kStepsPerVoxel)),
        sums_(1 + pipeline->plan_.boxes.size()),
        shapes_(sums_.size()),
        features_(static_cast<int>(pipeline->classifier_.features().size())) {}

  LADAR_INLINE Moments& place(std::size_t slot, int x, int y, int z) {
    if (count_ == kSaliencyBlock) flush();
    const VoxelIndex& min = map_.minCorner();
    voxels_[count_] = {min.x + x, min.y + y, min.z + z};
    slots_[count_] = static_cast<uint32_t>(slot);
    // Where the results go is on its way from memory until the block is full.
    const SaliencyF* saliency = &pipeline_.saliencies_[slot];
    __builtin_prefetch(saliency, 1);
    __builtin_prefetch(reinterpret_cast<const char*>(saliency + 1) - 1, 1);
    __builtin_prefetch(&pipeline_.classifications_[slot], 1);
    return sums_[0][count_++];
  }

  /// As BoxStackSums wants it: the sums over the boxes of the configured support, the widest first,
  /// then over the others of the plan.
  LADAR_INLINE void accept(std::size_t slot, int x, int y, int z, const Moments* sums) {
    const BoxStack& stack = pipeline_.stack_;
    place(slot, x, y, z) = weightedSum(stack, sums);
    points_[count_ - 1] = sums[0].count();
    for (std::size_t i = 1; i < sums_.size(); ++i) {
      sums_[i][count_ - 1] = sums[stack.size() + i - 1];
    }
  }

  /// Out of the way of the loop over sums, which it would make slower.
  __attribute__((noinline)) void flush() {
    const auto begin = Clock::now();
    if (count_ > 0) classifyBlock();
    voxels_done_ += count_;
    count_ = 0;
    duration_ms_ += std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  }

  std::size_t voxelsDone() const { return voxels_done_; }
  double milliseconds() const { return duration_ms_; }

 private:
  void classifyBlock() {
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      saliencyOfBlock(sums_[i].data(), voxels_, count_, step_m_, &shapes_[i]);
    }
    // A weighted sum's count is not one of points.
    if (pipeline_.stack_.size() > 1) std::copy_n(points_, count_, shapes_[0].points);
    computeFeatures();
    LabelSmoother* smoother = pipeline_.smoother_.get();
    const auto temperature = smoother != nullptr
                                 ? smoother->temperature()
                                 : static_cast<float>(pipeline_.model_.calibration.temperature);
    pipeline_.classifier_.posteriors(features_, temperature, &posterior_);
    const auto least = static_cast<uint32_t>(pipeline_.config_.min_support_points);
    for (int i = 0; i < count_; ++i) {
      shapes_[0].get(i, &pipeline_.saliencies_[slots_[i]]);
      const bool supported = shapes_[0].defined[i] != 0 && shapes_[0].points[i] >= least;
      if (!supported) posterior_.known[i] = 0;
    }
    if (smoother != nullptr) {
      smoother->keep(posterior_, slots_, count_);
    } else {
      Classification classified[kSaliencyBlock];
      pipeline_.classifier_.choose(posterior_, count_, classified);
      for (int i = 0; i < count_; ++i) pipeline_.classifications_[slots_[i]] = classified[i];
    }
    if (pipeline_.keep_features_) keepFeatures();
  }

  void computeFeatures() {
    const FeaturePlan& plan = pipeline_.plan_;
    const auto& features = pipeline_.classifier_.features();
    for (std::size_t f = 0; f < features.size(); ++f) {
      float* values = features_.row(static_cast<int>(f));
      if (!isOfColumns(features[f].quantity)) {
        featureValues(features[f].quantity, shapes_[plan.source[f]], values);
        continue;
      }
      int32_t numbers[kSaliencyBlock] = {};
      lookUp(plan.layers[plan.source[f]], numbers);
      columnFeatureValues(features[f].quantity, numbers, pipeline_.config_.voxel_size_m, values);
    }
  }

  void lookUp(const ColumnLayer& layer, int32_t* numbers) const {
    const VoxelIndex& min = map_.minCorner();
    for (int i = 0; i < count_; ++i) {
      const int32_t value = layer.at(voxels_[i].x - min.x, voxels_[i].y - min.y);
      numbers[i] = layer.quantity() == ColumnQuantity::kFill ? value : voxels_[i].z - value;
    }
  }

  void keepFeatures() {
    const std::size_t features = pipeline_.classifier_.features().size();
    for (int i = 0; i < count_; ++i) {
      float* kept = pipeline_.kept_features_.data() + slots_[i] * features;
      for (std::size_t f = 0; f < features; ++f) kept[f] = features_.row(static_cast<int>(f))[i];
    }
  }

  TerrainPipeline& pipeline_;
  const VoxelMap& map_;
  double step_m_;
  int count_ = 0;
  // Of the configured support and of the plan's boxes.
  std::vector<std::array<Moments, kSaliencyBlock>> sums_;
  std::vector<SaliencyBlock> shapes_;
  VoxelIndex voxels_[kSaliencyBlock];
  uint32_t slots_[kSaliencyBlock];
  uint32_t points_[kSaliencyBlock];  // of several boxes only
  FeatureBlock features_;
  PosteriorBlock posterior_;
  std::size_t voxels_done_ = 0;
  double duration_ms_ = 0.0;
};

TerrainPipeline::TerrainPipeline(const TerrainConfig& config, const ClassifierModel& model)
    : config_(config),
      model_(model),
      classifier_(model),
      pool_(config.threads),
      map_(config.mapShape(), FeaturePlan(model.features).maxPointsPerVoxel(config.supportStack())),
      stack_(config.supportStack()),
      plan_(model.features) {
  assert(config.validate().empty());
  assert(
      modelMisfit(model, config.voxel_size_m, config.support_radius_voxels, config.support_kernel)
          .empty());
  std::vector<SupportBox> boxes;
  for (const WeightedBox& weighted : stack_) boxes.push_back(weighted.box);
  boxes.insert(boxes.end(), plan_.boxes.begin(), plan_.boxes.end());
  for (int i = 0; i < config.threads; ++i) {
    if (boxes.size() == 1) {
      box_sums_.emplace_back(boxes[0]);
    } else {
      stack_sums_.emplace_back(boxes);
    }
  }
  if (config.forget_after_s > 0.0 || config.forget_after_scans > 0) {
    slices_ = EvidenceSlices(config.mapShape(), plan_.maxPointsPerVoxel(stack_));
  }
  if (config.smooth_labels) {
    smoother_ = LabelSmoother::make(classifier_, model_.calibration, config.threads);
    near_changes_.resize(map_.shape().nx, map_.shape().ny);
  }
}

const ScanReport& TerrainPipeline::process(const CloudView& cloud, const PointFields& fields,
                                           const std::vector<float>& time_offsets_s,
                                           const SensorMotion& motion,
                                           const Eigen::Vector3d& p_map_vehicle, double stamp_s) {
  report_ = ScanReport();
  StageTimer timer(&report_.stage_ms);
  readPositions(cloud, fields, &positions_m_);
  assert(time_offsets_s.empty() || time_offsets_s.size() == positions_m_.size());
  timer.endOf(Stage::kRead);

  scrollTo(p_map_vehicle);
  forgetOldPoints(stamp_s);
  insertPoints(time_offsets_s, motion);
  timer.endOf(Stage::kInsert);

  const int reach = plan_.reach(stack_);
  affected_.assignAffected(map_, reach);
  for (ColumnLayer& layer : plan_.layers) {
    layer.update(map_, [&](int x, int y) { affected_.add(x, y); });
  }
  if (smoother_ != nullptr) {
    // What has left the window was averaged into labels farther in than any feature looks.
    const bool labels_see_farther = smoother_->radius() > reach;
    if (labels_see_farther) near_changes_.assignAffected(map_, smoother_->radius());
  }
  map_.forgetChanges();
  updateVoxels();
  timer.endOf(Stage::kSum);
  report_.stage_ms[static_cast<int>(Stage::kSum)] -=
      report_.stage_ms[static_cast<int>(Stage::kClassify)];
  smoothLabels();
  timer.endOf(Stage::kSmooth);

  labelPoints();
  timer.endOf(Stage::kLabel);

  report_.occupied_voxels = map_.occupied();
  report_.memory_bytes = memoryBytes();
  return report_;
}

void TerrainPipeline::reset() {
  map_.clear();
  slices_.clear();
  scans_ = 0;
  point_cells_.clear();
  point_labels_.clear();
  report_ = ScanReport();
}

void TerrainPipeline::keepFeatures(bool keep) {
  keep_features_ = keep;
  if (!keep) std::vector<float>().swap(kept_features_);  // which also gives the memory back
}

void TerrainPipeline::scrollTo(const Eigen::Vector3d& p_map_vehicle) {
  const Eigen::Vector3d p_map_center =
      p_map_vehicle + Eigen::Vector3d(0.0, 0.0, config_.map_center_height_m);
  const VoxelIndex center = voxelOf(
      toFixedPoint(p_map_center, static_cast<double>(kStepsPerVoxel) / config_.voxel_size_m));
  const MapShape& shape = map_.shape();
  const VoxelIndex min = {center.x - shape.nx / 2, center.y - shape.ny / 2,
                          center.z - shape.nz / 2};
  map_.scrollTo(min);
  slices_.scrollTo(min);
}

void TerrainPipeline::forgetOldPoints(double stamp_s) {
  if (!slices_.enabled()) return;
  const double lifetimes = config_.forget_after_s > 0.0
                               ? std::max(stamp_s, 0.0) / config_.forget_after_s
                               : static_cast<double>(scans_) / config_.forget_after_scans;
  slices_.advance(lifetimes, &map_);
  ++scans_;
}

void TerrainPipeline::insertPoints(const std::vector<float>& time_offsets_s,
                                   const SensorMotion& motion) {
  report_.points_in = positions_m_.size();
  point_cells_.resize(positions_m_.size());
  motion_table_.assign(time_offsets_s.empty() ? SensorMotion(motion.poseAt(0.0)) : motion);
  const float* offsets_s = time_offsets_s.empty() ? nullptr : time_offsets_s.data();
  VoxelMap* slice = slices_.enabled() ? &slices_.current() : nullptr;
  dispatch([&]() LADAR_INLINE_LAMBDA {
    for (std::size_t first = 0; first < positions_m_.size(); first += kPointBlock) {
      const std::size_t count = std::min(kPointBlock, positions_m_.size() - first);
      FixedPoint q[kPointBlock];
      locatePoints(positions_m_.data() + first, offsets_s == nullptr ? nullptr : offsets_s + first,
                   count, q, point_cells_.data() + first);
      insertLocated(q, point_cells_.data() + first, count, slice);
    }
  });
}

/// Where `count` points lie in the map; dropped ones are counted and in no cell.
LADAR_INLINE void TerrainPipeline::locatePoints(const Eigen::Vector3d* p_sensor,
                                                const float* offsets_s, std::size_t count,
                                                FixedPoint* q, CellId* cells) {
  const double steps_per_m = static_cast<double>(kStepsPerVoxel) / config_.voxel_size_m;
  const double min_squared = config_.min_range_m * config_.min_range_m;
  const double max_squared = config_.max_range_m * config_.max_range_m;
  for (std::size_t i = 0; i < count; ++i) {
    cells[i] = kNoCell;
    const double range_squared = p_sensor[i].squaredNorm();
    if (!(range_squared >= min_squared && range_squared <= max_squared)) {
      drop(!p_sensor[i].allFinite()      ? PointDrop::kNotFinite
           : range_squared < min_squared ? PointDrop::kTooNear
                                         : PointDrop::kTooFar);
      continue;
    }
    const Eigen::Isometry3d& T_map_sensor =
        motion_table_.nearest(offsets_s == nullptr ? 0.0F : offsets_s[i]);
    const Eigen::Vector3d p_map = T_map_sensor * p_sensor[i];
    q[i] = toFixedPoint(p_map, steps_per_m);
    cells[i] = map_.cellOf(q[i]);
    if (cells[i] == kNoCell) {
      drop(PointDrop::kOutsideMap);
    } else {
      map_.prefetchColumn(cells[i]);
    }
  }
}

LADAR_INLINE void TerrainPipeline::insertLocated(const FixedPoint* q, const CellId* cells,
                                                 std::size_t count, VoxelMap* slice) {
  constexpr std::size_t kAhead = 12;  // points whose records are on their way
  for (std::size_t i = 0; i < count; ++i) {
    if (i + kAhead < count && cells[i + kAhead] != kNoCell) map_.prefetchRecord(cells[i + kAhead]);
    if (cells[i] == kNoCell) continue;
    if (map_.insertAt(cells[i], q[i]) == InsertResult::kSaturated) {
      drop(PointDrop::kSaturated);
      continue;
    }
    ++report_.points_inserted;
    if (slice != nullptr) slice->insertAt(cells[i], q[i]);
  }
}

void TerrainPipeline::updateAllVoxels() {
  affected_.assignAll(map_.shape().nx, map_.shape().ny);
  updateVoxels();
  smoothLabels();
}

void TerrainPipeline::smoothLabels() {
  if (smoother_ == nullptr) return;
  relabelled_.assignDilated(affected_, smoother_->radius());
  relabelled_.add(near_changes_);
  smoother_->label(map_, relabelled_, &pool_, &classifications_);
}

void TerrainPipeline::updateVoxels() {
  saliencies_.resize(map_.slotBound());
  classifications_.resize(map_.slotBound());
  if (keep_features_) kept_features_.resize(map_.slotBound() * model_.features.size());
  if (smoother_ != nullptr) smoother_->resize(map_.slotBound());
  const std::vector<int> rows = shareRows(map_, affected_, pool_.size());
  std::vector<VoxelClassifier> classifiers(pool_.size(), VoxelClassifier(this));
  pool_.run([&](int share) {
    if (stack_sums_.empty()) {
      box_sums_[share].compute(map_, affected_, rows[share], rows[share + 1], classifiers[share]);
    } else {
      stack_sums_[share].compute(map_, affected_, rows[share], rows[share + 1], classifiers[share]);
    }
    classifiers[share].flush();
  });
  double classify_ms = 0.0;
  report_.updated_voxels = 0;
  for (const VoxelClassifier& classifier : classifiers) {
    report_.updated_voxels += classifier.voxelsDone();
    classify_ms += classifier.milliseconds() / pool_.size();
  }
  report_.stage_ms[static_cast<int>(Stage::kClassify)] = classify_ms;
}

void TerrainPipeline::labelPoints() {
  std::array<uint32_t, kMaxClasses + 1> colors{};
  for (std::size_t label = 0; label <= model_.classes.size(); ++label) {
    colors[label] = model_.labelColor(static_cast<uint8_t>(label));
  }
  std::array<std::size_t, kMaxClasses + 1> counts{};
  point_labels_.resize(point_cells_.size());
  dispatch([&]() LADAR_INLINE_LAMBDA {
    for (std::size_t i = 0; i < point_cells_.size(); ++i) {
      Classification result;
      if (point_cells_[i] != kNoCell) result = classifications_[map_.slotOf(point_cells_[i])];
      point_labels_[i] = {result.label, result.confidence, colors[result.label]};
      ++counts[result.label];
    }
  });
  report_.label_counts.assign(counts.begin(), counts.begin() + model_.classes.size() + 1);
}

std::size_t TerrainPipeline::memoryBytes() const {
  std::size_t bytes = map_.memoryBytes() + slices_.memoryBytes() +
                      saliencies_.capacity() * sizeof(SaliencyF) +
                      classifications_.capacity() * sizeof(Classification) +
                      kept_features_.capacity() * sizeof(float);
  if (smoother_ != nullptr) bytes += smoother_->memoryBytes();
  for (const ColumnLayer& layer : plan_.layers) bytes += layer.memoryBytes();
  for (const auto& box_sums : box_sums_) bytes += box_sums.memoryBytes();
  for (const auto& stack_sums : stack_sums_) bytes += stack_sums.memoryBytes();
  return bytes;
}

}  // namespace ladar_perception
