// SPDX-License-Identifier: BSD-3-Clause
// Measures what the tables and figures of Lalonde, Vandapel and Hebert 2005 show, on the synthetic
// scenes, and writes it as JSON. bench/reproduce_paper runs it.
//   paper_tables FOLDER     writes FOLDER/paper.json and FOLDER/<scene>.csv (the occupied voxels)
#include <cstdio>
#include <exception>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench_scenes.h"
#include "ladar_perception/util/dispatch.h"
#include "strategy_timer.h"

namespace {

using namespace ladar_perception;
using bench::median;
using bench::Scene;
using bench::Stopwatch;
using bench::StrategyTimer;
using nlohmann::json;
using Names = std::vector<std::string>;

constexpr int kPaperK = 9;
const Names kPaperScenes = {"flat_ground", "forest", "tall_grass"};

const Scene& sceneNamed(const std::string& name) {
  const Scene* scene = bench::findScene(name);
  if (scene == nullptr) throw std::runtime_error("no scene " + name);
  return *scene;
}

json shapeOf(const Scene& scene) { return {scene.shape.nx, scene.shape.ny, scene.shape.nz}; }

/// Times against radius: [{k, radius_m, ns: {strategy: ns per voxel}}].
json curve(const Names& names, const Scene& scene, const VoxelMap& map,
           const std::vector<int>& ks) {
  StrategyTimer timer(names, map);
  json points = json::array();
  for (const int k : ks) {
    points.push_back(
        {{"k", k}, {"radius_m", k / 2 * scene.voxel_size_m}, {"ns", timer.nsPerVoxel(k)}});
  }
  return points;
}

json tableOne() {
  json rows = json::array();
  for (const std::string& name : kPaperScenes) {
    const Scene& scene = sceneNamed(name);
    const VoxelMap map = bench::filledMap(scene);
    const ReuseStatistics reuse = reuseStatistics(map, ScanAxis::kBest);
    rows.push_back({{"scene", name},
                    {"shape", shapeOf(scene)},
                    {"points", scene.points.size()},
                    {"occupied", map.occupied()},
                    {"d", reuse.meanDistance(kPaperK)},
                    {"p", reuse.reuseShare(kPaperK)}});
  }
  return rows;
}

constexpr double kVoxelSizes_m[] = {0.05, 0.1, 0.2};

json tableTwo() {
  json rows = json::array();
  for (const double voxel_size_m : kVoxelSizes_m) {
    const Scene scene = bench::withVoxelSize(sceneNamed("flat_ground"), voxel_size_m);
    const VoxelMap map = bench::filledMap(scene);
    const ReuseStatistics reuse = reuseStatistics(map, ScanAxis::kBest);
    // The paper does not say whether k stays 9 or the radius 0.4 m.
    const int same_radius_k = 2 * static_cast<int>(0.4 / voxel_size_m + 0.5) + 1;
    rows.push_back({{"voxel_size_m", voxel_size_m},
                    {"shape", shapeOf(scene)},
                    {"occupied", map.occupied()},
                    {"d_k9", reuse.meanDistance(kPaperK)},
                    {"p_k9", reuse.reuseShare(kPaperK)},
                    {"same_radius_k", same_radius_k},
                    {"d_same_radius", reuse.meanDistance(same_radius_k)},
                    {"p_same_radius", reuse.reuseShare(same_radius_k)}});
  }
  return rows;
}

json figureSix() {
  json points = json::array();
  for (int tenths = 2; tenths <= 30; tenths += tenths < 18 ? 2 : 4) {
    const Scene scene = bench::uniformScene({200, 200, 30}, 0.001 * tenths, 6);
    const VoxelMap map = bench::filledMap(scene);
    const ReuseStatistics reuse = reuseStatistics(map, ScanAxis::kBest);
    StrategyTimer timer({"hash_brute", "dense_brute", "paper_reuse", "sliding"}, map);
    points.push_back({{"density", 0.001 * tenths},
                      {"d", reuse.meanDistance(kPaperK)},
                      {"p", reuse.reuseShare(kPaperK)},
                      {"ns", timer.nsPerVoxel(kPaperK)}});
  }
  return points;
}

json figureSeven() {
  json parts = json::array();
  for (const std::size_t step : {1, 10, 100}) {
    const Scene scene = bench::thinned(sceneNamed("tall_grass"), step);
    const VoxelMap map = bench::filledMap(scene);
    const ReuseStatistics reuse = reuseStatistics(map, ScanAxis::kBest);
    parts.push_back({{"step", step},
                     {"points", scene.points.size()},
                     {"occupied", map.occupied()},
                     {"d", reuse.meanDistance(kPaperK)},
                     {"p", reuse.reuseShare(kPaperK)},
                     {"curve", curve({"hash_brute", "paper_reuse", "sliding"}, scene, map,
                                     {3, 5, 7, 9, 11, 13})}});
  }
  return parts;
}

json figureEight() {
  const std::vector<int> ks[] = {{5, 9, 13, 17}, {3, 5, 7, 9, 11, 13}, {3, 5, 7}};
  json parts = json::array();
  for (std::size_t i = 0; i < std::size(kVoxelSizes_m); ++i) {
    const Scene scene = bench::withVoxelSize(sceneNamed("flat_ground"), kVoxelSizes_m[i]);
    const VoxelMap map = bench::filledMap(scene);
    parts.push_back(
        {{"voxel_size_m", scene.voxel_size_m},
         {"occupied", map.occupied()},
         {"curve", curve({"hash_brute", "paper_reuse", "sliding"}, scene, map, ks[i])}});
  }
  return parts;
}

void writeVoxels(const std::string& path, const VoxelMap& map) {
  std::ofstream file(path);
  map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t /*slot*/) {
    file << voxel.x << ',' << voxel.y << ',' << voxel.z << '\n';
  });
  if (!file) throw std::runtime_error("cannot write " + path);
}

json figureNine(const std::string& folder) {
  json parts = json::array();
  for (const std::string& name : kPaperScenes) {
    const Scene& scene = sceneNamed(name);
    const VoxelMap map = bench::filledMap(scene);
    writeVoxels(folder + "/" + name + ".csv", map);
    json part = {{"scene", name}};
    const std::pair<const char*, ScanAxis> axes[] = {
        {"x", ScanAxis::kX}, {"y", ScanAxis::kY}, {"z", ScanAxis::kZ}, {"best", ScanAxis::kBest}};
    for (const auto& [axis_name, axis] : axes) {
      part["histograms"][axis_name] = reuseStatistics(map, axis).histogram;
    }
    const Names names = {"hash_brute",    "dense_brute",   "naive_scan",    "paper_reuse",
                         "paper_reuse_x", "paper_reuse_y", "paper_reuse_z", "sliding"};
    part["curve"] = curve(names, scene, map, {3, 5, 7, 9, 11, 13});
    StrategyTimer timer(names, map);
    part["mismatches"] = timer.mismatches(kPaperK);
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Median CPU time of `work` in ns, with what `prepare` makes anew each time.
double medianCpu_ns(const std::function<void()>& prepare, const std::function<void()>& work) {
  std::vector<double> times_ns;
  for (int round = 0; round < 7; ++round) {
    prepare();
    const Stopwatch stopwatch;
    work();
    times_ns.push_back(stopwatch.cpu_ns());
  }
  return median(times_ns);
}

json creationAndInsertion() {
  json rows = json::array();
  for (const std::string& name : kPaperScenes) {
    const Scene& scene = sceneNamed(name);
    const std::size_t voxels =
        static_cast<std::size_t>(scene.shape.nx) * scene.shape.ny * scene.shape.nz;
    std::unique_ptr<VoxelMap> map;
    std::unique_ptr<std::vector<Moments>> dense;
    const auto create = [&] { map = std::make_unique<VoxelMap>(bench::emptyMap(scene)); };
    const auto insert = [&] { bench::insertAll(scene, map.get()); };
    json row = {{"scene", name}, {"voxels", voxels}, {"points", scene.points.size()}};
    row["creation_ms"] = 1e-6 * medianCpu_ns([&] { map.reset(); }, create);
    row["dense_creation_ms"] =
        1e-6 * medianCpu_ns([&] { dense.reset(); },
                            [&] { dense = std::make_unique<std::vector<Moments>>(voxels); });
    dense.reset();
    const auto points = static_cast<double>(scene.points.size());
    row["new_map_points_per_second"] = 1e9 * points / medianCpu_ns(create, insert);
    row["used_map_points_per_second"] = 1e9 * points / medianCpu_ns([&] { map->clear(); }, insert);
    StrategyTimer timer({"hash_brute", "paper_reuse", "sliding"}, *map);
    timer.nsPerVoxel(kPaperK);
    row["map_bytes"] = map->memoryBytes();
    row["sums_bytes"] = map->slotBound() * sizeof(Moments);
    row["strategy_bytes"] = timer.memoryBytes();
    rows.push_back(std::move(row));
  }
  return rows;
}

int run(const std::string& folder) {
  json all;
  const auto part = [&](const char* name, const std::function<json()>& work) {
    const Stopwatch stopwatch;
    all[name] = work();
    std::fprintf(stderr, "%s (%.0f s)\n", name, 1e-9 * stopwatch.wall_ns());
  };
  all["vector_level"] = vectorLevelName(vectorLevel());
  all["compiler"] = __VERSION__;
  part("table_1", tableOne);
  part("table_2", tableTwo);
  part("creation_and_insertion", creationAndInsertion);
  part("figure_6", figureSix);
  part("figure_7", figureSeven);
  part("figure_8", figureEight);
  part("figure_9", [&] { return figureNine(folder); });
  std::ofstream file(folder + "/paper.json");
  file << all.dump(1) << '\n';
  if (!file) throw std::runtime_error("cannot write " + folder + "/paper.json");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: paper_tables FOLDER\n");
    return 2;
  }
  try {
    return run(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "paper_tables: %s\n", error.what());
    return 1;
  }
}
