// SPDX-License-Identifier: BSD-3-Clause
// Turns files of scans, with or without poses and labels, into a bag that the nodelets can play.
#include <ros/time.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "command_line.h"
#include "ladar_perception/io/class_mapping.h"
#include "ladar_perception/io/point_stream.h"
#include "ladar_perception/io/pose_file.h"
#include "ladar_perception/io/scan_file.h"
#include "package_path.h"
#include "scan_bag_writer.h"

namespace ladar_perception {
namespace {

struct Options {
  std::vector<std::string> inputs;
  std::string out_path;
  std::string format_name;
  std::vector<std::string> columns;
  bool stream = false;
  std::string order_name = "sweep";
  double points_per_second = 1e5;
  std::string poses_path;
  std::string pose_format_name = "kitti";
  double rate_hz = 10.0;
  double start_time_s = 1000.0;
  bool start_time_given = false;
  double sensor_height_m = 0.0;
  std::string classes_path;
  std::string label_field = "label";
  bool label_field_given = false;
  std::string topic = "/points";
  std::string map_frame = "odom";
  std::string base_frame = "base_link";
  std::string sensor_frame = "ladar";
};

void addOptions(CLI::App& app, Options& o) {
  const CLI::Validator positive(
      [](const std::string& text) {
        double value = 0.0;
        const bool fits = CLI::detail::lexical_cast(text, value) && value > 0.0 && value < 1e9;
        return fits ? std::string() : "'" + text + "', expected a number above 0 and below 1e9";
      },
      "");
  app.add_option("inputs", o.inputs, "Files in this order, or folders (sorted naturally)")
      ->required()
      ->type_name("FILE|FOLDER");
  app.add_option("--out", o.out_path, "Bag to write")->required()->type_name("F.bag");
  app.add_option("--format", o.format_name,
                 "oakland (x y z label confidence), kitti (.bin, .label beside or in ../labels), "
                 "pcd, ply, xyz (text columns, csv too), vtk (ASCII polydata), 3dtk (.3d)")
      ->required()
      ->check(CLI::IsMember(scanFormatNames()));
  app.add_option("--columns", o.columns, "Names of the columns of xyz, '_' skips one: x,y,z,t")
      ->delimiter(',')
      ->allow_extra_args(false);  // or it would take the inputs behind it
  app.add_option("--poses", o.poses_path,
                 "One pose of the sensor in the map a line, in the order of the scans; without it "
                 "every pose is the identity");
  app.add_option("--pose-format", o.pose_format_name,
                 "kitti (row-major 3x4 or 4x4) or tum (stamp x y z qx qy qz qw; the stamps become "
                 "those of the scans)")
      ->check(CLI::IsMember({"kitti", "tum"}))
      ->capture_default_str();
  app.add_flag("--stream", o.stream,
               "Inputs are surveyed tiles in the map frame: replay each as scans of a vehicle that "
               "follows its points (always so with oakland)");
  app.add_option(
         "--order", o.order_name,
         "Of a stream: sweep (along the tile's main axis, all objects of a place together) or file")
      ->check(CLI::IsMember({"sweep", "file"}))
      ->capture_default_str();
  app.add_option("--points-per-second", o.points_per_second, "Of a stream")
      ->check(positive)
      ->capture_default_str();
  app.add_option("--rate", o.rate_hz, "Scans per second")->check(positive)->capture_default_str();
  auto* start = app.add_option("--start-time", o.start_time_s, "Stamp of the first scan in seconds")
                    ->capture_default_str();
  start->each([&o](const std::string&) { o.start_time_given = true; });
  app.add_option("--sensor-height", o.sensor_height_m,
                 "Metres from the base frame (on the ground) up to the sensor; KITTI: 1.73")
      ->capture_default_str();
  app.add_option("--classes", o.classes_path,
                 "Mapping of labels to the field `truth`, see config/classes; oakland has "
                 "oakland_three.yaml as default");
  auto* label = app.add_option("--label-field", o.label_field, "Field with the labels")
                    ->capture_default_str();
  label->each([&o](const std::string&) { o.label_field_given = true; });
  app.add_option("--topic", o.topic, "Of the clouds")->capture_default_str();
  app.add_option("--map-frame", o.map_frame, "Frame of the poses")->capture_default_str();
  app.add_option("--base-frame", o.base_frame, "Frame of the vehicle")->capture_default_str();
  app.add_option("--sensor-frame", o.sensor_frame, "Frame of the clouds")->capture_default_str();
}

/// Brings scans in order into the bag, with their stamps, transforms and truth.
class Importer {
 public:
  explicit Importer(const Options& options)
      : options_(options),
        format_(scanFormatFromName(options.format_name)),
        is_stream_(options.stream || format_ == ScanFormat::kOakland),
        period_(1.0 / options.rate_hz) {
    checkOptions();
    files_ = listScanFiles(options.inputs, format_);
    readMapping();
    if (!is_stream_) takePoses();
    checkSeconds(stampOf(0).toSec() - period_.toSec());  // the first pose; ros::Time would overflow
    T_base_ladar_.translation().z() = options.sensor_height_m;
  }

  void run() {
    ScanBagWriter writer(options_.out_path, options_.topic);
    writer_ = &writer;
    const ros::Time before_first = stampOf(0) - period_;
    writer.writeStaticTransform(before_first, options_.base_frame, options_.sensor_frame,
                                T_base_ladar_);
    for (std::size_t i = 0; i < files_.size(); ++i) importFile(i);
    if (scans_ == 0) throw std::runtime_error("the inputs have no points");
    // So that tf can be interpolated around the last scan.
    writePose(stampOf(scans_ - 1) + period_);
    writer.close();
    writer_ = nullptr;
  }

  void printSummary() const {
    const double duration_s = (stampOf(scans_ - 1) - stampOf(0)).toSec();
    std::printf("%s: %zu scans, %zu points, %.3f s", options_.out_path.c_str(), scans_, points_,
                duration_s);
    if (invalid_scans_ > 0) std::printf(", %zu scans with invalid points", invalid_scans_);
    if (has_truth_) {
      std::printf("; truth: ignored %zu", truth_counts_[0]);
      for (std::size_t c = 0; c < mapping_.names.size(); ++c) {
        std::printf(", %s %zu", mapping_.names[c].c_str(), truth_counts_[c + 1]);
      }
    }
    std::printf("\n");
  }

 private:
  void checkOptions() const {
    if (is_stream_ && !options_.poses_path.empty()) {
      throw std::runtime_error("--poses is not for a stream: its points are in the map frame");
    }
    if (!options_.columns.empty() && format_ != ScanFormat::kXyz) {
      throw std::runtime_error("--columns is for --format xyz only");
    }
    if (is_stream_ && std::llround(options_.points_per_second / options_.rate_hz) < 1) {
      throw std::runtime_error("--points-per-second must be at least --rate");
    }
    if (!std::isfinite(options_.sensor_height_m)) {
      throw std::runtime_error("--sensor-height must be a finite number");
    }
    if (options_.map_frame == options_.base_frame || options_.map_frame == options_.sensor_frame ||
        options_.base_frame == options_.sensor_frame) {
      throw std::runtime_error("--map-frame, --base-frame and --sensor-frame must differ");
    }
    checkSeconds(options_.start_time_s);
  }

  static void checkSeconds(double stamp_s) {
    constexpr double kMaxStampS = 4294967295.0;  // ros::Time counts in uint32
    if (stamp_s > 0.0 && stamp_s < kMaxStampS) return;
    throw std::runtime_error("stamp " + std::to_string(stamp_s) +
                             " s is not a time that a bag can hold; set --start-time");
  }

  void readMapping() {
    std::string path = options_.classes_path;
    if (path.empty() && format_ == ScanFormat::kOakland)
      path = resolvePackagePath("package://ladar_perception/config/classes/oakland_three.yaml");
    if (path.empty()) {
      if (options_.label_field_given) throw std::runtime_error("--label-field needs --classes");
      return;
    }
    mapping_ = loadClassMapping(path);
    has_truth_ = true;
  }

  void takePoses() {
    if (options_.poses_path.empty()) {
      std::cerr << "note: no --poses given: every pose is the identity\n";
      return;
    }
    const bool is_tum = options_.pose_format_name == "tum";
    poses_ = readPoses(options_.poses_path, is_tum ? PoseFormat::kTum : PoseFormat::kKitti);
    const std::string counts = options_.poses_path + ": " +
                               std::to_string(poses_.T_map_lidar.size()) + " poses for " +
                               std::to_string(files_.size()) + " scans";
    if (poses_.T_map_lidar.size() < files_.size()) {
      throw std::runtime_error(counts + ", expected one for each");
    }
    if (poses_.T_map_lidar.size() > files_.size()) {
      std::cerr << "warning: " << counts << ", the last ones are not used\n";
    }
    for (const double stamp_s : poses_.stamps_s) {
      if (!options_.start_time_given) checkSeconds(stamp_s);
    }
  }

  ros::Time stampOf(std::size_t scan) const {
    if (poses_.stamps_s.empty()) {
      return ros::Time(options_.start_time_s) +
             ros::Duration(static_cast<double>(scan) / options_.rate_hz);
    }
    if (!options_.start_time_given) return ros::Time(poses_.stamps_s[scan]);
    return ros::Time(options_.start_time_s) +
           ros::Duration(poses_.stamps_s[scan] - poses_.stamps_s[0]);
  }

  void importFile(std::size_t i) {
    const std::string& path = files_[i];
    Scan scan = readScan(path, format_, options_.columns);
    if (scan.size() == 0) std::cerr << "warning: " << path << ": has no points\n";
    if (has_truth_) tagTruth(path, scan);
    std::cerr << "[" << i + 1 << "/" << files_.size() << "] " << path << ": " << scan.size()
              << " points\n";
    if (is_stream_) {
      importStream(scan);
    } else {
      const bool posed = !poses_.T_map_lidar.empty();
      writeScan(std::move(scan), posed ? poses_.T_map_lidar[i] : Eigen::Isometry3d::Identity());
    }
  }

  void tagTruth(const std::string& path, Scan& scan) {
    try {
      addTruth(scan, options_.label_field, mapping_);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(path + ": " + error.what() + "; needed by --classes");
    }
    for (const double truth : readColumn(scan, "truth")) {
      ++truth_counts_[static_cast<std::size_t>(truth)];
    }
  }

  void importStream(const Scan& tile) {
    StreamConfig config;
    config.points_per_scan =
        static_cast<std::size_t>(std::llround(options_.points_per_second / options_.rate_hz));
    config.order = options_.order_name == "file" ? StreamOrder::kFile : StreamOrder::kSweep;
    for (const StreamScan& scan : cutStream(tile, config)) {
      const Eigen::Isometry3d T_map_ladar = scan.T_map_vehicle * T_base_ladar_;
      writeScan(takeStreamScan(tile, scan, T_map_ladar), T_map_ladar);
    }
  }

  void writePose(const ros::Time& stamp) {
    writer_->writeTransform(stamp, options_.map_frame, options_.base_frame, T_map_base_);
  }

  void writeScan(Scan scan, const Eigen::Isometry3d& T_map_ladar) {
    const ros::Time stamp = stampOf(scans_);
    T_map_base_ = T_map_ladar * T_base_ladar_.inverse();
    if (scans_ == 0) writePose(stamp - period_);
    writePose(stamp);
    points_ += scan.size();
    if (!scan.is_dense) ++invalid_scans_;
    writer_->writeCloud(stamp, stamp, options_.sensor_frame, scan.layout, std::move(scan.data),
                        scan.is_dense);
    ++scans_;
  }

  Options options_;
  ScanFormat format_;
  bool is_stream_;
  ros::Duration period_;
  std::vector<std::string> files_;
  bool has_truth_ = false;
  ClassMapping mapping_;
  Poses poses_;
  Eigen::Isometry3d T_base_ladar_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_base_ = Eigen::Isometry3d::Identity();
  ScanBagWriter* writer_ = nullptr;  ///< while run() runs
  std::size_t scans_ = 0;
  std::size_t points_ = 0;
  std::size_t invalid_scans_ = 0;
  std::array<std::size_t, 256> truth_counts_{};
};

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  CLI::App app(
      "Turns files of scans, with or without poses and labels, into a bag with clouds, /tf "
      "and /tf_static that the nodelets can play.",
      "import_scans");
  ladar_perception::Options options;
  ladar_perception::addOptions(app, options);
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  try {
    ladar_perception::Importer importer(options);
    importer.run();
    importer.printSummary();
  } catch (const std::exception& error) {
    std::cerr << "import_scans: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
