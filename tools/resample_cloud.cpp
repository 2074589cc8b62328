// SPDX-License-Identifier: BSD-3-Clause
// resample_cloud: re-samples one cloud by farthest points on its surface, from file to file.
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_line.h"
#include "ladar_perception/io/output_file.h"
#include "ladar_perception/io/resampled_scan.h"
#include "ladar_perception/io/scan_file.h"
#include "ladar_perception/io/scan_writer.h"
#include "ladar_perception/resample/cloud_resampler.h"
#include "ladar_perception/resample/sampling_quality.h"
#include "package_path.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string input;
  std::string format;
  std::vector<std::string> columns;
  std::string out;
  std::string metrics;
  std::vector<std::string> policies;
  std::string classes;
  std::string label_field = "label";
  std::vector<double> sensor_m = {0.0, 0.0, 0.0};
  ResampleConfig config;
};

const std::vector<std::string> kTerrainClasses = {"surface", "scatter", "linear"};

void addInputOptions(CLI::App& app, Options& o) {
  app.add_option("input", o.input, "Cloud to re-sample")->required()->type_name("FILE");
  app.add_option("--format", o.format,
                 "Of the input, where its extension does not tell: oakland (x y z label "
                 "confidence), kitti (.bin), pcd, ply, xyz (text columns, csv too), vtk (ASCII "
                 "polydata), 3dtk (.3d)")
      ->check(CLI::IsMember(scanFormatNames()));
  app.add_option("--columns", o.columns, "Names of the columns of xyz, '_' skips one: x,y,z,t")
      ->delimiter(',')
      ->allow_extra_args(false);  // or it would take the input behind it
  app.add_option("--sensor", o.sensor_m,
                 "Where the sensor was, m, in the frame of the cloud: ranges count from here and "
                 "normals point to it; 0 0 0 if not given")
      ->expected(3)
      ->type_name("X Y Z");
}

void addSamplingOptions(CLI::App& app, Options& o) {
  ResampleConfig& c = o.config;
  app.add_option("--count", c.count, "Stop at exactly this many samples")
      ->check(CLI::Range(1, 100000000));
  app.add_option("--radius", c.radius_m,
                 "Stop when no place of the surface is farther than this from a sample, m (where "
                 "the weight is 1)");
  app.add_option("--time", c.time_budget_s, "Stop after this many seconds");
  app.add_option("--policy", o.policies,
                 "Density wanted relative to elsewhere; several are multiplied: uniform, "
                 "range:min=3, normal_variation:mode=attract|inhibit,ratio=16, "
                 "color:target=#b08060,softness=40,ratio=16, label:surface=0.2,linear=5")
      ->allow_extra_args(false)
      ->type_name("SPEC");
  app.add_option("--classes", o.classes,
                 "File that maps labels to the classes of label policies, as for "
                 "train_classifier; without it labels are 1 surface, 2 scatter, 3 linear");
  app.add_option("--label-field", o.label_field, "Field with the labels")->capture_default_str();
  app.add_option("--engine", c.engine, "fast_marching (along the surface) or flood (a bit faster)")
      ->check(CLI::IsMember({"fast_marching", "flood"}))
      ->capture_default_str();
  app.add_option("--crust", c.crust, "surfels (fast) or ellipsoids (the paper's)")
      ->check(CLI::IsMember({"surfels", "ellipsoids"}))
      ->capture_default_str();
  app.add_option("--cell-size", c.cell_size_m, "Edge of the finest cells, m; 0: chosen")
      ->capture_default_str();
  app.add_option("--min-component", c.min_component_points,
                 "Islands of the surface with fewer points get no samples")
      ->capture_default_str();
  app.add_flag("--nearest-original", c.nearest_original,
               "Write the original points nearest to the samples");
  app.add_option("--threads", c.threads, "The result does not depend on it")->capture_default_str();
}

void addOutputOptions(CLI::App& app, Options& o) {
  app.add_option("--out", o.out,
                 "Cloud to write, farthest samples first: .pcd, .ply, .xyz, .txt or .csv; all "
                 "fields of the nearest original points, normals, covering radius")
      ->required()
      ->type_name("FILE");
  app.add_option("--metrics", o.metrics, "JSON to write: counts, times, how even the samples are");
}

double msSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Peak of this process so far, MiB.
double residentMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// Violations of the configuration, by the names of the arguments.
void checkConfig(const ResampleConfig& config) {
  if (config.count == 0 && config.radius_m == 0.0 && config.time_budget_s == 0.0) {
    throw std::runtime_error("--count, --radius or --time is required");
  }
  ResampleConfig copy = config;
  ParamTable table;
  copy.addTo(&table);
  ParamMap given;
  given["count"] = config.count;
  given["radius_m"] = config.radius_m;
  given["time_budget_s"] = config.time_budget_s;
  given["cell_size_m"] = config.cell_size_m;
  given["min_component_points"] = config.min_component_points;
  given["threads"] = config.threads;
  std::string report;
  for (const std::string& violation : table.apply(given)) {
    report += (report.empty() ? "" : "; ") + violation;
  }
  if (!report.empty()) throw std::runtime_error(report);
}

/// One run from file to file.
class Resampling {
 public:
  /// Finds everything that is wrong with the arguments and outputs, before any work.
  explicit Resampling(const Options& options) : options_(options) {
    checkConfig(options.config);
    for (const double value : options.sensor_m) {
      if (!std::isfinite(value)) throw std::runtime_error("--sensor: a coordinate is not finite");
    }
    format_ = options.format.empty() ? scanFormatFromPath(options.input)
                                     : scanFormatFromName(options.format);
    if (!options.columns.empty() && format_ != ScanFormat::kXyz) {
      throw std::runtime_error("--columns is for the format xyz, not " +
                               scanFormatNames()[static_cast<std::size_t>(format_)]);
    }
    out_format_ = writtenFormat(options.out);
    makePolicies();
    resampler_ = std::make_unique<CloudResampler>(options.config);
    out_ = std::make_unique<OutputFile>(options.out);
    if (!options.metrics.empty()) metrics_ = std::make_unique<OutputFile>(options.metrics);
  }

  void run() {
    const auto begin = Clock::now();
    readInput();
    read_ms_ = msSince(begin);
    samples_ = resampler_->resample(cloud_, policies_);
    rss_mb_ = residentMb();
    if (samples_.size() == 0) {
      throw std::runtime_error(
          options_.input + ": has no surface to sample: " + std::to_string(samples_.points_finite) +
          " finite points of " + std::to_string(samples_.points_in));
    }
    const auto write_begin = Clock::now();
    writeScan(resampledScan(scan_, samples_), out_format_, &out_->stream());
    out_->complete();
    write_ms_ = msSince(write_begin);
    if (metrics_) {
      metrics_->stream() << metrics().dump(2) << "\n";
      metrics_->complete();
    }
    printSummary();
  }

 private:
  void makePolicies();
  void readInput();
  Json metrics() const;
  void printSummary() const;

  Options options_;
  ScanFormat format_ = ScanFormat::kPcd;
  ScanFormat out_format_ = ScanFormat::kPcd;
  ClassMapping mapping_;  // empty without --classes
  Policies policies_;
  bool needs_labels_ = false;
  std::unique_ptr<CloudResampler> resampler_;
  std::unique_ptr<OutputFile> out_;
  std::unique_ptr<OutputFile> metrics_;
  Scan scan_;
  PoseCloudData cloud_;
  ResampledCloud samples_;
  double read_ms_ = 0.0;
  double write_ms_ = 0.0;
  double rss_mb_ = 0.0;
};

void Resampling::makePolicies() {
  if (!options_.classes.empty()) {
    mapping_ = loadClassMapping(resolvePackagePath(options_.classes));
  }
  for (const std::string& specification : options_.policies) {
    policies_.push_back(
        makePolicy(specification, mapping_.names.empty() ? kTerrainClasses : mapping_.names));
    // Fields that no policy asks for may hold anything.
    needs_labels_ = needs_labels_ || specification.rfind("label", 0) == 0;
  }
}

void Resampling::readInput() {
  scan_ = readScan(options_.input, format_, options_.columns);
  try {
    packColors(&scan_);
    cloud_ = poseCloudOf(scan_);
    cloud_.sensor_m = Eigen::Vector3d(options_.sensor_m.data());
    if (!needs_labels_) return;
    if (mapping_.names.empty()) {
      const auto classes = static_cast<int>(kTerrainClasses.size());
      cloud_.labels = labelsOf(scan_, options_.label_field, classes);
    } else {
      cloud_.labels = labelsOf(scan_, options_.label_field, mapping_);
    }
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(options_.input + ": " + error.what());
  }
}

Json Resampling::metrics() const {
  std::vector<Eigen::Vector3d> reference;
  for (const Eigen::Vector3d& p : cloud_.positions_m) {
    if (p.allFinite()) reference.push_back(p);
  }
  const SpacingStatistics spacing = spacingOf(samples_.positions_m);
  const CoveringStatistics covering = coveringOf(samples_.positions_m, reference, spacing.mean_m);
  const ResampleTimes& times = samples_.times_ms;
  Json json;
  json["input"] = options_.input;
  json["policies"] = Json::array();
  for (const auto& policy : policies_) json["policies"].push_back(policy->describe());
  json["engine"] = options_.config.engine;
  json["crust"] = options_.config.crust;
  json["threads"] = options_.config.threads;
  json["points_in"] = samples_.points_in;
  json["points_finite"] = samples_.points_finite;
  json["cells"] = samples_.cells;
  json["cell_size_m"] = samples_.cell_size_m;
  json["components"] = samples_.components;
  json["dropped_components"] = samples_.dropped_components;
  json["lone_points"] = samples_.lone_points;
  json["samples"] = samples_.size();
  json["times_ms"] = {{"voxels", times.voxels},   {"attributes", times.attributes},
                      {"crust", times.crust},     {"fronts", times.fronts},
                      {"samples", times.samples}, {"total", times.total}};
  json["read_ms"] = read_ms_;
  json["write_ms"] = write_ms_;
  json["mean_spacing"] = spacing.mean_m;
  json["nn_cov"] = spacing.cov;
  json["min_over_mean"] = spacing.min_over_mean;
  json["isolated_samples"] = spacing.isolated;
  json["nn_cov_connected"] = spacing.connected_cov;
  json["cover_p99_over_spacing"] = covering.p99_over_spacing;
  json["cover_max_over_spacing"] = covering.max_over_spacing;
  json["rss_mb"] = rss_mb_;
  return json;
}

void Resampling::printSummary() const {
  std::printf("%s: %zu samples of %llu points in %.1f ms", options_.out.c_str(), samples_.size(),
              static_cast<unsigned long long>(samples_.points_in), samples_.times_ms.total);
  const uint64_t lost = samples_.points_in - samples_.points_finite;
  if (lost > 0) std::printf(", %llu points not finite", static_cast<unsigned long long>(lost));
  if (samples_.dropped_components > 0) {
    std::printf(", %llu islands without samples",
                static_cast<unsigned long long>(samples_.dropped_components));
  }
  if (samples_.lone_points > 0) {
    std::printf(", %llu lone points", static_cast<unsigned long long>(samples_.lone_points));
  }
  std::printf("\n");
  const auto wanted = static_cast<std::size_t>(options_.config.count);
  const bool other_stop = options_.config.radius_m > 0.0 || options_.config.time_budget_s > 0.0;
  if (samples_.size() < wanted && !other_stop) {
    std::cerr << "note: the surface holds " << samples_.size() << " samples, not " << wanted
              << "\n";
  }
}

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  CLI::App app(
      "Re-samples a cloud: samples lie evenly on the surface that its points are of, or as "
      "densely\n"
      "as policies want them, farthest first, so that any number of the first ones is a good\n"
      "sampling, too. Stops at the first of --count, --radius and --time that is reached.");
  app.name("resample_cloud");
  app.footer(
      "Example: rosrun ladar_perception resample_cloud scan.pcd --count 50000 --policy range "
      "--out small.pcd --metrics m.json");
  ladar_perception::Options options;
  addInputOptions(app, options);
  addSamplingOptions(app, options);
  addOutputOptions(app, options);
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  try {
    ladar_perception::Resampling(options).run();
  } catch (const std::exception& error) {
    std::cerr << "resample_cloud: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
