// SPDX-License-Identifier: BSD-3-Clause
// Radius search and covariance on the points themselves. The search tree is built before the time
// is taken, though on a vehicle it would have to be built again with every scan.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <nanoflann.hpp>
#include <utility>

#include "bench_families.h"
#include "stopwatch.h"

namespace ladar_perception::bench {
namespace {

/// A scene's points the way nanoflann asks for them.
struct PointSource {
  const std::vector<Eigen::Vector3d>& points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[index][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointSource>,
                                                 PointSource, 3, std::size_t>;
using Matches = std::vector<std::pair<std::size_t, double>>;

Eigen::Matrix3d covarianceOf(const std::vector<Eigen::Vector3d>& points, const Matches& matches) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& match : matches) mean += points[match.first];
  mean /= static_cast<double>(matches.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& match : matches) {
    const Eigen::Vector3d from_mean = points[match.first] - mean;
    covariance += from_mean * from_mean.transpose();
  }
  return covariance / static_cast<double>(matches.size());
}

void radiusCovariance(benchmark::State& state, const std::string& scene_name) {
  const Scene* scene = findScene(scene_name);
  if (scene == nullptr) return state.SkipWithError("no data");
  const PointSource source{scene->points};
  Tree tree(3, source, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  const std::vector<int> queries = queryIndices(*scene);
  const nanoflann::SearchParams unsorted(32, 0.0F, false);
  Matches matches;
  double neighbours = 0.0;
  const Stopwatch stopwatch;
  for (auto _ : state) {
    neighbours = 0.0;
    for (const int query : queries) {
      const Eigen::Vector3d& p = scene->points[static_cast<std::size_t>(query)];
      // nanoflann's radius is squared.
      tree.radiusSearch(p.data(), kBallRadius_m * kBallRadius_m, matches, unsorted);
      neighbours += static_cast<double>(matches.size());
      benchmark::DoNotOptimize(covarianceOf(scene->points, matches));
    }
  }
  const double total_ns = stopwatch.cpu_ns();
  const auto count = static_cast<double>(queries.size());
  state.counters["ns_per_query"] = total_ns / (count * static_cast<double>(state.iterations()));
  state.counters["neighbours"] = neighbours / count;
}

}  // namespace

void registerNanoflannNeighbourhoods(const SceneNames& scenes) {
  for (const std::string& scene : scenes) {
    benchmark::RegisterBenchmark(
        ("neighbourhood/nanoflann_radius/" + scene).c_str(),
        [scene](benchmark::State& state) { radiusCovariance(state, scene); })
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace ladar_perception::bench
