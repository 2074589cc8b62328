// SPDX-License-Identifier: BSD-3-Clause
#include "pose_clouds.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <memory>

#include "ladar_perception/io/scan_file.h"
#include "ladar_perception/sim/ladar.h"
#include "ladar_perception/sim/world.h"

namespace ladar_perception::bench {
namespace {

constexpr double kHighest_deg = 30.0;
constexpr double kLowest_deg = -60.0;

/// As many rows per degree as columns on the horizon.
sim::LadarConfig standingSensor(double beams) {
  sim::LadarConfig config;
  config.rate_hz = 0.1;
  config.width_deg = 360.0;
  config.rows = static_cast<int>(
      std::lround(std::sqrt(beams * (kHighest_deg - kLowest_deg) / config.width_deg)));
  config.columns = static_cast<int>(std::lround(beams / config.rows));
  for (int row = 0; row < config.rows; ++row) {
    config.row_elevations_deg.push_back(kHighest_deg -
                                        (kHighest_deg - kLowest_deg) * row / config.rows);
  }
  config.tilt_down_deg = 0.0;
  config.nod_amplitude_deg = 0.0;
  config.pan_amplitude_deg = 0.0;
  return config;
}

std::vector<sim::Return> returnsOf(double beams) {
  constexpr uint64_t kSeed = 1;
  static const sim::World kWorld = sim::makeWorld("campus", kSeed);
  static const sim::VehiclePath kPath(kWorld.circuit, kWorld.scene.ground(), 0.0);
  const sim::Ladar ladar(standingSensor(beams), kWorld.scene, kPath, kSeed);
  std::vector<sim::Return> returns;
  for (const sim::Return& beam : ladar.takeScan(0)) {
    if (beam.valid()) returns.push_back(beam);
  }
  return returns;
}

/// Beams for a little more returns than are asked for.
double beamsFor(std::size_t points) {
  constexpr double kProbe = 20000.0;
  static const double kShare = static_cast<double>(returnsOf(kProbe).size()) / kProbe;
  return 1.03 * static_cast<double>(points) / kShare;
}

PoseCloudData makeCampus(std::size_t points) {
  double beams = beamsFor(points);
  std::vector<sim::Return> returns = returnsOf(beams);
  while (returns.size() < points) {
    beams *= 1.03;
    returns = returnsOf(beams);
  }
  PoseCloudData cloud;
  for (std::size_t i = 0; i < points; ++i) {
    const sim::Return& beam = returns[i * returns.size() / points];
    cloud.positions_m.push_back(beam.p_ladar.cast<double>());
    cloud.rgb.push_back(beam.rgb);
    cloud.labels.push_back(static_cast<uint8_t>(beam.truth));
  }
  return cloud;
}

PoseCloudData readReal(const std::string& name) {
  const char* given = std::getenv("LADAR_DATA");
  const std::string folder = given != nullptr ? given : LADAR_SOURCE_DIR "/../shared/data";
  const Scan scan = name == "kitti00"
                        ? readScan(folder + "/kitti00/000000.bin", ScanFormat::kKitti)
                        : readScan(folder + "/3dtk_indoor/scan000.3d", ScanFormat::k3dtk);
  const std::vector<double> x = readColumn(scan, "x");
  const std::vector<double> y = readColumn(scan, "y");
  const std::vector<double> z = readColumn(scan, "z");
  PoseCloudData cloud;
  for (std::size_t i = 0; i < x.size(); ++i) cloud.positions_m.emplace_back(x[i], y[i], z[i]);
  return cloud;
}

}  // namespace

const PoseCloudData& campusCloud(std::size_t points) {
  static std::map<std::size_t, PoseCloudData> made;
  const auto it = made.find(points);
  return it != made.end() ? it->second : made.emplace(points, makeCampus(points)).first->second;
}

const PoseCloudData* realCloud(const std::string& name) {
  static std::map<std::string, std::unique_ptr<PoseCloudData>> read;
  const auto it = read.find(name);
  if (it != read.end()) return it->second.get();
  std::unique_ptr<PoseCloudData>& cloud = read[name];
  try {
    cloud = std::make_unique<PoseCloudData>(readReal(name));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cloud %s is left out: %s\n", name.c_str(), error.what());
  }
  return cloud.get();
}

}  // namespace ladar_perception::bench
