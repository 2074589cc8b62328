// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>
#include <octomap/OcTree.h>

#include "bench_families.h"

namespace ladar_perception::bench {
namespace {

/// Points into an occupancy tree without ray casting, as its documentation says: updateNode with
/// lazy evaluation, then the inner nodes once. Conversion to its float points included, as ours is.
void insertPoints(const Scene& scene, octomap::OcTree* tree) {
  for (const Eigen::Vector3d& p : scene.points) {
    tree->updateNode(octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()),
                                      static_cast<float>(p.z())),
                     true, true);
  }
  tree->updateInnerOccupancy();
}

void octomapInsertion(benchmark::State& state, const std::string& scene_name) {
  const Scene* scene = findScene(scene_name);
  if (scene == nullptr) return state.SkipWithError("no data");
  octomap::OcTree tree(scene->voxel_size_m);
  insertPoints(*scene, &tree);
  for (auto _ : state) {
    state.PauseTiming();
    tree.clear();
    state.ResumeTiming();
    insertPoints(*scene, &tree);
    benchmark::ClobberMemory();
  }
  using benchmark::Counter;
  state.counters["points_per_second"] =
      Counter(static_cast<double>(scene->points.size()), Counter::kIsIterationInvariantRate);
  state.counters["memory_bytes"] = static_cast<double>(tree.memoryUsage());
}

}  // namespace

void registerOctomapInsertion(const SceneNames& scenes) {
  for (const std::string& scene : scenes) {
    benchmark::RegisterBenchmark(("insert/octomap/" + scene).c_str(), [scene](
                                                                          benchmark::State& state) {
      octomapInsertion(state, scene);
    })->Unit(benchmark::kMillisecond);
  }
}

}  // namespace ladar_perception::bench
