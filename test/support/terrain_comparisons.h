// SPDX-License-Identifier: BSD-3-Clause
// What two terrain pipelines say, compared bit by bit.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "ladar_perception/terrain/terrain_pipeline.h"

namespace ladar_perception::test {

inline bool same(const SaliencyF& a, const SaliencyF& b) {
  return a.points == b.points && a.defined == b.defined && a.scatter == b.scatter &&
         a.surface == b.surface && a.linear == b.linear && a.normal == b.normal &&
         a.tangent == b.tangent;
}

inline bool same(const Classification& a, const Classification& b) {
  return a.label == b.label && a.confidence == b.confidence;
}

inline void expectSame(const SaliencyF& a, const SaliencyF& b) {
  ASSERT_EQ(a.points, b.points);
  ASSERT_EQ(a.defined, b.defined);
  ASSERT_EQ(a.scatter, b.scatter);
  ASSERT_EQ(a.surface, b.surface);
  ASSERT_EQ(a.linear, b.linear);
  ASSERT_EQ(a.normal, b.normal);
  ASSERT_EQ(a.tangent, b.tangent);
}

/// Slots of the occupied voxels, in the map's order.
inline std::vector<std::pair<VoxelIndex, std::size_t>> listVoxels(const VoxelMap& map) {
  std::vector<std::pair<VoxelIndex, std::size_t>> voxels;
  map.forEachVoxel(
      [&](const VoxelIndex& voxel, std::size_t slot) { voxels.emplace_back(voxel, slot); });
  return voxels;
}

/// Everything two pipelines say of the map is the same, bit by bit.
inline void expectSameVoxels(const TerrainPipeline& a, const TerrainPipeline& b) {
  const auto voxels_a = listVoxels(a.map());
  const auto voxels_b = listVoxels(b.map());
  ASSERT_EQ(voxels_a.size(), voxels_b.size());
  for (std::size_t i = 0; i < voxels_a.size(); ++i) {
    ASSERT_EQ(voxels_a[i].first, voxels_b[i].first);
    const std::size_t slot_a = voxels_a[i].second;
    const std::size_t slot_b = voxels_b[i].second;
    ASSERT_EQ(a.map().record(slot_a), b.map().record(slot_b));
    ASSERT_EQ(a.classification(slot_a).label, b.classification(slot_b).label) << i;
    ASSERT_EQ(a.classification(slot_a).confidence, b.classification(slot_b).confidence) << i;
    ASSERT_NO_FATAL_FAILURE(expectSame(a.saliency(slot_a), b.saliency(slot_b))) << i;
  }
}

inline void expectSameLabels(const TerrainPipeline& a, const TerrainPipeline& b) {
  ASSERT_EQ(a.pointLabels().size(), b.pointLabels().size());
  for (std::size_t i = 0; i < a.pointLabels().size(); ++i) {
    ASSERT_EQ(a.pointLabels()[i].label, b.pointLabels()[i].label) << i;
    ASSERT_EQ(a.pointLabels()[i].confidence, b.pointLabels()[i].confidence) << i;
  }
}

}  // namespace ladar_perception::test
