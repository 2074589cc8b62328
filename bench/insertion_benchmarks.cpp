// SPDX-License-Identifier: BSD-3-Clause
// A scene's points, in scan order and in metres, into an empty layout. What a layout keeps when it
// is emptied (blocks, buckets, the dense array) stays: a map on a vehicle is made once and lives
// on. Emptying is not timed.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <unordered_map>

#include "bench_families.h"

namespace ladar_perception::bench {
namespace {

using InsertFunction = std::size_t(const Scene& scene, VoxelMap* map);

/// The package's own map, filled the way the pipeline does it or point by point.
template <InsertFunction* kInsert>
class LadarPerceptionLayout {
 public:
  explicit LadarPerceptionLayout(const Scene& scene) : scene_(scene), map_(emptyMap(scene)) {}

  void clear() { map_.clear(); }
  void insertPoints() { kInsert(scene_, &map_); }
  double memoryBytes() const { return static_cast<double>(map_.memoryBytes()); }

 private:
  const Scene& scene_;
  VoxelMap map_;
};

/// Calls `at(voxel)` for every point and adds it to the record that returns.
template <typename At>
void addToRecords(const Scene& scene, At&& at) {
  const double steps_per_m = static_cast<double>(kStepsPerVoxel) / scene.voxel_size_m;
  for (const Eigen::Vector3d& p_map : scene.points) {
    const FixedPoint q = toFixedPoint(p_map, steps_per_m);
    at(voxelOf(q)).add(q);
  }
}

/// Records in a hash map, as in the paper's predecessor.
class UnorderedMapLayout {
 public:
  explicit UnorderedMapLayout(const Scene& scene) : scene_(scene) {}

  void clear() { records_.clear(); }
  void insertPoints() {
    addToRecords(scene_, [&](const VoxelIndex& v) -> Moments& {
      constexpr uint32_t kMask = (1U << 21) - 1;
      return records_[uint64_t{static_cast<uint32_t>(v.y) & kMask} << 42 |
                      uint64_t{static_cast<uint32_t>(v.x) & kMask} << 21 |
                      (static_cast<uint32_t>(v.z) & kMask)];
    });
  }
  double memoryBytes() const {
    using Node = std::pair<void*, decltype(records_)::value_type>;
    return static_cast<double>(records_.size() * sizeof(Node) +
                               records_.bucket_count() * sizeof(void*));
  }

 private:
  const Scene& scene_;
  std::unordered_map<uint64_t, Moments> records_;
};

/// A record for every voxel, as in the paper.
class DenseLayout {
 public:
  explicit DenseLayout(const Scene& scene)
      : scene_(scene),
        records_(static_cast<std::size_t>(scene.shape.nx) * scene.shape.ny * scene.shape.nz) {}

  void clear() { std::fill(records_.begin(), records_.end(), Moments()); }
  void insertPoints() {
    const MapShape shape = scene_.shape;
    const VoxelIndex min = scene_.min_corner;
    addToRecords(scene_, [&](const VoxelIndex& v) -> Moments& {
      const auto column = static_cast<std::size_t>(v.y - min.y) * shape.nx + (v.x - min.x);
      return records_[column * shape.nz + (v.z - min.z)];
    });
  }
  double memoryBytes() const { return static_cast<double>(records_.capacity() * sizeof(Moments)); }

 private:
  const Scene& scene_;
  std::vector<Moments> records_;
};

template <typename Layout>
void insertion(benchmark::State& state, const std::string& scene_name) {
  const Scene* scene = findScene(scene_name);
  if (scene == nullptr) return state.SkipWithError("no data");
  Layout layout(*scene);
  layout.insertPoints();
  for (auto _ : state) {
    state.PauseTiming();
    layout.clear();
    state.ResumeTiming();
    layout.insertPoints();
    benchmark::ClobberMemory();
  }
  using benchmark::Counter;
  state.counters["points_per_second"] =
      Counter(static_cast<double>(scene->points.size()), Counter::kIsIterationInvariantRate);
  state.counters["memory_bytes"] = layout.memoryBytes();
}

template <typename Layout>
void registerLayout(const std::string& layout, const SceneNames& scenes) {
  for (const std::string& scene : scenes) {
    const std::string name = "insert/" + layout + "/" + scene;
    benchmark::RegisterBenchmark(name.c_str(), [scene](benchmark::State& state) {
      insertion<Layout>(state, scene);
    })->Unit(benchmark::kMillisecond);
  }
}

}  // namespace

void registerInsertion(const SceneNames& scenes) {
  registerLayout<LadarPerceptionLayout<insertAll>>("ladar_perception", scenes);
  registerLayout<LadarPerceptionLayout<insertOneByOne>>("ladar_perception_one_by_one", scenes);
  registerLayout<UnorderedMapLayout>("unordered_map", scenes);
  registerLayout<DenseLayout>("dense", scenes);
}

}  // namespace ladar_perception::bench
