// SPDX-License-Identifier: BSD-3-Clause
// The only unit of the benchmarks that sees PCL's headers. As with nanoflann, the search tree is
// built before the time is taken.
#include <benchmark/benchmark.h>
#include <pcl/features/normal_3d.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include "bench_families.h"
#include "stopwatch.h"

namespace ladar_perception::bench {
namespace {

pcl::PointCloud<pcl::PointXYZ>::Ptr cloudOf(const Scene& scene) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  // From the first point on: coordinates are floats, and tiles are surveyed far from their origin.
  const Eigen::Vector3d origin = scene.points.front();
  cloud->reserve(scene.points.size());
  for (const Eigen::Vector3d& p : scene.points) {
    const Eigen::Vector3f from_origin = (p - origin).cast<float>();
    cloud->push_back(pcl::PointXYZ(from_origin.x(), from_origin.y(), from_origin.z()));
  }
  return cloud;
}

void normalEstimation(benchmark::State& state, const std::string& scene_name) {
  const Scene* scene = findScene(scene_name);
  if (scene == nullptr) return state.SkipWithError("no data");
  const auto cloud = cloudOf(*scene);
  pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
  tree->setInputCloud(cloud);
  pcl::IndicesPtr queries(new pcl::Indices(queryIndices(*scene)));

  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setIndices(queries);
  estimation.setSearchSurface(cloud);
  estimation.setSearchMethod(tree);  // kept as it is, for it holds the surface already
  estimation.setRadiusSearch(kBallRadius_m);
  pcl::PointCloud<pcl::Normal> normals;
  const Stopwatch stopwatch;
  for (auto _ : state) {
    estimation.compute(normals);
    benchmark::ClobberMemory();
  }
  const auto count = static_cast<double>(queries->size());
  state.counters["ns_per_query"] =
      stopwatch.cpu_ns() / (count * static_cast<double>(state.iterations()));
}

}  // namespace

void registerPclNeighbourhoods(const SceneNames& scenes) {
  for (const std::string& scene : scenes) {
    benchmark::RegisterBenchmark(
        ("neighbourhood/pcl_normal_estimation/" + scene).c_str(),
        [scene](benchmark::State& state) { normalEstimation(state, scene); })
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace ladar_perception::bench
