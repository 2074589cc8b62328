// SPDX-License-Identifier: BSD-3-Clause
// simulate_ladar: drives a simulated ladar through a scene and records a bag with true classes.
#include <ros/time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_line.h"
#include "ladar_perception/io/output_file.h"
#include "ladar_perception/io/scan_writer.h"
#include "ladar_perception/sim/drifting_odometry.h"
#include "ladar_perception/sim/scan_cloud.h"
#include "ladar_perception/sim/sensors.h"
#include "ladar_perception/sim/true_cloud.h"
#include "ladar_perception/sim/world.h"
#include "ladar_perception/util/progress.h"
#include "scan_bag_writer.h"

namespace {

using ladar_perception::Progress;
using ladar_perception::ScanBagWriter;
using ladar_perception::sim::DriftingOdometry;
using ladar_perception::sim::Ladar;
using ladar_perception::sim::LadarConfig;
using ladar_perception::sim::ScanSummary;
using ladar_perception::sim::VehiclePath;
using ladar_perception::sim::World;

// Not the clock of the machine: the same arguments give the same bytes.
constexpr double kStartS = 1000.0;
constexpr double kPoseRateHz = 100.0;

struct Options {
  std::string scene = "flat_ground";
  double duration_s = 20.0;
  double speed_m_s = 2.0;
  uint64_t seed = 1;
  std::string sensor = "xuv";
  double sensor_height_m = 0.0;  // 0: the sensor's own
  std::string look;              // empty: where the sensor looks by itself
  double drift_percent = 0.0;
  double drift_deg = 0.0;
  std::string out;
  std::string cloud;
  ladar_perception::sim::TrueCloudConfig dense;
  // On campus this is between bicycles, a brick building, trees and the street.
  double at_m = 152.0;
  double left_m = -4.5;
};

bool drifts(const Options& options) {
  return options.drift_percent != 0.0 || options.drift_deg != 0.0;
}

ros::Time stampAt(double time_s) {
  // Rounded to nanoseconds once, so that equal times give equal stamps.
  const auto nanoseconds = static_cast<uint64_t>(std::llround((kStartS + time_s) * 1e9));
  ros::Time stamp;
  stamp.fromNSec(nanoseconds);
  return stamp;
}

/// Writes poses at a fixed rate, in step with the scans.
class PoseRecorder {
 public:
  PoseRecorder(const VehiclePath& path, const Ladar& ladar, const Options& options,
               ScanBagWriter* bag)
      : path_(path),
        ladar_(ladar),
        odometry_(options.drift_percent, options.drift_deg),
        has_drift_(drifts(options)),
        bag_(bag) {}

  /// Writes all poses not yet written up to `time_s`. The first lies before time 0, because
  /// transforms can be interpolated only between two samples.
  void writeUntil(double time_s) {
    for (; static_cast<double>(next_) / kPoseRateHz <= time_s + 1e-9; ++next_) {
      const double t = static_cast<double>(next_) / kPoseRateHz;
      const Eigen::Isometry3d T_truth_base = path_.T_odom_base(t);
      bag_->writeTransform(stampAt(t), "odom", "base_link",
                           has_drift_ ? odometry_.next(T_truth_base) : T_truth_base);
      if (has_drift_) bag_->writePose(stampAt(t), "/ground_truth", "truth", T_truth_base);
      bag_->writeTransform(stampAt(t), "base_link", "ladar", ladar_.T_base_ladar(t));
    }
  }

 private:
  const VehiclePath& path_;
  const Ladar& ladar_;
  DriftingOdometry odometry_;
  bool has_drift_;
  ScanBagWriter* bag_;
  int64_t next_ = -1;
};

double percent(uint64_t part, uint64_t whole) {
  return 100.0 * static_cast<double>(part) / static_cast<double>(std::max<uint64_t>(whole, 1));
}

void printSummary(const Options& options, uint64_t scans, const ScanSummary& sum, double seconds) {
  std::printf("%s: scene %s, seed %llu, %llu scans, %llu points, %.1f %% returned, %.1f s\n",
              options.out.c_str(), options.scene.c_str(),
              static_cast<unsigned long long>(options.seed), static_cast<unsigned long long>(scans),
              static_cast<unsigned long long>(sum.beams), percent(sum.returned, sum.beams),
              seconds);
  std::printf("of the returns: surface %.1f %%, scatter %.1f %%, linear %.1f %%, mixed %.1f %%\n",
              percent(sum.surface, sum.returned), percent(sum.scatter, sum.returned),
              percent(sum.linear, sum.returned), percent(sum.mixed, sum.returned));
}

LadarConfig chosenSensor(const Options& options) {
  LadarConfig config = ladar_perception::sim::sensorConfig(options.sensor);
  if (options.sensor_height_m > 0.0) config.mount_height_m = options.sensor_height_m;
  if (options.look == "left") config.heads_deg = {90.0};
  if (options.look == "both") {
    config.heads_deg = {90.0, -90.0};
    config.columns *= 2;
  }
  return config;
}

void simulate(const Options& options) {
  const LadarConfig config = chosenSensor(options);
  const auto scans =
      static_cast<uint64_t>(std::max(1.0, std::floor(options.duration_s * config.rate_hz + 1e-9)));
  const auto begin = std::chrono::steady_clock::now();
  ScanBagWriter bag(options.out, "/points");  // first: a wrong path should not cost a scene
  const World world = ladar_perception::sim::makeWorld(options.scene, options.seed);
  const VehiclePath path(world.circuit, world.scene.ground(), options.speed_m_s);
  const Ladar ladar(config, world.scene, path, options.seed);
  const auto layout = ladar_perception::sim::scanLayout(config);
  PoseRecorder poses(path, ladar, options, &bag);
  ScanSummary summary;
  Progress progress("scans", scans);
  for (uint64_t i = 0; i < scans; ++i) {
    const double start_s = ladar.startTime(i);
    const auto scan = ladar.takeScan(i);
    const bool is_dense =
        std::all_of(scan.begin(), scan.end(), [](const auto& beam) { return beam.valid(); });
    // The bag is in the order of time: a cloud is complete one scan period after its stamp.
    poses.writeUntil(start_s + config.scanPeriod());
    bag.writeCloud(stampAt(start_s), stampAt(start_s + config.scanPeriod()), "ladar", layout,
                   ladar_perception::sim::encodeScan(scan, config), is_dense);
    summary.add(scan);
    progress.advance();
  }
  poses.writeUntil(ladar.startTime(scans) + 1.0 / kPoseRateHz);
  progress.finish();
  bag.close();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  printSummary(options, scans, summary, elapsed.count());
}

using ladar_perception::Column;
using ladar_perception::ScalarType;
using ladar_perception::sim::TruePoint;

ladar_perception::Scan toScan(const std::vector<TruePoint>& points) {
  std::vector<Column> columns;
  const auto add = [&](const std::string& name, ScalarType type,
                       const std::function<double(const TruePoint&)>& value) {
    Column column{name, type, {}};
    column.values.reserve(points.size());
    for (const TruePoint& point : points) column.values.push_back(value(point));
    columns.push_back(std::move(column));
  };
  const auto addVector = [&](const std::string& prefix, Eigen::Vector3d TruePoint::*member) {
    for (int axis = 0; axis < 3; ++axis) {
      add(prefix + "xyz"[axis], ScalarType::kFloat32,
          [=](const TruePoint& point) { return (point.*member)[axis]; });
    }
  };
  addVector("", &TruePoint::p_m);
  add("intensity", ScalarType::kFloat32, [](const TruePoint& p) { return double{p.intensity}; });
  add("rgb", ScalarType::kFloat32, [](const TruePoint& p) {
    float bits = 0.0F;
    std::memcpy(&bits, &p.rgb, sizeof bits);
    return double{bits};
  });
  add("truth", ScalarType::kUint8, [](const TruePoint& p) { return static_cast<double>(p.truth); });
  add("label", ScalarType::kUint16,
      [](const TruePoint& p) { return static_cast<double>(p.label); });
  addVector("true_", &TruePoint::p_true_m);
  addVector("true_normal_", &TruePoint::normal);
  add("face", ScalarType::kUint32, [](const TruePoint& p) { return static_cast<double>(p.face); });
  return ladar_perception::makeScan(columns);
}

/// One dense cloud of a sensor that stands still.
void simulateCloud(const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  const ladar_perception::ScanFormat format = ladar_perception::writtenFormat(options.cloud);
  ladar_perception::OutputFile file(options.cloud);
  const World world = ladar_perception::sim::makeWorld(options.scene, options.seed);
  const double height_m = options.sensor_height_m > 0.0 ? options.sensor_height_m : 1.7;
  const Eigen::Vector3d sensor_world =
      ladar_perception::sim::placeBesideTrack(world, options.at_m, options.left_m, height_m);
  const auto points =
      ladar_perception::sim::takeTrueCloud(world.scene, sensor_world, options.dense, options.seed);
  if (points.empty()) throw std::runtime_error("the sensor sees nothing from there");
  ladar_perception::writeScan(toScan(points), format, &file.stream());
  file.complete();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  std::printf("%s: scene %s, seed %llu, %zu points from (%.3f, %.3f, %.3f), %.1f s\n",
              options.cloud.c_str(), options.scene.c_str(),
              static_cast<unsigned long long>(options.seed), points.size(), sensor_world.x(),
              sensor_world.y(), sensor_world.z(), elapsed.count());
}

/// CLI::Range lets NaN pass: every comparison with it is false.
std::string finite(const std::string& text) {
  const bool is_nan = std::isnan(std::strtod(text.c_str(), nullptr));
  return is_nan ? "Value " + text + " is not a number" : "";
}

void addOptions(CLI::App* app, Options* options) {
  app->add_option(
         "--scene", options->scene,
         "What to drive through: flat_ground (fences, hedges, power lines), forest, "
         "tall_grass (up to 1 m), campus (buildings, cars, bicycles), street (houses, trees, "
         "wires, parked cars), scrubland (low bushes, grass and rocks on slopes)")
      ->check(CLI::IsMember(ladar_perception::sim::sceneNames()))
      ->capture_default_str();
  app->add_option(
         "--sensor", options->sensor,
         "xuv (range images from a turret, 20 Hz), vlp16 (16 rings, 10 Hz), hdl64 and os64 "
         "(64 rings, 10 Hz), pushbroom (a vertical plane beside the vehicle, 37.5 lines "
         "a second, five a cloud)")
      ->check(CLI::IsMember(ladar_perception::sim::sensorNames()))
      ->capture_default_str();
  app->add_option("--sensor-height", options->sensor_height_m,
                  "Height of the sensor above the ground under the vehicle, m, 0.2 to 5; each "
                  "sensor has its own by default")
      ->check(CLI::Range(0.2, 5.0))
      ->check(finite);
  app->add_option("--look", options->look,
                  "Side that the pushbroom looks to: left, right (its default) or both")
      ->check(CLI::IsMember({"left", "right", "both"}));
  app->add_option("--duration", options->duration_s,
                  "Seconds to record, 0.05 to 3600; at least one scan")
      ->check(CLI::Range(0.05, 3600.0))
      ->check(finite)
      ->capture_default_str();
  app->add_option("--speed", options->speed_m_s,
                  "Speed of the vehicle along its closed track, m/s, 0 to 15")
      ->check(CLI::Range(0.0, 15.0))
      ->check(finite)
      ->capture_default_str();
  app->add_option("--seed", options->seed,
                  "Number that names the scene and the noise; the same arguments give the same "
                  "bytes")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->add_option(
         "--odometry-scale-error", options->drift_percent,
         "Percent by which odometry measures too far, -50 to 50; the true poses are then on "
         "/ground_truth")
      ->check(CLI::Range(-50.0, 50.0))
      ->check(finite)
      ->capture_default_str();
  app->add_option("--odometry-heading-drift", options->drift_deg,
                  "Degrees per 100 m by which odometry turns to the left, -90 to 90; true poses as "
                  "before")
      ->check(CLI::Range(-90.0, 90.0))
      ->check(finite)
      ->capture_default_str();
  app->add_option("--out", options->out, "Bag to write; replaced if it exists")
      ->type_name("FILE.bag");
}

void addCloudOptions(CLI::App* app, Options* options) {
  const std::string group = "One dense cloud instead of a bag";
  auto* cloud = app->add_option("--cloud", options->cloud,
                                "Cloud to write (.pcd, .ply, .xyz) of a sensor that stands still "
                                "and sees all around, with positions from the sensor, colours, "
                                "classes and, of every point, the place and the normal of the true "
                                "surface and the number of the flat face it lies on (0: none)");
  cloud->type_name("FILE")->group(group)->excludes("--out")->excludes("--sensor");
  cloud->excludes("--look")->excludes("--duration")->excludes("--speed");
  cloud->excludes("--odometry-scale-error")->excludes("--odometry-heading-drift");
  const auto add = [&](const std::string& name, double* value, double low, double high,
                       const std::string& help) {
    app->add_option(name, *value, help)
        ->check(CLI::Range(low, high))
        ->check(finite)
        ->capture_default_str()
        ->group(group)
        ->needs(cloud);
  };
  app->add_option("--points", options->dense.points, "About as many points, 1000 to 10000000")
      ->check(CLI::Range(1000, 10000000))
      ->capture_default_str()
      ->group(group)
      ->needs(cloud);
  add("--range-noise", &options->dense.range_sigma_m, 0.0, 1.0,
      "Standard deviation of the ranges, m");
  add("--at", &options->at_m, 0.0, 1e4, "Where the sensor stands along the track, m");
  add("--left", &options->left_m, -50.0, 50.0, "How far to the left of the track, m");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Simulates a ladar on a vehicle that drives through a scene, and records a bag: organised "
      "clouds with\nper-point times, true classes (1 surface, 2 scatter, 3 linear, 0 unknown), "
      "finer labels\n(config/classes/simulated_three.yaml names them) and colours on /points, and "
      "odom -> base_link -> ladar\non /tf.");
  app.name("simulate_ladar");
  app.footer("Example: rosrun ladar_perception simulate_ladar --scene forest --out forest.bag");
  Options options;
  addOptions(&app, &options);
  addCloudOptions(&app, &options);
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  if (options.out.empty() && options.cloud.empty()) {
    std::cerr << "simulate_ladar: --out FILE.bag or --cloud FILE is required\n";
    return 1;
  }
  if (!options.look.empty() && options.sensor != "pushbroom") {
    std::cerr << "simulate_ladar: --look " << options.look << " is for --sensor pushbroom, not "
              << options.sensor << "\n";
    return 1;
  }
  try {
    options.cloud.empty() ? simulate(options) : simulateCloud(options);
  } catch (const std::exception& error) {
    std::cerr << "simulate_ladar: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
