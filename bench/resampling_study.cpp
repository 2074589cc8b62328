// SPDX-License-Identifier: BSD-3-Clause
// Measures what the table and figures of Cole, Harrison and Newman show of re-sampling, and how
// good samplings are. bench/reproduce_resampling runs it.
//   resampling_study table FOLDER            the paper's Table I and pictures, on the campus
//   resampling_study quality FOLDER          samplings of the campus against the true surface
//   resampling_study cloud FILE FOLDER SERIES...   one coloured cloud; a series is
//                                            name=policy+policy, or name= for the uniform one
// Writes JSON, and points as float32 records for the pictures.
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "campus_quality.h"
#include "ladar_perception/io/resampled_scan.h"
#include "ladar_perception/io/scan_file.h"
#include "ladar_perception/resample/farthest_points.h"
#include "ladar_perception/resample/sampling_quality.h"
#include "ladar_perception/resample/surface_fit.h"

namespace {

using namespace ladar_perception;
using bench::StandingSensor;
using bench::TrueCloud;
using nlohmann::json;
using Names = std::vector<std::string>;

// The paper's cloud and its samples.
constexpr int kPaperPoints = 380389;
constexpr int kPaperSamples = 55000;
// Owners of cells are written modulo this: enough to tell neighbours apart.
constexpr uint32_t kOwners = 100003;

/// Rows of float32 as they lie in memory.
class RecordFile {
 public:
  explicit RecordFile(const std::string& path) : path_(path), stream_(path, std::ios::binary) {}

  void add(std::initializer_list<double> values) {
    for (const double value : values) {
      const auto single = static_cast<float>(value);
      stream_.write(reinterpret_cast<const char*>(&single), sizeof single);
    }
  }
  void close() {
    stream_.close();
    if (!stream_) throw std::runtime_error(path_ + ": cannot be written");
  }

 private:
  std::string path_;
  std::ofstream stream_;
};

void writeJson(const std::string& path, const json& value) {
  std::ofstream file(path);
  file << value.dump(1) << "\n";
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

/// Policies whose weights are multiplied, under one name.
struct Series {
  std::string name;
  Names policies;
};

/// Last of the policies, it changes nothing and writes the weights that the others gave.
class WeightRecorder : public Policy {
 public:
  explicit WeightRecorder(std::string path) : path_(std::move(path)) {}

  std::string describe() const override { return "recorder"; }
  void multiply(const PointAttributes& points, std::vector<float>* weights) const override {
    RecordFile file(path_);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d& p = points.positions_m[i];
      file.add({p.x(), p.y(), p.z(), double{(*weights)[i]}});
    }
    file.close();
  }

 private:
  std::string path_;
};

void writeRaw(const PoseCloudData& cloud, const std::string& path) {
  RecordFile file(path);
  for (std::size_t i = 0; i < cloud.positions_m.size(); ++i) {
    const Eigen::Vector3d& p = cloud.positions_m[i];
    const uint32_t rgb = cloud.rgb.empty() ? 0x808080U : cloud.rgb[i];
    const int label = cloud.labels.empty() ? 0 : cloud.labels[i];
    file.add({p.x(), p.y(), p.z(), static_cast<double>(rgb), static_cast<double>(label)});
  }
  file.close();
}

json resampleSeries(const PoseCloudData& cloud, const Series& series, const Names& classes,
                    int count, const std::string& folder) {
  Policies policies;
  for (const std::string& text : series.policies) policies.push_back(makePolicy(text, classes));
  ResampleConfig config;
  config.count = count;
  CloudResampler resampler(config);
  const ResampledCloud samples = resampler.resample(cloud, policies);
  if (!policies.empty()) {  // again, so that writing is not timed
    policies.push_back(
        std::make_shared<WeightRecorder>(folder + "/" + series.name + "_weights.bin"));
    resampler.resample(cloud, policies);
  }
  RecordFile file(folder + "/" + series.name + ".bin");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d& p = samples.positions_m[i];
    const uint32_t source = samples.sources[i];
    const uint32_t rgb = cloud.rgb.empty() ? 0x808080U : cloud.rgb[source];
    file.add({p.x(), p.y(), p.z(), static_cast<double>(rgb), samples.weights[i]});
  }
  file.close();
  std::printf("  %s: %zu samples, %.0f ms\n", series.name.c_str(), samples.size(),
              samples.times_ms.total);
  const SpacingStatistics spacing = spacingOf(samples.positions_m);
  return {{"name", series.name},
          {"policies", series.policies},
          {"samples", samples.size()},
          {"total_ms", samples.times_ms.total},
          {"spacing_m", spacing.mean_m},
          {"nn_cov", spacing.cov},
          {"connected_cov", spacing.connected_cov}};
}

/// Fronts when no place is farther than a radius: the cells of the crust with arrival time and
/// owner.
json writeFronts(const PoseCloudData& cloud, const std::string& folder) {
  constexpr double kCellM = 0.1;
  ThreadPool pool(1);
  GridFrame frame;
  frame.cell_m = kCellM;
  frame.origin_m = gridOrigin(cloud.positions_m, kCellM);
  const GridPoints grid = sortIntoGrid(cloud.positions_m, frame);
  const VoxelPyramid pyramid(grid, {}, kBridgeLevels + 1);
  const Crust crust =
      makeSurfelCrust(pyramid, frame, {}, frame.toCells(cloud.sensor_m).cast<float>(), &pool);
  json rows = json::array();
  for (const double radius_m : {6.0, 1.5, 0.5}) {
    FrontField field(crust);
    FarthestPointsGoal goal;
    goal.radius = static_cast<float>(radius_m / kCellM);
    goal.first_radius = 2.0F * goal.radius;
    const SampleSet samples = chooseFarthestPoints<FastMarching>(&field, goal, &pool);
    const std::string name = "fronts_" + std::to_string(rows.size());
    RecordFile file(folder + "/" + name + ".bin");
    for (std::size_t i = 0; i < crust.size(); ++i) {
      const Eigen::Vector3d p = frame.toMetres(crust.positions[i]);
      const auto& arrival = field.arrivals[i];
      const double owner = arrival.owner == kNoIndex ? -1.0 : arrival.owner % kOwners;
      file.add({p.x(), p.y(), p.z(), arrival.time * kCellM, owner});
    }
    file.close();
    rows.push_back({{"name", name}, {"radius_m", radius_m}, {"samples", samples.size()}});
  }
  return rows;
}

/// The classes of the paper's Fig. 7 by the simulator's labels.
constexpr uint8_t kFloor = 1;
constexpr uint8_t kFoliage = 2;
constexpr uint8_t kOther = 3;
const Names kClasses = {"floor", "foliage", "other"};

std::vector<uint8_t> classesOfLabels() {
  std::vector<uint8_t> classes(static_cast<std::size_t>(sim::Label::kGrass) + 1, kOther);
  using sim::Label;
  for (const Label label : {Label::kGround, Label::kPavement, Label::kStep}) {
    classes[static_cast<std::size_t>(label)] = kFloor;
  }
  for (const Label label : {Label::kTrunk, Label::kBranch, Label::kTwig, Label::kFoliage,
                            Label::kShrub, Label::kGrass}) {
    classes[static_cast<std::size_t>(label)] = kFoliage;
  }
  classes[0] = 0;
  return classes;
}

void studyTable(const std::string& folder) {
  StandingSensor sensor;
  sensor.seed = 2;
  sensor.at_m = 94.0;
  sensor.left_m = -9.5;
  sensor.config.points = kPaperPoints;
  sensor.config.range_sigma_m = 0.01;  // that of the paper's kind of scanner, near by
  const TrueCloud scene(sensor);
  const PoseCloudData cloud = scene.poseCloud(classesOfLabels());
  writeRaw(cloud, folder + "/raw.bin");
  const std::string color = "color:target=#d4ccba,softness=60,ratio=16";
  const std::string classes = "label:floor=0.1,foliage=0.3";
  json rows = json::array();
  for (const Series& series :
       {Series{"uniform", {}}, Series{"normals", {"normal_variation:mode=inhibit,ratio=16"}},
        Series{"color", {color}},
        Series{"normals_class", {"normal_variation:mode=inhibit,ratio=64", classes}},
        Series{"color_class", {color, classes}}}) {
    rows.push_back(resampleSeries(cloud, series, kClasses, kPaperSamples, folder));
  }
  const Eigen::Vector3d& origin = scene.sensor_world;
  writeJson(folder + "/table.json", {{"points", cloud.positions_m.size()},
                                     {"series", rows},
                                     {"sensor", {origin.x(), origin.y(), origin.z()}},
                                     {"fronts", writeFronts(cloud, folder)}});
}

void studyQuality(const std::string& folder) {
  struct Case {
    int points;
    int samples;
  };
  json rows = json::array();
  for (const Case& goal : {Case{190000, 50000}, Case{kPaperPoints, kPaperSamples}}) {
    StandingSensor sensor;
    sensor.config.points = goal.points;
    const TrueCloud cloud(sensor);
    for (const std::string engine : {"fast_marching", "flood"}) {
      ResampleConfig config;
      config.count = goal.samples;
      config.engine = engine;
      const ResampledCloud samples = CloudResampler(config).resample(cloud.poseCloud());
      json row = bench::qualityOf(cloud, samples);
      row["engine"] = engine;
      std::printf("  %d points, %s: nn cov %.3f\n", goal.points, engine.c_str(),
                  row["nn_cov"].get<double>());
      rows.push_back(row);
    }
  }
  writeJson(folder + "/quality.json", rows);
}

void studyCloud(const std::string& file, const std::string& folder, const Names& series_texts) {
  Scan scan = readScan(file, scanFormatFromPath(file));
  packColors(&scan);
  const PoseCloudData cloud = poseCloudOf(scan);
  writeRaw(cloud, folder + "/raw.bin");
  json rows = json::array();
  // As many points for a sample as in the paper.
  const auto count = static_cast<int>(cloud.positions_m.size() * kPaperSamples / kPaperPoints);
  for (const std::string& text : series_texts) {
    const std::size_t at = text.find('=');
    if (at == std::string::npos) throw std::runtime_error(text + ": expected name=policies");
    Series series{text.substr(0, at), {}};
    for (std::size_t from = at + 1; from < text.size();) {
      const std::size_t to = std::min(text.find('+', from), text.size());
      series.policies.push_back(text.substr(from, to - from));
      from = to + 1;
    }
    rows.push_back(resampleSeries(cloud, series, kClasses, count, folder));
  }
  writeJson(folder + "/table.json", {{"points", cloud.positions_m.size()}, {"series", rows}});
}

}  // namespace

int main(int argc, char** argv) {
  const Names arguments(argv + 1, argv + argc);
  try {
    if (arguments.size() == 2 && arguments[0] == "table") {
      studyTable(arguments[1]);
    } else if (arguments.size() == 2 && arguments[0] == "quality") {
      studyQuality(arguments[1]);
    } else if (arguments.size() > 3 && arguments[0] == "cloud") {
      studyCloud(arguments[1], arguments[2], {arguments.begin() + 3, arguments.end()});
    } else {
      std::fprintf(stderr,
                   "usage: resampling_study table FOLDER | quality FOLDER | cloud FILE FOLDER "
                   "NAME=POLICIES...\n");
      return 2;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "resampling_study: %s\n", error.what());
    return 1;
  }
  return 0;
}
