// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <map>
#include <memory>

#include "bench_families.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "ladar_perception/util/dispatch.h"
#include "position_cloud.h"
#include "stopwatch.h"

namespace ladar_perception::bench {
namespace {

/// A pipeline whose map holds all points of the scene; nullptr without the scene's data.
TerrainPipeline* pipelineOf(const std::string& scene_name) {
  static std::map<std::string, std::unique_ptr<TerrainPipeline>> pipelines;
  auto& pipeline = pipelines[scene_name];
  const Scene* scene = pipeline == nullptr ? findScene(scene_name) : nullptr;
  if (scene == nullptr) return pipeline.get();
  TerrainConfig config;
  config.voxel_size_m = scene->voxel_size_m;
  config.map_size_x_m = scene->shape.nx * scene->voxel_size_m;
  config.map_size_y_m = scene->shape.ny * scene->voxel_size_m;
  config.map_size_z_m = scene->shape.nz * scene->voxel_size_m;
  config.map_center_height_m = 0.0;
  config.min_range_m = 0.0;
  config.max_range_m = 1000.0;
  const auto model = loadClassifierModel(LADAR_SOURCE_DIR "/config/models/starter.yaml");
  pipeline = std::make_unique<TerrainPipeline>(config, model);
  const VoxelIndex& min = scene->min_corner;
  const Eigen::Vector3d middle =
      scene->voxel_size_m * Eigen::Vector3d(min.x + scene->shape.nx / 2 + 0.5,
                                            min.y + scene->shape.ny / 2 + 0.5,
                                            min.z + scene->shape.nz / 2 + 0.5);
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  T_map_sensor.translation() = middle;
  const PositionCloud cloud(scene->points, middle);
  pipeline->process(cloud.view(), cloud.fields(), {}, SensorMotion(T_map_sensor), middle);
  return pipeline.get();
}

void sumsToLabels(benchmark::State& state, const std::string& scene, VectorLevel level) {
  TerrainPipeline* pipeline = pipelineOf(scene);
  if (pipeline == nullptr) return state.SkipWithError("no data");
  const VectorLevel before = vectorLevel();
  limitVectorLevel(level);
  pipeline->updateAllVoxels();
  const Stopwatch stopwatch;
  for (auto _ : state) pipeline->updateAllVoxels();
  const double total_ns = stopwatch.cpu_ns();
  limitVectorLevel(before);
  state.counters["ns_per_voxel"] = total_ns / (static_cast<double>(pipeline->map().occupied()) *
                                               static_cast<double>(state.iterations()));
  state.counters["voxels"] = static_cast<double>(pipeline->map().occupied());
}

}  // namespace

void registerLabeling(const SceneNames& scenes) {
  for (const VectorLevel level :
       {VectorLevel::kBaseline, VectorLevel::kAvx2, VectorLevel::kAvx512}) {
    if (level > bestVectorLevel()) continue;
    for (const std::string& scene : scenes) {
      const std::string name =
          std::string("sums_to_labels/") + vectorLevelName(level) + "/" + scene;
      benchmark::RegisterBenchmark(name.c_str(), [scene, level](benchmark::State& state) {
        sumsToLabels(state, scene, level);
      })->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace ladar_perception::bench
