// SPDX-License-Identifier: BSD-3-Clause
// Labels every scan of a bag with the nodelet's own code, without a ROS master.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "cloud_message.h"
#include "command_line.h"
#include "ladar_perception/cloud/point_reader.h"
#include "ladar_perception/terrain/truth_confusion.h"
#include "ladar_perception/util/progress.h"
#include "scan_bag_reader.h"
#include "terrain_processor.h"
#include "terrain_statistics.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string input;
  std::string output;
  std::string metrics;
  std::string config;
  std::string model;
  std::string topic;
  int threads = 0;
};

/// 64-bit FNV-1a: one number that changes when any label or confidence does.
class LabelHash {
 public:
  void add(const PointLabel& point) {
    uint32_t confidence = 0;
    std::memcpy(&confidence, &point.confidence, sizeof(confidence));
    addByte(point.label);
    for (int shift = 0; shift < 32; shift += 8) addByte(static_cast<uint8_t>(confidence >> shift));
  }
  std::string hex() const {
    char text[17];
    std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash_));
    return text;
  }

 private:
  void addByte(uint8_t byte) { hash_ = (hash_ ^ byte) * 0x100000001b3ULL; }

  uint64_t hash_ = 0xcbf29ce484222325ULL;
};

Json percentiles(const SampleWindow& window) {
  return {{"p50", window.percentile(0.5)},
          {"p95", window.percentile(0.95)},
          {"p99", window.percentile(0.99)},
          {"max", window.max()}};
}

Json dropJson(const std::vector<DropCount>& drops) {
  Json json = Json::object();
  for (const DropCount& drop : drops) json[drop.reason] = drop.count;
  return json;
}

double maxRss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

Json confusionJson(const TruthConfusion& confusion, const ClassifierModel& model) {
  Json json;
  json["truth_points"] = confusion.points();
  json["truth_points_outside_map"] = confusion.pointsOutsideMap();
  for (std::size_t truth = 1; truth <= model.classes.size(); ++truth) {
    const std::string& name = model.classes[truth - 1].name;
    for (std::size_t label = 0; label <= model.classes.size(); ++label) {
      json["confusion"][name][model.labelName(static_cast<uint8_t>(label))] =
          confusion.count(truth, label);
    }
    if (confusion.truthCount(truth) > 0) json["recall"][name] = confusion.recall(truth);
  }
  json["mean_recall"] = confusion.meanRecall();
  return json;
}

/// The bag that is written; it appears under its name only when it is complete.
class OutputBag {
 public:
  explicit OutputBag(const std::string& path) : path_(path), partial_(path + ".partial") {
    guarded([&] { bag_.open(partial_, rosbag::bagmode::Write); });
  }
  ~OutputBag() {
    if (!bag_.isOpen()) return;
    try {
      bag_.close();
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): already failing
    }
    std::remove(partial_.c_str());
  }
  OutputBag(const OutputBag&) = delete;
  OutputBag& operator=(const OutputBag&) = delete;

  template <typename... Arguments>
  void write(const Arguments&... arguments) {
    guarded([&] { bag_.write(arguments...); });
  }
  void complete() {
    guarded([&] { bag_.close(); });
    if (std::rename(partial_.c_str(), path_.c_str()) == 0) return;
    std::remove(partial_.c_str());
    throw std::runtime_error(path_ + ": cannot be written");
  }

 private:
  template <typename Action>
  void guarded(Action action) {
    try {
      action();
    } catch (const rosbag::BagException& error) {
      throw std::runtime_error(path_ + ": cannot be written: " + error.what());
    }
  }

  std::string path_;
  std::string partial_;
  rosbag::Bag bag_;
};

/// One run over a bag.
class BagClassifier {
 public:
  explicit BagClassifier(const Options& options)
      : options_(options),
        config_(configOf(options)),
        model_(loadFittingModel(config_)),
        processor_(config_, model_, &buffer_),
        reader_(options.input, options.topic, &buffer_),
        statistics_(config_.model, 0),
        confusion_(model_.classes.size()) {}

  void run();

 private:
  static TerrainNodeConfig configOf(const Options& options) {
    TerrainNodeConfig config = readConfigFile<TerrainNodeConfig>(options.config);
    if (!options.model.empty()) config.model = options.model;
    if (options.threads > 0) config.pipeline.threads = options.threads;
    return config;
  }

  void processScan(const ScanBagReader::Scan& scan);
  void writeResults(const ScanBagReader::Scan& scan, const Eigen::Vector3d& p_map_vehicle);
  void addTruth(const sensor_msgs::PointCloud2& cloud);
  Json metrics() const;
  void printSummary() const;

  Options options_;
  TerrainNodeConfig config_;
  ClassifierModel model_;
  // Longer than any wait for tf, shorter than what makes look-ups slow.
  tf2::BufferCore buffer_{ros::Duration(30.0)};
  TerrainProcessor processor_;
  ScanBagReader reader_;
  TerrainStatisticsLog statistics_;
  TruthConfusion confusion_;
  LabelHash hash_;
  std::unique_ptr<OutputBag> output_;
  ros::Time last_map_stamp_;
  double busy_s_ = 0.0;
  std::string first_drop_;
};

void BagClassifier::run() {
  if (!options_.output.empty()) {
    output_ = std::make_unique<OutputBag>(options_.output);
    reader_.setOtherMessageHandler([this](const rosbag::MessageInstance& message) {
      output_->write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
    });
  }
  Progress progress("scans", reader_.scanCount());
  ScanBagReader::Scan scan;
  while (reader_.next(&scan)) {
    processScan(scan);
    progress.advance();
  }
  progress.finish();
  if (output_) output_->complete();
  if (!options_.metrics.empty()) {
    std::ofstream file(options_.metrics);
    file << metrics().dump(2) << "\n";
    if (!file.flush()) throw std::runtime_error(options_.metrics + ": cannot be written");
  }
  printSummary();
  if (statistics_.scans() == 0) {
    throw std::runtime_error(options_.input + ": not one scan could be labelled" +
                             (first_drop_.empty() ? "" : "; the first: " + first_drop_));
  }
}

void BagClassifier::processScan(const ScanBagReader::Scan& scan) {
  // The same patience as the nodelet's, in the time of the bag.
  const ros::Time deadline = scan.recorded + ros::Duration(config_.tf_timeout_s);
  double waited_s = 0.0;
  const auto begin = Clock::now();
  const ScanOutcome outcome =
      processor_.process(*scan.cloud, [&](const std::function<bool()>& ready) {
        const auto wait_begin = Clock::now();
        const bool is_ready = reader_.playUntil(ready, deadline);
        waited_s = std::chrono::duration<double>(Clock::now() - wait_begin).count();
        return is_ready;
      });
  if (outcome.map_reset) {
    statistics_.addReset();
    last_map_stamp_ = ros::Time();
  }
  if (outcome.drop) {
    statistics_.addDrop(*scan.cloud, *outcome.drop);
    if (first_drop_.empty()) {
      first_drop_ = std::string(scanDropName(*outcome.drop)) + ": " + outcome.detail;
    }
    return;
  }
  // Messages are part of a scan's cost, reading and writing the file is not.
  const auto labeled =
      makeLabeledPoints(*scan.cloud, processor_.scanLayout(), processor_.pipeline());
  const double spent_s = std::chrono::duration<double>(Clock::now() - begin).count() - waited_s;
  busy_s_ += spent_s;
  statistics_.addScan(*scan.cloud, processor_.pipeline().report(), spent_s * 1e3);
  for (const PointLabel& point : processor_.pipeline().pointLabels()) hash_.add(point);
  addTruth(*scan.cloud);
  if (output_) {
    output_->write("/labeled_points", scan.recorded, *labeled);
    writeResults(scan, outcome.p_map_vehicle);
  }
}

void BagClassifier::writeResults(const ScanBagReader::Scan& scan,
                                 const Eigen::Vector3d& p_map_vehicle) {
  const ros::Time& stamp = scan.cloud->header.stamp;
  if (config_.map_rate_hz <= 0.0) return;
  if (!last_map_stamp_.isZero() && (stamp - last_map_stamp_).toSec() < 1.0 / config_.map_rate_hz) {
    return;
  }
  last_map_stamp_ = stamp;
  std_msgs::Header header = scan.cloud->header;
  header.frame_id = config_.map_frame;
  output_->write(
      "/labeled_map", scan.recorded,
      *makeLabeledMap(processor_.pipeline(), header, p_map_vehicle, config_.map_radius_m));
}

void BagClassifier::addTruth(const sensor_msgs::PointCloud2& cloud) {
  const CloudLayout& layout = processor_.scanLayout();
  const Field* truth = layout.find("truth");
  if (truth == nullptr) return;
  std::vector<double> values;
  readScalars({layout, cloud.data.data(), cloud.data.size()}, *truth, &values);
  confusion_.add(values, processor_.pipeline().pointLabels(), processor_.pipeline().pointCells());
}

Json BagClassifier::metrics() const {
  const TerrainStatistics message = statistics_.message(model_);
  Json json;
  json["input"] = options_.input;
  json["topic"] = reader_.topic();
  json["model"] = message.model;
  json["scans"] = message.scans;
  json["points_in"] = message.points_in;
  json["points_inserted"] = message.points_inserted;
  json["dropped"] = dropJson(message.points_dropped);
  json["scans_dropped"] = dropJson(message.scans_dropped);
  json["resets"] = message.resets;
  json["voxels_max"] = statistics_.maxOccupiedVoxels();
  json["rss_mb_max"] = maxRss_mb();
  json["map_mb"] = static_cast<double>(message.memory_bytes) * 1e-6;
  json["latency_ms"] = percentiles(statistics_.latencyMs());
  for (int i = 0; i < kStages; ++i) {
    const auto stage = static_cast<Stage>(i);
    json["stages_ms"][stageName(stage)] = percentiles(statistics_.stageMs(stage));
  }
  json["points_per_second"] =
      busy_s_ > 0.0 ? static_cast<double>(message.points_in) / busy_s_ : 0.0;
  for (const ClassCount& count : message.labels) json["label_counts"][count.name] = count.count;
  json["label_hash"] = hash_.hex();
  if (confusion_.points() > 0) json.update(confusionJson(confusion_, model_));
  return json;
}

void BagClassifier::printSummary() const {
  const TerrainStatistics message = statistics_.message(model_);
  std::printf("%s: %lu scans labelled, %lu dropped, %lu points, %lu inserted\n",
              options_.input.c_str(), static_cast<unsigned long>(message.scans),
              static_cast<unsigned long>(statistics_.scansDropped()),
              static_cast<unsigned long>(message.points_in),
              static_cast<unsigned long>(message.points_inserted));
  std::printf("latency p50 %.1f ms, p99 %.1f ms, at most %zu voxels\n", message.latency_p50_ms,
              message.latency_p99_ms, statistics_.maxOccupiedVoxels());
  for (const DropCount& drop : message.scans_dropped) {
    if (drop.count > 0) {
      std::printf("scans dropped, %s: %lu\n", drop.reason.c_str(),
                  static_cast<unsigned long>(drop.count));
    }
  }
  if (!first_drop_.empty()) std::printf("first dropped scan: %s\n", first_drop_.c_str());
  if (confusion_.points() > 0) {
    std::printf("mean recall %.3f over %lu points with truth\n", confusion_.meanRecall(),
                static_cast<unsigned long>(confusion_.points()));
  }
}

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  ladar_perception::Options options;
  CLI::App app(
      "Labels every scan of a bag as the terrain nodelet would, without a ROS master. The "
      "result is the same bits on every run and for any number of threads.");
  app.add_option("input", options.input, "bag with a PointCloud2 topic and /tf")->required();
  app.add_option("--out", options.output,
                 "bag to write: /labeled_points, /labeled_map and all other messages of the input");
  app.add_option("--metrics", options.metrics, "JSON file to write: counts, latencies, accuracy");
  app.add_option("--config", options.config, "parameters, as config/terrain.yaml");
  app.add_option("--model", options.model, "classifier model, in place of the configuration's");
  app.add_option("--topic", options.topic, "the clouds' topic, needed when the bag has several");
  app.add_option("--threads", options.threads, "in place of the configuration's")
      ->check(CLI::Range(1, 64));
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  try {
    ladar_perception::BagClassifier(options).run();
  } catch (const std::exception& error) {
    std::cerr << "classify_bag: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
