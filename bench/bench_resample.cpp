// SPDX-License-Identifier: BSD-3-Clause
// Time, memory and evenness of our re-sampling and of what other libraries offer:
//   resample/<method>/<cloud>          all that take less than about a second
//   resample_slow/<method>/<cloud>     farthest points by PCL and Open3D, once: minutes in all
//   growth/<engine>/n:<points>/N:<samples>
//   extend/<engine>/<part>/<cloud>     a sixtieth of the points come last: all in one sector, or
//                                      from everywhere; or the whole cloud at once
// Clouds are named by their points; see pose_clouds.h. Times are CPU times of the process where a
// method has one thread. Counters: cov and min_over_mean of the distances to the nearest sample,
// of all and of those that are not alone (connected_), cover_p99 of the cloud's points over the
// mean of the latter, and memory_mb, the peak while it ran over what there was before; of ours also
// the cells and the wall clock's ms of each stage.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "interleaved_main.h"
#include "ladar_perception/resample/sampling_quality.h"
#include "pose_clouds.h"
#include "sampling_methods.h"
#include "stopwatch.h"

namespace ladar_perception::bench {
namespace {

/// A cloud and how many samples to take of it.
struct Case {
  std::string name;
  std::function<const PoseCloudData*()> cloud;
  int samples = 0;
};

struct Variant {
  std::string name;
  Case from;
  std::function<SamplingMethod(const PoseCloudData&)> make;
  int threads = 1;
  bool slow = false;
};

Case campusCase(std::size_t thousands, int samples) {
  return {"campus_" + std::to_string(thousands) + "k",
          [=] { return &campusCloud(1000 * thousands); }, samples};
}

std::vector<Case> cases() {
  std::vector<Case> all = {campusCase(20, 2000), campusCase(190, 50000), campusCase(380, 55000)};
  for (const auto& [name, samples] : {std::pair{"kitti00", 30000}, {"3dtk_indoor", 20000}}) {
    const PoseCloudData* cloud = realCloud(name);
    if (cloud != nullptr) all.push_back({name, [=] { return cloud; }, samples});
  }
  return all;
}

/// Peak of the memory that the process holds since `reset`, in MB; 0 where the kernel does not
/// tell.
class PeakMemory {
 public:
  static void reset() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
  }
  static double megabytes() {
    std::ifstream status("/proc/self/status");
    std::string word;
    double kibibytes = 0.0;
    while (status >> word) {
      if (word == "VmHWM:") status >> kibibytes;
    }
    return kibibytes * 1024.0 * 1e-6;
  }
};

/// How even a sampling is does not change from run to run: it is computed once.
const std::map<std::string, double>& qualityOf(const std::string& name, const Points& samples,
                                               const Points& cloud) {
  static std::map<std::string, std::map<std::string, double>> known;
  std::map<std::string, double>& quality = known[name];
  if (!quality.empty()) return quality;
  const SpacingStatistics spacing = spacingOf(samples);
  quality["samples"] = static_cast<double>(samples.size());
  quality["points"] = static_cast<double>(cloud.size());
  quality["cov"] = spacing.cov;
  quality["min_over_mean"] = spacing.min_over_mean;
  quality["connected_cov"] = spacing.connected_cov;
  quality["connected_min"] = spacing.connected_min_over_mean;
  quality["cover_p99"] = coveringOf(samples, cloud, spacing.connected_mean_m).p99_over_spacing;
  return quality;
}

void measure(benchmark::State& state, const Variant& variant) {
  const PoseCloudData& cloud = *variant.from.cloud();
  const SamplingMethod method = variant.make(cloud);
  PeakMemory::reset();
  const double before_mb = PeakMemory::megabytes();
  // Of those that are timed more than once, a first run, after which the heap is as in a node that
  // has run for a while: pages that the kernel has to clear were a quarter of a first run.
  if (!variant.slow) {
    if (method.prepare) method.prepare();
    method.run();
  }
  for (auto _ : state) {
    if (method.prepare) method.prepare();
    const Stopwatch stopwatch;
    method.run();
    const double ns = variant.threads == 1 ? stopwatch.cpu_ns() : stopwatch.wall_ns();
    state.SetIterationTime(1e-9 * ns);
  }
  state.counters["memory_mb"] = PeakMemory::megabytes() - before_mb;
  for (const auto& [name, value] : qualityOf(variant.name, method.result(), cloud.positions_m)) {
    state.counters[name] = value;
  }
  if (!method.stages) return;
  for (const auto& [name, value] : method.stages()) state.counters[name] = value;
}

SamplingMethod ours(const std::string& engine, const std::string& policy, int threads, int samples,
                    const PoseCloudData& cloud) {
  ResampleConfig config;
  config.engine = engine;
  config.count = samples;
  config.threads = threads;
  return ourSampling(config, {makePolicy(policy)}, cloud);
}

void addOurs(const Case& from, std::vector<Variant>* all) {
  for (const std::string engine : {"fast_marching", "flood"}) {
    for (const std::string policy : {"uniform", "range"}) {
      for (const int threads : {1, 2}) {
        const std::string name =
            engine + (policy == "uniform" ? "" : "_" + policy) + (threads == 1 ? "" : "_2_threads");
        all->push_back({"resample/" + name + "/" + from.name, from,
                        [=](const PoseCloudData& cloud) {
                          return ours(engine, policy, threads, from.samples, cloud);
                        },
                        threads});
      }
    }
  }
}

void addOthers(const Case& from, std::vector<Variant>* all) {
  using Make = SamplingMethod (*)(const Points&, std::size_t);
  struct Other {
    const char* name;
    Make make;
    bool slow;
  };
  for (const Other& other :
       {Other{"random", randomSampling, false}, Other{"tree_fps", treeFarthestPoints, false},
        Other{"pcl_voxel_grid", pclVoxelGrid, false},
        Other{"pcl_uniform_sampling", pclUniformSampling, false},
        Other{"pcl_fps", pclFarthestPoints, true},
        Other{"open3d_fps", open3dFarthestPoints, true}}) {
    const std::string family = other.slow ? "resample_slow/" : "resample/";
    const auto count = static_cast<std::size_t>(from.samples);
    all->push_back({family + other.name + "/" + from.name, from,
                    [make = other.make, count](const PoseCloudData& cloud) {
                      return make(cloud.positions_m, count);
                    },
                    1, other.slow});
  }
}

void addGrowth(const std::string& engine, int thousands, int samples, std::vector<Variant>* all) {
  const Case from = campusCase(static_cast<std::size_t>(thousands), samples);
  all->push_back(
      {"growth/" + engine + "/n:" + std::to_string(thousands) + "k/N:" + std::to_string(samples),
       from,
       [=](const PoseCloudData& cloud) { return ours(engine, "uniform", 1, samples, cloud); }});
}

// Of a cloud's points one in so many comes last.
constexpr std::size_t kParts = 60;
bool isInSector(std::size_t /*i*/, const Eigen::Vector3d& p) {
  return std::abs(std::atan2(p.y(), p.x())) < M_PI / kParts;
}
bool isOneInSixty(std::size_t i, const Eigen::Vector3d& /*p*/) { return i % kParts == 0; }

void addExtension(const Case& from, const std::string& engine, std::vector<Variant>* all) {
  struct Part {
    const char* name;
    bool (*is_last)(std::size_t i, const Eigen::Vector3d& p);  // nullptr: all points at once
  };
  for (const Part& part :
       {Part{"sector", isInSector}, Part{"everywhere", isOneInSixty}, Part{"whole", nullptr}}) {
    all->push_back({std::string("extend/") + engine + "/" + part.name + "/" + from.name, from,
                    [=, is_last = part.is_last](const PoseCloudData& cloud) {
                      ResampleConfig config;
                      config.engine = engine;
                      config.count = from.samples;
                      // A count would be one of more samples than there are.
                      const ResampledCloud samples = CloudResampler(config).resample(cloud);
                      config.count = 0;
                      config.radius_m = double{samples.covering_radii.back()};
                      if (is_last == nullptr) return ourSampling(config, {}, cloud);
                      PoseCloudData first;
                      PoseCloudData last;
                      for (std::size_t i = 0; i < cloud.positions_m.size(); ++i) {
                        const Eigen::Vector3d& p = cloud.positions_m[i];
                        (is_last(i, p) ? last : first).positions_m.push_back(p);
                      }
                      return ourExtension(config, first, last);
                    }});
  }
}

std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const Case& from : cases()) {
    addOurs(from, &all);
    addOthers(from, &all);
    for (const std::string engine : {"fast_marching", "flood"}) addExtension(from, engine, &all);
  }
  for (const std::string engine : {"fast_marching", "flood"}) {
    for (int thousands = 25; thousands <= 1600; thousands *= 2) {
      addGrowth(engine, thousands, 250 * thousands, &all);
    }
    for (int samples = 3125; samples <= 50000; samples *= 2) {
      addGrowth(engine, 400, samples, &all);
    }
  }
  return all;
}

}  // namespace
}  // namespace ladar_perception::bench

int main(int argc, char** argv) {
  namespace bench = ladar_perception::bench;
  const auto variants = bench::variants();
  for (const auto& variant : variants) {
    auto* registered = benchmark::RegisterBenchmark(
        variant.name.c_str(),
        [&variant](benchmark::State& state) { bench::measure(state, variant); });
    registered->Unit(benchmark::kMillisecond)->UseManualTime();
    if (variant.slow) registered->Iterations(1)->Repetitions(1);
  }
  return bench::runInterleaved(argc, argv);
}
