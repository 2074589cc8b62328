// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <map>
#include <memory>

#include "bench_families.h"
#include "ladar_perception/saliency/box_sum_strategy.h"
#include "stopwatch.h"

namespace ladar_perception::bench {
namespace {

struct Variant {
  const char* name;
  const char* strategy;
  int threads;
  bool warm;  ///< one untimed pass first; it would double the time of the slow ones for nothing
};

constexpr Variant kVariants[] = {
    {"hash_brute", "hash_brute", 1, false}, {"dense_brute", "dense_brute", 1, false},
    {"naive_scan", "naive_scan", 1, false}, {"paper_reuse", "paper_reuse", 1, true},
    {"sliding", "sliding", 1, true},        {"sliding_2_threads", "sliding", 2, true},
};

/// The map of a scene with all its points; nullptr without the scene's data.
const VoxelMap* mapOf(const std::string& scene_name) {
  static std::map<std::string, std::unique_ptr<VoxelMap>> maps;
  auto& map = maps[scene_name];
  if (map == nullptr) {
    const Scene* scene = findScene(scene_name);
    if (scene != nullptr) map = std::make_unique<VoxelMap>(filledMap(*scene));
  }
  return map.get();
}

void boxSums(benchmark::State& state, const Variant& variant, const std::string& scene, int k) {
  const VoxelMap* map = mapOf(scene);
  if (map == nullptr) return state.SkipWithError("no data");
  // Anew for every run: dense arrays of all scenes at once are gigabytes.
  const auto strategy = makeBoxSumStrategy(variant.strategy);
  strategy->load(*map);
  ThreadPool pool(variant.threads);
  std::vector<Moments> sums(map->slotBound());
  if (variant.warm) strategy->compute(k / 2, &pool, &sums);

  const Stopwatch stopwatch;
  for (auto _ : state) {
    strategy->compute(k / 2, &pool, &sums);
    benchmark::ClobberMemory();
  }
  const double total_ns = variant.threads == 1 ? stopwatch.cpu_ns() : stopwatch.wall_ns();
  state.counters["ns_per_voxel"] =
      total_ns / (static_cast<double>(map->occupied()) * static_cast<double>(state.iterations()));
  state.counters["memory_bytes"] = static_cast<double>(strategy->memoryBytes());
}

}  // namespace

void registerBoxSums(const SceneNames& scenes) {
  for (const Variant& variant : kVariants) {
    for (const std::string& scene : scenes) {
      for (const int k : {3, 5, 7, 9, 11, 13}) {
        const std::string name =
            std::string("box_sums/") + variant.name + "/" + scene + "/k:" + std::to_string(k);
        benchmark::RegisterBenchmark(name.c_str(), [&variant, scene, k](benchmark::State& state) {
          boxSums(state, variant, scene, k);
        })->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace ladar_perception::bench
