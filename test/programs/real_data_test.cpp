// SPDX-License-Identifier: BSD-3-Clause
// Real scans through import_scans and classify_bag: nothing that is finite and in range is lost.
// Skipped where the data is not (see LADAR_DATA).
#include <array>
#include <cmath>
#include <iostream>

#include "program_bag.h"
#include "program_run.h"
#include "terrain_node_config.h"

namespace ladar_perception::test {
namespace {

/// What must become of the points of a bag.
struct PointCounts {
  uint64_t all = 0;
  uint64_t not_finite = 0;
  uint64_t too_near = 0;
  uint64_t too_far = 0;
  uint64_t inside = 0;     ///< of the map around the vehicle
  uint64_t on_border = 0;  ///< of the map, as far as rounding can tell
};

/// Bounds of the map around a vehicle, along each axis: whole voxels of the map frame.
struct MapBox {
  Eigen::Vector3d lower;
  Eigen::Vector3d upper;
};

MapBox mapBoxAround(const Eigen::Vector3d& p_map_vehicle, const TerrainConfig& config) {
  const std::array<double, 3> size_m = {config.map_size_x_m, config.map_size_y_m,
                                        config.map_size_z_m};
  const Eigen::Vector3d center =
      p_map_vehicle + Eigen::Vector3d(0.0, 0.0, config.map_center_height_m);
  MapBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double voxels = std::round(size_m[axis] / config.voxel_size_m);
    const double first = std::floor(center[axis] / config.voxel_size_m) - std::floor(voxels / 2);
    box.lower[axis] = first * config.voxel_size_m;
    box.upper[axis] = (first + voxels) * config.voxel_size_m;
  }
  return box;
}

void countPoint(const Eigen::Vector3d& p_sensor, const Eigen::Isometry3d& T_map_sensor,
                const MapBox& box, const TerrainConfig& config, PointCounts* counts) {
  constexpr double kRounding_m = 1e-9;
  ++counts->all;
  if (!p_sensor.allFinite()) {
    ++counts->not_finite;
  } else if (p_sensor.norm() < config.min_range_m) {
    ++counts->too_near;
  } else if (p_sensor.norm() > config.max_range_m) {
    ++counts->too_far;
  } else {
    const Eigen::Vector3d p_map = T_map_sensor * p_sensor;
    // Metres to the nearest face, positive inside.
    const double depth = std::min((p_map - box.lower).minCoeff(), (box.upper - p_map).minCoeff());
    if (depth > kRounding_m) {
      ++counts->inside;
    } else if (depth > -kRounding_m) {
      ++counts->on_border;
    }
  }
}

/// From the clouds and the transforms as they are in the bag, by plain arithmetic.
PointCounts recount(const std::string& path) {
  const TerrainConfig config;
  const Poses track = readTransforms(path, "/tf");
  const Eigen::Isometry3d T_vehicle_sensor =
      readTransforms(path, "/tf_static").at({"base_link", "ladar"}).begin()->second;
  PointCounts counts;
  for (const RecordedCloud& scan : readClouds(path, "/points")) {
    const Eigen::Isometry3d& T_map_vehicle =
        track.at({"odom", "base_link"}).at(scan.cloud.header.stamp);
    const Eigen::Isometry3d T_map_sensor = T_map_vehicle * T_vehicle_sensor;
    const MapBox box = mapBoxAround(T_map_vehicle.translation(), config);
    for (const Eigen::Vector3d& p_sensor : positionsOf(scan.cloud)) {
      countPoint(p_sensor, T_map_sensor, box, config, &counts);
    }
  }
  return counts;
}

struct RealSet {
  const char* name;
  const char* path;
  std::vector<std::string> options;
  std::size_t scans;  ///< 0: as many as the stream has
  std::size_t points;
  double least_inside;  ///< share of the points that lies in the map
};

void PrintTo(const RealSet& set, std::ostream* stream) { *stream << set.path; }

// Sensor heights off the multiples of a voxel, where rounding would decide on the map's place.
const std::vector<RealSet> kSets = {
    {"kitti00", "kitti00", {"--format", "kitti", "--sensor-height", "1.73"}, 6, 745000, 0.4},
    {"oakland_part2_ac",
     "oakland/tiles/oakland_part2_ac.xyz_label_conf",
     {"--format", "oakland"},
     0,
     99900,
     0.3},
    {"oakland_part2_ah",
     "oakland/tiles/oakland_part2_ah.xyz_label_conf",
     {"--format", "oakland"},
     0,
     99900,
     0.3},
    {"oakland_part3_am",
     "oakland/tiles/oakland_part3_am.xyz_label_conf",
     {"--format", "oakland"},
     0,
     99900,
     0.3},
    {"oakland_part3_an",
     "oakland/tiles/oakland_part3_an.xyz_label_conf",
     {"--format", "oakland"},
     0,
     99900,
     0.3},
    {"hdl_pair", "hdl_pair", {"--format", "pcd", "--sensor-height", "1.76"}, 2, 138000, 0.2},
    {"pjlab", "pjlab", {"--format", "pcd", "--sensor-height", "2.16"}, 1, 80787, 0.1},
    {"norlab_car", "norlab_car", {"--format", "vtk", "--sensor-height", "0.76"}, 3, 74000, 0.2},
    {"3dtk_indoor", "3dtk_indoor", {"--format", "3dtk", "--sensor-height", "0.76"}, 3, 240000, 0.1},
};

class RealData : public ::testing::TestWithParam<RealSet> {};

TEST_P(RealData, NothingIsLost) {
  const RealSet& set = GetParam();
  const std::string input = realData(set.path);
  if (input.empty()) GTEST_SKIP() << set.path << " is not there: set LADAR_DATA to its folder";
  const ScratchFolder folder;
  const std::string bag = folder.file("in.bag");
  std::vector<std::string> arguments = set.options;
  if (std::string(set.name) == "kitti00") {
    const std::string poses = realData("kitti00/icp_reference_T_lidar0_lidari.txt");
    arguments.insert(arguments.end(), {"--poses", poses});
  }
  arguments.insert(arguments.end(), {input, "--out", bag});
  expectSuccess(runProgram("import_scans", arguments));
  const std::string out = folder.file("out.bag");
  const std::string json = folder.file("m.json");
  expectSuccess(runProgram("classify_bag", {bag, "--out", out, "--metrics", json}));

  const nlohmann::json m = readJson(json);
  const PointCounts expected = recount(bag);
  const auto scans = readClouds(bag, "/points");
  EXPECT_GE(expected.all, set.points);
  EXPECT_EQ(scans.size(), set.scans > 0 ? set.scans : scans.size());
  EXPECT_GE(scans.size(), 1u);
  EXPECT_EQ(m["scans"], scans.size());
  for (const auto& [reason, count] : m["scans_dropped"].items()) EXPECT_EQ(count, 0) << reason;
  EXPECT_EQ(m["points_in"], expected.all);
  EXPECT_EQ(m["dropped"]["not_finite"], expected.not_finite);
  EXPECT_EQ(m["dropped"]["too_near"], expected.too_near);
  EXPECT_EQ(m["dropped"]["too_far"], expected.too_far);
  const auto taken =
      m["points_inserted"].get<uint64_t>() + m["dropped"]["saturated"].get<uint64_t>();
  EXPECT_GE(taken, expected.inside);
  EXPECT_LE(taken, expected.inside + expected.on_border);
  EXPECT_LE(expected.on_border, 20u);
  const double inside_share =
      static_cast<double>(expected.inside) / static_cast<double>(expected.all);
  EXPECT_GE(inside_share, set.least_inside);

  const auto labeled = readClouds(out, "/labeled_points");
  ASSERT_EQ(labeled.size(), scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(labeled[i].cloud.width, scans[i].cloud.width);
    EXPECT_EQ(labeled[i].cloud.height, scans[i].cloud.height);
  }
  std::cout << set.name << ": " << scans.size() << " scans, " << expected.all << " points, "
            << static_cast<int>(100 * inside_share) << " % in the map, latency p50 "
            << m["latency_ms"]["p50"] << " ms, labels " << m["label_counts"];
  if (m.contains("recall")) std::cout << ", recall " << m["recall"];
  std::cout << "\n";
}

INSTANTIATE_TEST_SUITE_P(Sets, RealData, ::testing::ValuesIn(kSets),
                         [](const auto& set) { return std::string("_") + set.param.name; });

}  // namespace
}  // namespace ladar_perception::test
