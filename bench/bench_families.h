// SPDX-License-Identifier: BSD-3-Clause
// The families of benchmarks of bench_saliency. Each registers its benchmarks for some scenes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bench_scenes.h"

namespace ladar_perception::bench {

using SceneNames = std::vector<std::string>;

/// box_sums/<strategy>/<scene>/k:<k>
void registerBoxSums(const SceneNames& scenes);
/// sums_to_labels/<vector level>/<scene>: box sums, saliencies, features and classes of all voxels
void registerLabeling(const SceneNames& scenes);
/// insert/<layout>/<scene>
void registerInsertion(const SceneNames& scenes);
void registerOctomapInsertion(const SceneNames& scenes);
/// neighbourhood/<library>/<scene>
void registerPclNeighbourhoods(const SceneNames& scenes);
void registerNanoflannNeighbourhoods(const SceneNames& scenes);

/// The rivals search a ball: its radius is half the width of the box at k = 9 and voxels of 10 cm.
/// It has 52 per cent of the box's volume, so they have fewer points to work on than the box sums.
constexpr double kBallRadius_m = 0.45;
/// Points the rivals are asked about, evenly from all of a scene: all of them would take minutes.
constexpr std::size_t kQueries = 2000;

/// Indices of the query points.
inline std::vector<int> queryIndices(const Scene& scene) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < kQueries; ++i) {
    indices.push_back(static_cast<int>(i * scene.points.size() / kQueries));
  }
  return indices;
}

}  // namespace ladar_perception::bench
