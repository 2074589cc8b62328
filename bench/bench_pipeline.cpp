// SPDX-License-Identifier: BSD-3-Clause
// Latency of the whole pipeline per scan, from the bytes of a cloud to the bytes of the labelled
// one, for simulated sensors in the simulated forest:
//   latency/<sensor>/<what is varied>:<value>
// ring turns at 10 Hz and sees all around; patch looks ahead at 20 Hz (90 x 20 degrees, panning).
// What is not varied: 1.3 M points/s, a map of 20 x 20 x 3 m, voxels of 10 cm, k = 9, one thread.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "interleaved_main.h"
#include "ladar_perception/cloud/labeled_cloud.h"
#include "ladar_perception/sim/ladar.h"
#include "ladar_perception/sim/scan_cloud.h"
#include "ladar_perception/sim/world.h"
#include "ladar_perception/terrain/terrain_pipeline.h"

namespace ladar_perception::bench {
namespace {

constexpr double kUsualRate = 1.3e6;
constexpr double kSpeed_m_s = 5.0;

/// A scan with all the pipeline needs of it.
struct RecordedScan {
  CloudLayout layout;
  std::vector<uint8_t> bytes;
  std::vector<float> time_offsets_s;
  SensorMotion motion{Eigen::Isometry3d::Identity()};
  Eigen::Vector3d p_map_vehicle;
};

sim::LadarConfig sensorConfig(const std::string& sensor, double points_per_s) {
  sim::LadarConfig config;
  if (sensor == "ring") {
    config.rate_hz = 10.0;
    config.width_deg = 360.0;
    config.height_deg = 28.0;
    config.pan_amplitude_deg = 0.0;
    config.nod_amplitude_deg = 0.0;
    config.rows = 64;
  }
  const double per_scan = points_per_s / config.rate_hz;
  if (sensor == "patch") {
    // As many rows per degree as columns.
    config.rows = static_cast<int>(std::lround(std::sqrt(per_scan * 20.0 / 90.0)));
  }
  config.columns = static_cast<int>(std::lround(per_scan / config.rows));
  return config;
}

std::vector<RecordedScan> record(const sim::LadarConfig& config) {
  constexpr double kDuration_s = 2.0;
  constexpr uint64_t kSeed = 1;
  static const sim::World kWorld = sim::makeWorld("forest", kSeed);
  const sim::VehiclePath path(kWorld.circuit, kWorld.scene.ground(), kSpeed_m_s);
  const sim::Ladar ladar(config, kWorld.scene, path, kSeed);
  std::vector<RecordedScan> scans;
  for (uint64_t i = 0; i < static_cast<uint64_t>(kDuration_s * config.rate_hz); ++i) {
    const sim::Scan scan = ladar.takeScan(i);
    RecordedScan out;
    out.layout = sim::scanLayout(config);
    out.bytes = sim::encodeScan(scan, config);
    for (const sim::Return& beam : scan) out.time_offsets_s.push_back(beam.time_s);
    std::vector<SensorMotion::Knot> knots;
    constexpr int kIntervals = 10;
    for (int knot = 0; knot <= kIntervals; ++knot) {
      const double offset_s = config.scanPeriod() * knot / kIntervals;
      const double t = ladar.startTime(i) + offset_s;
      knots.push_back({offset_s, path.T_odom_base(t) * ladar.T_base_ladar(t)});
    }
    out.motion = SensorMotion(std::move(knots));
    out.p_map_vehicle = path.T_odom_base(ladar.startTime(i)).translation();
    scans.push_back(std::move(out));
  }
  return scans;
}

/// Scans are simulated when they are first asked for, and kept.
const std::vector<RecordedScan>& scansOf(const std::string& sensor, double points_per_s) {
  static std::map<std::pair<std::string, double>, std::vector<RecordedScan>> recorded;
  auto& scans = recorded[{sensor, points_per_s}];
  if (scans.empty()) scans = record(sensorConfig(sensor, points_per_s));
  return scans;
}

struct Variant {
  std::string name;
  std::string sensor = "ring";
  double points_per_s = kUsualRate;
  TerrainConfig config;
  bool reuse = true;  ///< false: every voxel is computed anew at every scan
  std::string features;  ///< a set of features in place of the starter model's
};

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

double updateMilliseconds(const ScanReport& report) {
  return report.stage_ms[static_cast<int>(Stage::kSum)] +
         report.stage_ms[static_cast<int>(Stage::kClassify)] +
         report.stage_ms[static_cast<int>(Stage::kSmooth)];
}

/// Replays the scans; latencies of the second half, when the map is full, are added to `*ms`.
void replay(const Variant& variant, TerrainPipeline* pipeline, std::vector<double>* ms,
            double* updated_share) {
  const auto& scans = scansOf(variant.sensor, variant.points_per_s);
  pipeline->reset();
  double updated = 0.0;
  double occupied = 0.0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const RecordedScan& scan = scans[i];
    const CloudView cloud{scan.layout, scan.bytes.data(), scan.bytes.size()};
    const auto begin = std::chrono::steady_clock::now();
    std::string error;
    const auto fields = findPointFields(cloud, &error);
    pipeline->process(cloud, *fields, scan.time_offsets_s, scan.motion, scan.p_map_vehicle);
    // Without re-use, what the scan has brought up to date already must not count twice.
    const double twice_ms = variant.reuse ? 0.0 : updateMilliseconds(pipeline->report());
    if (!variant.reuse) pipeline->updateAllVoxels();
    std::vector<uint8_t> labeled;
    writeLabeledCloud(cloud, pipeline->pointLabels(), labeledLayout(scan.layout), &labeled);
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - begin;
    if (i < scans.size() / 2) continue;
    const ScanReport& report = pipeline->report();
    ms->push_back(elapsed.count() - twice_ms);
    updated += static_cast<double>(report.updated_voxels);
    occupied += static_cast<double>(report.occupied_voxels);
  }
  *updated_share = updated / occupied;
}

/// As many Gaussians as the model has, on other features: what they are does not change what they
/// cost.
void replaceFeatures(const std::string& set, ClassifierModel* model) {
  model->features = parseFeatures({set});
  const auto n = static_cast<Eigen::Index>(model->features.size());
  for (ModelClass& model_class : model->classes) {
    for (GaussianComponent& component : model_class.mixture) {
      component.mean = Eigen::VectorXd::Zero(n);
      component.covariance = Eigen::MatrixXd::Identity(n, n);
    }
  }
}

void latency(benchmark::State& state, const Variant& variant) {
  ClassifierModel model = loadClassifierModel(LADAR_SOURCE_DIR "/config/models/starter.yaml");
  // What is learned does not change what it costs.
  model.voxel_size_m = variant.config.voxel_size_m;
  model.support_radius_voxels = variant.config.support_radius_voxels;
  model.support_kernel = variant.config.support_kernel;
  if (!variant.features.empty()) replaceFeatures(variant.features, &model);
  TerrainPipeline pipeline(variant.config, model);
  std::vector<double> ms;
  double updated_share = 0.0;
  for (auto _ : state) {
    replay(variant, &pipeline, &ms, &updated_share);
    state.SetIterationTime(1e-3 * percentile(ms, 0.5));
  }
  state.counters["p50_ms"] = percentile(ms, 0.5);
  state.counters["p99_ms"] = percentile(ms, 0.99);
  state.counters["voxels"] = static_cast<double>(pipeline.report().occupied_voxels);
  state.counters["updated"] = updated_share;
  state.counters["points"] = static_cast<double>(pipeline.report().points_in);
  state.counters["memory_mb"] = 1e-6 * static_cast<double>(pipeline.report().memory_bytes);
}

std::vector<Variant> variants() {
  std::vector<Variant> all;
  const auto add = [&](const std::string& sensor, const std::string& name,
                       const std::function<void(Variant*)>& change) {
    Variant variant;
    variant.name = "latency/" + sensor + "/" + name;
    variant.sensor = sensor;
    change(&variant);
    all.push_back(variant);
  };
  for (const char* sensor : {"ring", "patch"}) {
    for (const int thousands : {100, 300, 1300, 5000}) {
      add(sensor, "points_per_s:" + std::to_string(thousands) + "k",
          [=](Variant* v) { v->points_per_s = 1e3 * thousands; });
    }
    for (const char* features : {"saliency", "directions", "standard"}) {
      for (const bool smooth : {false, true}) {
        add(sensor, std::string("features:") + features + (smooth ? "_smoothed" : ""),
            [=](Variant* v) {
              v->features = features;
              v->config.smooth_labels = smooth;
            });
      }
    }
    add(sensor, "reuse:off", [](Variant* v) { v->reuse = false; });
    for (const int size_m : {10, 40, 80}) {
      add(sensor, "map_m:" + std::to_string(size_m),
          [=](Variant* v) { v->config.map_size_x_m = v->config.map_size_y_m = size_m; });
    }
    add(sensor, "height_m:6.4", [](Variant* v) { v->config.map_size_z_m = 6.4; });
    for (const int size_cm : {5, 20}) {
      add(sensor, "voxel_cm:" + std::to_string(size_cm),
          [=](Variant* v) { v->config.voxel_size_m = 0.01 * size_cm; });
    }
    for (const int k : {3, 5, 7, 11, 13}) {
      add(sensor, "k:" + std::to_string(k),
          [=](Variant* v) { v->config.support_radius_voxels = k / 2; });
    }
    add(sensor, "threads:2", [](Variant* v) { v->config.threads = 2; });
    add(sensor, "kernel:gaussian", [](Variant* v) { v->config.support_kernel = "gaussian"; });
    add(sensor, "forget_after_scans:10", [](Variant* v) { v->config.forget_after_scans = 10; });
  }
  return all;
}

}  // namespace
}  // namespace ladar_perception::bench

int main(int argc, char** argv) {
  namespace bench = ladar_perception::bench;
  const auto variants = bench::variants();
  for (const auto& variant : variants) {
    benchmark::RegisterBenchmark(
        variant.name.c_str(),
        [&variant](benchmark::State& state) { bench::latency(state, variant); })
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime()
        ->Iterations(1);
  }
  return bench::runInterleaved(argc, argv);
}
