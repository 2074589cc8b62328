// SPDX-License-Identifier: BSD-3-Clause
// What a terrain pipeline has to know of its voxels, computed anew from the records of its map.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <utility>
#include <vector>

#include "column_layer_oracle.h"
#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/saliency/box_sums.h"
#include "ladar_perception/saliency/features.h"
#include "ladar_perception/terrain/terrain_config.h"
#include "posterior_average.h"
#include "terrain_comparisons.h"

namespace ladar_perception::test {

/// What has to be known of the voxels of a map, from its records alone.
class Recomputation {
 public:
  struct Voxel {
    SaliencyF saliency;
    std::vector<float> features;
    std::vector<uint16_t> posterior;  ///< at the smoothing's temperature; all 0: unknown
    Classification classification;
  };

  Recomputation(const TerrainConfig& config, const ClassifierModel& model)
      : config_(config), stack_(config.supportStack()), model_(model), classifier_(model_) {}

  /// One voxel alone, by as many look-ups as there are voxels in the support volumes. With
  /// smoothing its class is that of its own posterior.
  Voxel of(const VoxelMap& map, const VoxelIndex& center) const {
    Volume volume;
    volume.voxel = center;
    for (const WeightedBox& weighted : stack_) {
      const Moments sum = boxSum(map, center, weighted.box);
      if (volume.points == 0) volume.points = sum.count();  // the widest box is the first
      for (uint32_t i = 0; i < weighted.weight; ++i) volume.configured += sum;
    }
    const ColumnLayerOracle oracle(map);
    for (const Feature& feature : model_.features) {
      const bool of_columns = isOfColumns(feature.quantity);
      const bool of_box = !of_columns && !feature.isOfConfiguredSupport();
      volume.sums.push_back(of_box ? boxSum(map, center, feature.box) : volume.configured);
      volume.numbers.push_back(of_columns ? number(oracle, map.minCorner(), center, feature) : 0);
    }
    return classify({volume}).front();
  }
  /// All voxels by slot, from sums over the whole map: in other blocks than the pipeline's.
  std::vector<Voxel> ofAll(const VoxelMap& map) const {
    auto voxels = listVoxels(map);
    std::reverse(voxels.begin(), voxels.end());
    const std::vector<Volume> volumes = sumAll(map);
    std::vector<Voxel> result(map.slotBound());
    for (std::size_t first = 0; first < voxels.size(); first += kSaliencyBlock) {
      std::vector<Volume> block;
      const std::size_t end = std::min(first + kSaliencyBlock, voxels.size());
      for (std::size_t i = first; i < end; ++i) block.push_back(volumes[voxels[i].second]);
      std::vector<Voxel> known = classify(block);
      for (std::size_t i = first; i < end; ++i) {
        result[voxels[i].second] = std::move(known[i - first]);
      }
    }
    if (config_.smooth_labels) smooth(map, &result);
    return result;
  }

 private:
  /// All that a voxel's features are computed from.
  struct Volume {
    VoxelIndex voxel;
    Moments configured;  // weighted
    uint32_t points = 0;
    std::vector<Moments> sums;     // by feature, of its own box
    std::vector<int32_t> numbers;  // by feature, of columns
  };
  struct SumTable {
    std::vector<Moments> sums;
    Moments& place(std::size_t slot, int /*x*/, int /*y*/, int /*z*/) { return sums[slot]; }
  };

  static Moments boxSum(const VoxelMap& map, const VoxelIndex& center, const SupportBox& box) {
    Moments sum;
    for (int dx = -box.radius_xy; dx <= box.radius_xy; ++dx) {
      for (int dy = -box.radius_xy; dy <= box.radius_xy; ++dy) {
        for (int dz = -box.radius_z; dz <= box.radius_z; ++dz) {
          const Moments* record = map.find({center.x + dx, center.y + dy, center.z + dz});
          if (record != nullptr) sum += *record;
        }
      }
    }
    return sum;
  }
  static std::vector<Moments> boxSums(const VoxelMap& map, const SupportBox& box) {
    ColumnSet columns;
    columns.assignAll(map.shape().nx, map.shape().ny);
    SumTable table{std::vector<Moments>(map.slotBound())};
    SlidingBoxSums<Moments>(box).compute(map, columns, 0, map.shape().ny, table);
    return table.sums;
  }
  static int32_t number(const ColumnLayerOracle& oracle, const VoxelIndex& min,
                        const VoxelIndex& voxel, const Feature& feature) {
    const ColumnQuantity quantity = columnQuantity(feature.quantity);
    const int32_t value =
        oracle.at(quantity, feature.box.radius_xy, voxel.x - min.x, voxel.y - min.y);
    return quantity == ColumnQuantity::kFill ? value : voxel.z - value;
  }

  /// By slot.
  std::vector<Volume> sumAll(const VoxelMap& map) const {
    std::vector<Volume> volumes(map.slotBound());
    const auto voxels = listVoxels(map);
    for (std::size_t i = 0; i < stack_.size(); ++i) {
      const std::vector<Moments> sums = boxSums(map, stack_[i].box);
      for (const auto& [voxel, slot] : voxels) {
        Volume& volume = volumes[slot];
        volume.voxel = voxel;
        if (i == 0) volume.points = sums[slot].count();
        for (uint32_t j = 0; j < stack_[i].weight; ++j) volume.configured += sums[slot];
      }
    }
    const ColumnLayerOracle oracle(map);
    for (const Feature& feature : model_.features) {
      const bool of_columns = isOfColumns(feature.quantity);
      const bool of_box = !of_columns && !feature.isOfConfiguredSupport();
      const std::vector<Moments> sums = of_box ? boxSums(map, feature.box) : std::vector<Moments>();
      for (const auto& [voxel, slot] : voxels) {
        Volume& volume = volumes[slot];
        volume.sums.push_back(of_box ? sums[slot] : volume.configured);
        volume.numbers.push_back(of_columns ? number(oracle, map.minCorner(), voxel, feature) : 0);
      }
    }
    return volumes;
  }

  SaliencyBlock saliencies(const std::vector<Volume>& volumes, int feature) const {
    std::vector<Moments> sums;
    std::vector<VoxelIndex> voxels;
    for (const Volume& volume : volumes) {
      sums.push_back(feature < 0 ? volume.configured : volume.sums[feature]);
      voxels.push_back(volume.voxel);
    }
    SaliencyBlock block;
    saliencyOfBlock(sums.data(), voxels.data(), static_cast<int>(sums.size()),
                    config_.voxel_size_m / static_cast<double>(kStepsPerVoxel), &block);
    return block;
  }
  void computeFeature(const std::vector<Volume>& volumes, int f, float* values) const {
    const Feature& feature = model_.features[f];
    if (isOfColumns(feature.quantity)) {
      int32_t numbers[kSaliencyBlock] = {};
      for (std::size_t i = 0; i < volumes.size(); ++i) numbers[i] = volumes[i].numbers[f];
      columnFeatureValues(feature.quantity, numbers, config_.voxel_size_m, values);
      return;
    }
    SaliencyBlock block = saliencies(volumes, f);
    if (feature.isOfConfiguredSupport()) {
      for (std::size_t i = 0; i < volumes.size(); ++i) block.points[i] = volumes[i].points;
    }
    featureValues(feature.quantity, block, values);
  }
  /// At most a block of voxels.
  std::vector<Voxel> classify(const std::vector<Volume>& volumes) const {
    const SaliencyBlock block = saliencies(volumes, -1);
    const auto feature_count = static_cast<int>(model_.features.size());
    FeatureBlock features(feature_count);
    for (int f = 0; f < feature_count; ++f) computeFeature(volumes, f, features.row(f));
    const Calibration& calibration = model_.calibration;
    PosteriorBlock posterior;
    if (config_.smooth_labels) {
      const auto temperature = static_cast<float>(calibration.smoothing.temperature);
      classifier_.posteriors(features, temperature, nullptr, &posterior);
    } else {
      const std::vector<float> offsets = classOffsets(calibration.offsets, model_.classes.size());
      classifier_.posteriors(features, static_cast<float>(calibration.temperature), offsets.data(),
                             &posterior);
    }
    Classification classified[kSaliencyBlock];
    classifier_.choose(posterior, static_cast<int>(volumes.size()), classified);
    std::vector<Voxel> result(volumes.size());
    for (std::size_t i = 0; i < volumes.size(); ++i) {
      Voxel& voxel = result[i];
      voxel.saliency = block.at(static_cast<int>(i));
      voxel.saliency.points = volumes[i].points;
      for (int f = 0; f < feature_count; ++f) voxel.features.push_back(features.row(f)[i]);
      const bool supported = voxel.saliency.defined &&
                             volumes[i].points >= static_cast<uint32_t>(config_.min_support_points);
      if (supported) voxel.classification = classified[i];
      voxel.posterior.assign(model_.classes.size(), 0);
      for (std::size_t c = 0; c < model_.classes.size(); ++c) {
        if (voxel.classification.label == kUnknownLabel) continue;
        voxel.posterior[c] = wholePosterior(posterior.probability[c][i]);
      }
    }
    return result;
  }

  void smooth(const VoxelMap& map, std::vector<Voxel>* voxels) const {
    PosteriorAverage average(map, static_cast<int>(model_.classes.size()));
    const auto listed = listVoxels(map);
    for (const auto& [voxel, slot] : listed) average.set(voxel, (*voxels)[slot].posterior);
    average.finish();
    for (const auto& [voxel, slot] : listed) {
      Voxel& known = (*voxels)[slot];
      if (known.classification.label == kUnknownLabel) continue;
      std::vector<std::vector<uint64_t>> sums = {{known.posterior.begin(), known.posterior.end()}};
      for (const int radius : model_.calibration.smoothing.radii_voxels) {
        sums.push_back(average.around(voxel, radius));
      }
      known.classification = smoothedClass(classifier_, model_.calibration.smoothing, sums);
    }
  }

  TerrainConfig config_;
  BoxStack stack_;
  ClassifierModel model_;
  Classifier classifier_;
};

}  // namespace ladar_perception::test
