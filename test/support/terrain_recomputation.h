// SPDX-License-Identifier: BSD-3-Clause
// What a terrain pipeline has to know of its voxels, computed anew from the records of its map.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "hand_model.h"
#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/saliency/box_sums.h"
#include "ladar_perception/saliency/features.h"
#include "ladar_perception/terrain/terrain_config.h"
#include "terrain_comparisons.h"

namespace ladar_perception::test {

/// The model made by hand, said to be learned on the configuration's voxels and support.
inline ClassifierModel modelFor(const TerrainConfig& config) {
  ClassifierModel model = handModel();
  model.voxel_size_m = config.voxel_size_m;
  model.support_radius_voxels = config.support_radius_voxels;
  model.support_kernel = config.support_kernel;
  return model;
}

/// What has to be known of the voxels of a map, from its records alone.
class Recomputation {
 public:
  struct Voxel {
    SaliencyF saliency;
    Classification classification;
  };

  explicit Recomputation(const TerrainConfig& config)
      : config_(config),
        stack_(config.supportStack()),
        model_(modelFor(config)),
        classifier_(model_) {}

  /// One voxel alone, by as many look-ups as there are voxels in the support volume.
  Voxel of(const VoxelMap& map, const VoxelIndex& center) const {
    const int r = config_.support_radius_voxels;
    Moments sum;
    uint32_t points = 0;
    for (int dx = -r; dx <= r; ++dx) {
      for (int dy = -r; dy <= r; ++dy) {
        for (int dz = -r; dz <= r; ++dz) {
          const Moments* record = map.find({center.x + dx, center.y + dy, center.z + dz});
          if (record == nullptr) continue;
          points += record->count();
          const int distance = std::max({std::abs(dx), std::abs(dy), std::abs(dz)});
          for (uint32_t i = 0; i < weightAt(stack_, distance); ++i) sum += *record;
        }
      }
    }
    return classify({sum}, {points}, {center}).front();
  }
  /// All voxels by slot, from sums over the whole map: in other blocks than the pipeline's.
  std::vector<Voxel> ofAll(const VoxelMap& map) const {
    ColumnSet columns;
    columns.assignAll(map.shape().nx, map.shape().ny);
    SumTable table{std::vector<Moments>(map.slotBound())};
    std::vector<Moments> sums(map.slotBound());
    std::vector<uint32_t> points(map.slotBound());
    for (std::size_t i = 0; i < stack_.size(); ++i) {
      SlidingBoxSums<Moments> box_sums(stack_[i].box);
      box_sums.compute(map, columns, 0, map.shape().ny, table);
      map.forEachVoxel([&](const VoxelIndex& /*voxel*/, std::size_t slot) {
        if (i == 0) points[slot] = table.sums[slot].count();
        for (uint32_t j = 0; j < stack_[i].weight; ++j) sums[slot] += table.sums[slot];
      });
    }
    std::vector<Voxel> result(map.slotBound());
    Batch batch;
    auto voxels = listVoxels(map);
    std::reverse(voxels.begin(), voxels.end());
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      batch.add(sums[voxels[i].second], points[voxels[i].second], voxels[i]);
      if (batch.slots.size() < kSaliencyBlock && i + 1 < voxels.size()) continue;
      const std::vector<Voxel> known = classify(batch.sums, batch.points, batch.voxels);
      for (std::size_t j = 0; j < known.size(); ++j) result[batch.slots[j]] = known[j];
      batch = Batch();
    }
    return result;
  }

 private:
  struct SumTable {
    std::vector<Moments> sums;
    Moments& place(std::size_t slot, int /*x*/, int /*y*/, int /*z*/) { return sums[slot]; }
  };
  struct Batch {
    void add(const Moments& sum, uint32_t count, const std::pair<VoxelIndex, std::size_t>& voxel) {
      sums.push_back(sum);
      points.push_back(count);
      voxels.push_back(voxel.first);
      slots.push_back(voxel.second);
    }
    std::vector<Moments> sums;
    std::vector<uint32_t> points;
    std::vector<VoxelIndex> voxels;
    std::vector<std::size_t> slots;
  };

  /// At most a block of voxels.
  std::vector<Voxel> classify(const std::vector<Moments>& sums, const std::vector<uint32_t>& points,
                              const std::vector<VoxelIndex>& voxels) const {
    const double step_m = config_.voxel_size_m / static_cast<double>(kStepsPerVoxel);
    const auto count = static_cast<int>(sums.size());
    SaliencyBlock block;
    saliencyOfBlock(sums.data(), voxels.data(), count, step_m, &block);
    FeatureBlock features(static_cast<int>(model_.features.size()));
    for (std::size_t f = 0; f < model_.features.size(); ++f) {
      featureValues(model_.features[f], block, features.row(static_cast<int>(f)));
    }
    Classification classified[kSaliencyBlock];
    classifier_.classify(features, count, classified);
    std::vector<Voxel> result(sums.size());
    for (int i = 0; i < count; ++i) {
      result[i].saliency = block.at(i);
      result[i].saliency.points = points[i];
      const bool supported = result[i].saliency.defined &&
                             points[i] >= static_cast<uint32_t>(config_.min_support_points);
      if (supported) result[i].classification = classified[i];
    }
    return result;
  }

  TerrainConfig config_;
  BoxStack stack_;
  ClassifierModel model_;
  Classifier classifier_;
};

}  // namespace ladar_perception::test
