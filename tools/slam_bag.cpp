// SPDX-License-Identifier: BSD-3-Clause
// slam_bag: the delayed-state estimate of a recorded drive, without a ROS master.
#include <geometry_msgs/PoseStamped.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "command_line.h"
#include "delayed_state_node_config.h"
#include "ladar_perception/io/output_file.h"
#include "ladar_perception/io/scan_writer.h"
#include "ladar_perception/resample/cloud_resampler.h"
#include "ladar_perception/slam/surface_registration.h"
#include "ladar_perception/util/progress.h"
#include "map_cloud.h"
#include "pose_cloud_message.h"
#include "pose_cloud_reader.h"
#include "pose_collector.h"
#include "scan_bag_reader.h"
#include "slam_report.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string input;
  std::string output;
  std::string poses_config;
  std::string slam_config;
  std::string topic;
  std::string truth_topic = "/ground_truth";
  int count = 0;
  double pose_distance_m = 0.0;
  int threads = 0;
};

double msSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// True poses of the vehicle by their stamps.
class TruthLog {
 public:
  void add(const geometry_msgs::PoseStamped& message) {
    const auto& p = message.pose.position;
    const auto& q = message.pose.orientation;
    Eigen::Isometry3d T(Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized());
    T.translation() = Eigen::Vector3d(p.x, p.y, p.z);
    if (T.matrix().allFinite()) poses_[message.header.stamp.toNSec()] = T;
  }
  /// In between, interpolated; nothing before the first and after the last.
  std::optional<Eigen::Isometry3d> at(uint64_t stamp_ns) const {
    const auto after = poses_.lower_bound(stamp_ns);
    if (after == poses_.end()) return std::nullopt;
    if (after->first == stamp_ns) return after->second;
    if (after == poses_.begin()) return std::nullopt;
    const auto before = std::prev(after);
    const double share = static_cast<double>(stamp_ns - before->first) /
                         static_cast<double>(after->first - before->first);
    return plus(before->second, share * minus(after->second, before->second));
  }

 private:
  std::map<uint64_t, Eigen::Isometry3d> poses_;
};

void writeMapCloud(const std::string& path, const std::vector<StatePose>& poses,
                   const PoseGraph& graph) {
  const MapCloud map = makeMapCloud(poses, graph, 0);
  OutputFile file(path);
  writeScan({map.layout, map.bytes}, ScanFormat::kPcd, &file.stream());
  file.complete();
}

/// One run over a bag.
class BagSlam {
 public:
  explicit BagSlam(const Options& options)
      : options_(options),
        poses_config_(posesConfigOf(options)),
        policies_(loadPolicies(poses_config_)),
        slam_config_(slamConfigOf(options)),
        collector_(poses_config_, &buffer_),
        resampler_(poses_config_.resampler),
        state_(slam_config_.state, surfaceRegistration(slam_config_.registration)),
        reader_(options.input, options.topic, &buffer_) {}

  void run();

 private:
  static PoseResamplerNodeConfig posesConfigOf(const Options& options) {
    PoseResamplerNodeConfig config = readConfigFile<PoseResamplerNodeConfig>(options.poses_config);
    if (options.count > 0) config.resampler.count = options.count;
    if (options.pose_distance_m > 0.0) config.keeper.pose_distance_m = options.pose_distance_m;
    if (options.threads > 0) config.resampler.threads = options.threads;
    return config;
  }
  static DelayedStateNodeConfig slamConfigOf(const Options& options) {
    DelayedStateNodeConfig config = readConfigFile<DelayedStateNodeConfig>(options.slam_config);
    if (options.threads > 0) config.state.threads = options.threads;
    return config;
  }

  void processScan(const ScanBagReader::Scan& scan);
  void reportDrop(const std::string& reason, const std::string& detail);
  void addPose(const CollectedPose& pose);
  void writeResults();
  Json metrics() const;
  void printSummary() const;
  std::string file(const char* name) const { return options_.output + "/" + name; }

  Options options_;
  PoseResamplerNodeConfig poses_config_;
  Policies policies_;
  DelayedStateNodeConfig slam_config_;
  // Longer than any wait for tf, shorter than what makes look-ups slow.
  tf2::BufferCore buffer_{ros::Duration(30.0)};
  PoseCollector collector_;
  CloudResampler resampler_;
  DelayedState state_;
  ScanBagReader reader_;
  TruthLog truth_;
  std::vector<uint64_t> stamps_ns_;
  std::map<std::string, uint64_t> dropped_;  // scans, and poses, by reason
  std::string first_drop_;
  uint64_t scans_ = 0;
  uint64_t points_in_ = 0;
  uint64_t samples_ = 0;
  int loops_closed_ = 0;
  int64_t residual_evaluations_ = 0;
  std::map<std::string, std::vector<double>> times_ms_;  // of poses by stage
};

void BagSlam::run() {
  std::error_code error;
  std::filesystem::create_directories(options_.output, error);
  if (error) throw std::runtime_error(options_.output + ": cannot be made: " + error.message());
  reader_.setOtherMessageHandler([this](const rosbag::MessageInstance& message) {
    if (message.getTopic() != options_.truth_topic) return;
    const auto pose = message.instantiate<geometry_msgs::PoseStamped>();
    if (pose) truth_.add(*pose);
  });
  Progress progress("scans", reader_.scanCount());
  ScanBagReader::Scan scan;
  while (reader_.next(&scan)) {
    processScan(scan);
    progress.advance();
  }
  if (const auto last = collector_.close()) addPose(*last);
  progress.finish();
  if (state_.size() == 0) {
    throw std::runtime_error(options_.input + ": not one pose could be kept" +
                             (first_drop_.empty() ? "" : "; the first: " + first_drop_));
  }
  const auto begin = Clock::now();
  state_.optimize();
  times_ms_["final"].push_back(msSince(begin));
  writeResults();
  printSummary();
}

void BagSlam::processScan(const ScanBagReader::Scan& scan) {
  ++scans_;
  // The same patience as the nodelet's, in the time of the bag.
  const ros::Time deadline = scan.recorded + ros::Duration(poses_config_.tf_timeout_s);
  const CollectOutcome outcome = collector_.process(
      *scan.cloud,
      [&](const std::function<bool()>& ready) { return reader_.playUntil(ready, deadline); });
  if (outcome.time_jumped) {
    throw std::runtime_error(options_.input + ": time jumps back at scan " +
                             std::to_string(scans_) + ": these are two drives");
  }
  if (outcome.drop) reportDrop(scanDropName(*outcome.drop), outcome.detail);
  for (const CollectedPose& pose : outcome.complete) addPose(pose);
}

void BagSlam::reportDrop(const std::string& reason, const std::string& detail) {
  ++dropped_[reason];
  if (first_drop_.empty()) first_drop_ = reason + ": " + detail;
}

void BagSlam::addPose(const CollectedPose& pose) {
  const auto begin = Clock::now();
  const ResampledCloud cloud = resampler_.resample(pose.pose.points, policies_);
  times_ms_["resampling"].push_back(msSince(begin));
  // By way of the message: the nodelet that receives it has the same bits.
  const PoseCloudPtr message =
      makePoseCloud(pose, poses_config_.odom_frame, {}, makeSampleCloud(pose, cloud));
  StatePose added;
  std::string detail;
  if (const auto drop = readPoseCloud(*message, &added, &detail)) {
    reportDrop(std::string("pose_") + stateDropName(*drop), detail);
    return;
  }
  const AddReport report = state_.add(added);
  times_ms_["search"].push_back(report.search_ms);
  times_ms_["registration"].push_back(report.registration_ms);
  times_ms_["optimization"].push_back(report.optimization_ms);
  times_ms_["total"].push_back(msSince(begin));
  stamps_ns_.push_back(pose.pose.stamp_ns);
  points_in_ += cloud.points_in;
  samples_ += cloud.size();
  loops_closed_ += report.closed_loop ? 1 : 0;
  residual_evaluations_ += report.residual_evaluations;
}

void BagSlam::writeResults() {
  std::vector<double> stamps_s;
  Trajectory estimate;
  Trajectory odometry;
  for (int i = 0; i < state_.size(); ++i) {
    stamps_s.push_back(state_.pose(i).stamp_s);
    estimate.push_back(state_.graph().pose(i));
    odometry.push_back(state_.pose(i).T_odom_pose);
  }
  writeTum(file("trajectory_tum.txt"), stamps_s, estimate);
  writeKitti(file("trajectory_kitti.txt"), estimate);
  writeTum(file("odometry_tum.txt"), stamps_s, odometry);
  writeMapCloud(file("map.pcd"), state_.poses(), state_.graph());
  state_.save(file("state.bin"));
  for (const auto& [name, json] :
       {std::pair("graph.json", graphJson(state_)), std::pair("metrics.json", metrics())}) {
    std::ofstream out(file(name));
    out << json.dump(1) << "\n";
    if (!out.flush()) throw std::runtime_error(file(name) + ": cannot be written");
  }
}

Json BagSlam::metrics() const {
  Json json;
  json["input"] = options_.input;
  json["topic"] = reader_.topic();
  json["scans"] = scans_;
  json["scans_dropped"] = dropped_;
  json["poses"] = state_.size();
  json["points_in"] = points_in_;
  json["samples"] = samples_;
  json["cloud_mb"] = static_cast<double>(state_.cloudBytes()) * 1e-6;
  json["constraints"] = countsJson(state_);
  json["loops_closed"] = loops_closed_;
  json["residual_evaluations"] = residual_evaluations_;
  for (const auto& [stage, values] : times_ms_) json["times_ms"][stage] = percentilesJson(values);
  json["pose_ms"] = times_ms_.at("total");
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  json["rss_mb_max"] = static_cast<double>(usage.ru_maxrss) / 1024.0;
  Trajectory odometry;
  Trajectory estimate;
  Trajectory truth;
  for (int i = 0; i < state_.size(); ++i) {
    const auto true_pose = truth_.at(stamps_ns_[static_cast<std::size_t>(i)]);
    if (!true_pose) continue;
    truth.push_back(*true_pose);
    odometry.push_back(state_.pose(i).T_odom_pose);
    estimate.push_back(state_.graph().pose(i));
  }
  if (!truth.empty()) json["error"] = errorJson(odometry, estimate, truth);
  return json;
}

void BagSlam::printSummary() const {
  const ConstraintCounts& counts = state_.counts();
  std::printf("%s: %lu scans, %d poses, %lu of %lu registrations accepted, %d loop closures\n",
              options_.input.c_str(), static_cast<unsigned long>(scans_), state_.size(),
              static_cast<unsigned long>(counts.accepted), static_cast<unsigned long>(counts.tried),
              loops_closed_);
  const Json json = metrics();
  std::printf("a pose took %.1f ms (median), re-sampling %.1f, registration %.1f\n",
              json["times_ms"]["total"]["p50"].get<double>(),
              json["times_ms"]["resampling"]["p50"].get<double>(),
              json["times_ms"]["registration"]["p50"].get<double>());
  if (json.contains("error")) {
    std::printf("error from the start: odometry %.3f m, estimate %.3f m (rms)\n",
                json["error"]["odometry"]["rms_m"].get<double>(),
                json["error"]["estimate"]["rms_m"].get<double>());
  }
  if (!first_drop_.empty()) std::printf("first dropped scan: %s\n", first_drop_.c_str());
}

void addOptions(CLI::App* app, Options* options) {
  app->add_option("input", options->input, "bag with a PointCloud2 topic and /tf")->required();
  app->add_option("--out", options->output,
                  "folder to write: trajectory_tum.txt, trajectory_kitti.txt, odometry_tum.txt, "
                  "graph.json, map.pcd, state.bin, metrics.json")
      ->required();
  app->add_option(
      "--poses", options->poses_config,
      "which poses are kept and how they are re-sampled, as config/pose_resampler.yaml");
  app->add_option("--config", options->slam_config, "the estimate, as config/delayed_state.yaml");
  app->add_option("--topic", options->topic, "the clouds' topic, needed when the bag has several");
  app->add_option("--truth-topic", options->truth_topic,
                  "true poses of the vehicle, geometry_msgs/PoseStamped")
      ->capture_default_str();
  app->add_option("--count", options->count, "samples a pose, in place of the configuration's")
      ->check(CLI::Range(10, 10000000));
  app->add_option("--pose-distance", options->pose_distance_m,
                  "m from pose to pose, in place of the configuration's")
      ->check(CLI::Range(0.01, 1000.0));
  app->add_option("--threads", options->threads, "in place of the configurations'")
      ->check(CLI::Range(1, 64));
}

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  ladar_perception::Options options;
  CLI::App app(
      "Estimates the poses of a recorded drive: keeps poses, re-samples their clouds, registers "
      "those that overlap\nand optimises all of them. The trajectory is the same bits on every run "
      "and for any number of threads.");
  app.name("slam_bag");
  app.footer("Example: rosrun ladar_perception slam_bag drive.bag --out drive_slam");
  addOptions(&app, &options);
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  try {
    ladar_perception::BagSlam(options).run();
  } catch (const std::exception& error) {
    std::cerr << "slam_bag: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
