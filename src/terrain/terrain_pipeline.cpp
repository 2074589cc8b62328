// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/terrain/terrain_pipeline.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

namespace ladar_perception {
namespace {

using Clock = std::chrono::steady_clock;

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
    case Stage::kLabel:
      return "label";
  }
  return "";
}

TerrainPipeline::TerrainPipeline(const TerrainConfig& config, const ClassifierModel& model)
    : config_(config),
      model_(model),
      classifier_(model),
      pool_(config.threads),
      map_(config.mapShape(), maxPointsPerVoxel(config.support_radius_voxels)),
      box_sums_(config.support_radius_voxels) {
  assert(config.validate().empty());
  assert(modelMisfit(model, config.voxel_size_m, config.support_radius_voxels).empty());
}

const ScanReport& TerrainPipeline::process(const CloudView& cloud, const PointFields& fields,
                                           const std::vector<float>& time_offsets_s,
                                           const SensorMotion& motion,
                                           const Eigen::Vector3d& p_map_vehicle) {
  report_ = ScanReport();
  StageTimer timer(&report_.stage_ms);
  readPositions(cloud, fields, &positions_m_);
  assert(time_offsets_s.empty() || time_offsets_s.size() == positions_m_.size());
  timer.endOf(Stage::kRead);

  scrollTo(p_map_vehicle);
  insertPoints(time_offsets_s, motion);
  timer.endOf(Stage::kInsert);

  order_.update(map_);
  box_sums_.compute(map_, order_, &pool_, &sums_);
  timer.endOf(Stage::kSum);

  classifyVoxels();
  timer.endOf(Stage::kClassify);

  labelPoints();
  timer.endOf(Stage::kLabel);

  report_.occupied_voxels = map_.occupied();
  report_.memory_bytes =
      map_.memoryBytes() + box_sums_.memoryBytes() + sums_.capacity() * sizeof(Moments) +
      voxels_.capacity() * sizeof(VoxelResult) + voxel_indices_.capacity() * sizeof(VoxelIndex);
  return report_;
}

void TerrainPipeline::reset() {
  map_.clear();
  order_.update(map_);
  sums_.clear();
  voxels_.clear();
  voxel_indices_.clear();
  point_cells_.clear();
  point_labels_.clear();
  report_ = ScanReport();
}

void TerrainPipeline::scrollTo(const Eigen::Vector3d& p_map_vehicle) {
  const Eigen::Vector3d p_map_center =
      p_map_vehicle + Eigen::Vector3d(0.0, 0.0, config_.map_center_height_m);
  const VoxelIndex center = voxelOf(
      toFixedPoint(p_map_center, static_cast<double>(kStepsPerVoxel) / config_.voxel_size_m));
  const MapShape& shape = map_.shape();
  map_.scrollTo({center.x - shape.nx / 2, center.y - shape.ny / 2, center.z - shape.nz / 2});
}

void TerrainPipeline::insertPoints(const std::vector<float>& time_offsets_s,
                                   const SensorMotion& motion) {
  motion_table_.assign(motion);
  const Eigen::Isometry3d T_map_sensor = motion.poseAt(0.0);
  const double steps_per_m = static_cast<double>(kStepsPerVoxel) / config_.voxel_size_m;
  const double min_squared = config_.min_range_m * config_.min_range_m;
  const double max_squared = config_.max_range_m * config_.max_range_m;
  report_.points_in = positions_m_.size();
  point_cells_.assign(positions_m_.size(), kNoCell);
  const auto drop = [&](PointDrop reason) { ++report_.dropped[static_cast<int>(reason)]; };
  for (std::size_t i = 0; i < positions_m_.size(); ++i) {
    const Eigen::Vector3d& p_sensor = positions_m_[i];
    const double range_squared = p_sensor.squaredNorm();
    if (!p_sensor.allFinite()) {
      drop(PointDrop::kNotFinite);
    } else if (range_squared < min_squared) {
      drop(PointDrop::kTooNear);
    } else if (range_squared > max_squared) {
      drop(PointDrop::kTooFar);
    } else {
      const Eigen::Vector3d p_map = time_offsets_s.empty()
                                        ? T_map_sensor * p_sensor
                                        : motion_table_.nearest(time_offsets_s[i]) * p_sensor;
      const auto result = map_.insert(toFixedPoint(p_map, steps_per_m), &point_cells_[i]);
      if (result == VoxelMap::InsertResult::kInserted) {
        ++report_.points_inserted;
      } else {
        drop(result == VoxelMap::InsertResult::kOutside ? PointDrop::kOutsideMap
                                                        : PointDrop::kSaturated);
      }
    }
  }
}

void TerrainPipeline::classifyVoxels() {
  order_.listVoxels(map_, &voxel_indices_);
  voxels_.resize(order_.rows);
  pool_.run([&](int share) {
    const std::size_t shares = pool_.size();
    classifyRows(order_.rows * share / shares, order_.rows * (share + 1) / shares);
  });
}

void TerrainPipeline::classifyRows(std::size_t begin, std::size_t end) {
  constexpr std::size_t kBlock = kSaliencyBlock;
  const double step_m = config_.voxel_size_m / static_cast<double>(kStepsPerVoxel);
  const auto& features = classifier_.features();
  FeatureBlock block(static_cast<int>(features.size()));
  std::array<CenteredMoments, kBlock> moments;
  std::array<Saliency, kBlock> saliency;
  std::array<Classification, kBlock> classified;
  for (std::size_t first = begin; first < end; first += kBlock) {
    const int count = static_cast<int>(std::min(kBlock, end - first));
    for (int i = 0; i < count; ++i) {
      moments[i] = sums_[first + i].about(centerOf(voxel_indices_[first + i]));
    }
    saliencyOfBlock(moments.data(), count, step_m, saliency.data());
    for (std::size_t f = 0; f < features.size(); ++f) {
      featureValues(features[f], saliency.data(), count, block.row(static_cast<int>(f)));
    }
    classifier_.classify(block, count, classified.data());
    for (int i = 0; i < count; ++i) {
      const bool supported =
          saliency[i].defined &&
          saliency[i].points >= static_cast<uint32_t>(config_.min_support_points);
      voxels_[first + i] = {saliency[i], supported ? classified[i] : Classification()};
    }
  }
}

void TerrainPipeline::labelPoints() {
  std::array<uint32_t, kMaxClasses + 1> colors{};
  for (std::size_t label = 0; label <= model_.classes.size(); ++label) {
    colors[label] = model_.labelColor(static_cast<uint8_t>(label));
  }
  report_.label_counts.assign(model_.classes.size() + 1, 0);
  point_labels_.resize(point_cells_.size());
  for (std::size_t i = 0; i < point_cells_.size(); ++i) {
    Classification result;
    if (point_cells_[i] != kNoCell) {
      result = voxels_[order_.rowOf(map_, point_cells_[i])].classification;
    }
    point_labels_[i] = {result.label, result.confidence, colors[result.label]};
    ++report_.label_counts[result.label];
  }
}

}  // namespace ladar_perception
