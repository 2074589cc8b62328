// SPDX-License-Identifier: BSD-3-Clause
// What the terrain nodelet and the stand-alone node must both do; launched as terrain.launch does.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "ros_terrain_client.h"

namespace ladar_perception::test {

constexpr int kCaseScans = 5;

/// A node that stays for all cases of the program.
class TerrainCases : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new TerrainClient("/terrain");
    diagnostics_ = new DiagnosticsListener("terrain");
    ASSERT_TRUE(client_->connected());
    client_->sendMount();
  }
  static void TearDownTestSuite() {
    delete diagnostics_;
    delete client_;
  }

  static TerrainClient* client_;
  static DiagnosticsListener* diagnostics_;
};

TerrainClient* TerrainCases::client_ = nullptr;
DiagnosticsListener* TerrainCases::diagnostics_ = nullptr;

inline void expectInputKept(const sensor_msgs::PointCloud2& scan,
                            const sensor_msgs::PointCloud2& labeled) {
  EXPECT_EQ(scan.header.stamp, labeled.header.stamp);
  EXPECT_EQ(scan.header.frame_id, labeled.header.frame_id);
  ASSERT_EQ(scan.width, labeled.width);
  ASSERT_EQ(scan.height, labeled.height);
  EXPECT_TRUE(labeled.is_dense);
  EXPECT_EQ(labeled.data.size(), std::size_t{labeled.row_step} * labeled.height);
  for (const auto& field : scan.fields) {
    SCOPED_TRACE(field.name);
    const auto same = std::find_if(labeled.fields.begin(), labeled.fields.end(),
                                   [&](const auto& other) { return other.name == field.name; });
    ASSERT_NE(same, labeled.fields.end());
    EXPECT_EQ(same->datatype, field.datatype);
    EXPECT_EQ(same->count, field.count);
    EXPECT_EQ(fieldValues(scan, field.name), fieldValues(labeled, field.name));
  }
}

/// Type of a field, 0 if there is none.
inline int datatypeOf(const sensor_msgs::PointCloud2& cloud, const std::string& name) {
  for (const auto& field : cloud.fields) {
    if (field.name == name) return field.datatype;
  }
  return 0;
}

/// rgb follows the class, and confidence is a probability, 0 for unknown.
inline void expectColorsAndConfidence(const sensor_msgs::PointCloud2& labeled) {
  ASSERT_EQ(datatypeOf(labeled, "label"), sensor_msgs::PointField::UINT8);
  ASSERT_EQ(datatypeOf(labeled, "confidence"), sensor_msgs::PointField::FLOAT32);
  ASSERT_EQ(datatypeOf(labeled, "rgb"), sensor_msgs::PointField::FLOAT32);
  const CloudLayout layout = layoutOf(labeled);
  std::vector<uint32_t> rgb;
  readColors({layout, labeled.data.data(), labeled.data.size()}, *layout.find("rgb"), &rgb);
  const std::vector<double> label = fieldValues(labeled, "label");
  const std::vector<double> confidence = fieldValues(labeled, "confidence");
  constexpr uint32_t kColors[] = {0x808080, 0xff0000, 0x00ff00, 0x0000ff};
  int wrong = 0;
  for (std::size_t i = 0; i < label.size(); ++i) {
    const bool known = label[i] >= 1 && label[i] <= 3;
    const bool likely = known ? confidence[i] > 0.33 && confidence[i] <= 1.0 : confidence[i] == 0.0;
    wrong += !likely || label[i] > 3 || rgb[i] != kColors[static_cast<int>(label[i])] ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0);
}

TEST_F(TerrainCases, EveryScanComesBackLabelled) {
  const Drive drive;
  client_->send(drive.vehicleTransforms(0, kCaseScans));
  for (int i = 0; i < kCaseScans; ++i) {
    const sensor_msgs::PointCloud2 scan = drive.scan(i);
    const auto labeled = client_->label(scan);
    ASSERT_TRUE(labeled) << "scan " << i;
    expectInputKept(scan, *labeled);
    expectColorsAndConfidence(*labeled);
    EXPECT_GT(recallOf(*labeled, kSurfaceLabel), 0.95);
    EXPECT_GT(recallOf(*labeled, kScatterLabel), 0.85);
    EXPECT_GT(recallOf(*labeled, kLinearLabel), 0.95);
  }
}

TEST_F(TerrainCases, TheMapIsPublishedInItsFrame) {
  // The first scan's, and one 0.2 s of stamps later.
  ASSERT_TRUE(waitFor([&] { return client_->maps.size() >= 2; }));
  const sensor_msgs::PointCloud2& map = *client_->maps.back();
  EXPECT_EQ(map.header.frame_id, kMapFrame);
  const std::size_t points = std::size_t{map.width} * map.height;
  EXPECT_GT(points, 3000U);
  for (const char* name : {"x", "y", "z"}) {
    const std::vector<double> values = fieldValues(map, name);
    ASSERT_EQ(values.size(), points) << name;
    EXPECT_TRUE(std::all_of(values.begin(), values.end(),
                            [](double value) { return std::abs(value) < 10.0; })) << name;
  }
  for (const char* name : {"scatter", "surface", "linear", "normal_x", "normal_y", "normal_z",
                           "confidence", "rgb", "label", "points"}) {
    EXPECT_EQ(fieldValues(map, name).size(), points) << name;
  }
  // The floor's voxels lie on the floor, face upwards and are surface.
  const std::vector<double> x = fieldValues(map, "x"), y = fieldValues(map, "y"),
                            z = fieldValues(map, "z"), normal_z = fieldValues(map, "normal_z"),
                            label = fieldValues(map, "label"), count = fieldValues(map, "points");
  int floor = 0;
  int right = 0;
  for (std::size_t i = 0; i < points; ++i) {
    EXPECT_GE(count[i], 1.0);
    if (std::abs(x[i]) > 7.0 || std::abs(y[i]) > 2.5) continue;
    ++floor;
    right += std::abs(z[i] - 0.02) < 0.05 && std::abs(normal_z[i]) > 0.95 && label[i] == 1 ? 1 : 0;
  }
  EXPECT_GT(floor, 2000);
  EXPECT_GT(right, 0.95 * floor);
}

TEST_F(TerrainCases, StatisticsAddUp) {
  const Drive drive;
  const uint64_t points = drive.cloud(0).layout.pointCount();
  ASSERT_TRUE(client_->waitForStatistics([](const auto& s) { return s.scans >= kCaseScans; }));
  const TerrainStatistics& s = client_->statistics;
  EXPECT_EQ(s.scans, static_cast<uint64_t>(kCaseScans));
  EXPECT_EQ(s.points_in, kCaseScans * points);
  EXPECT_EQ(s.points_in, s.points_inserted + sumOf(s.points_dropped));
  EXPECT_EQ(s.points_inserted, s.points_in) << "all are finite, in range and inside the map";
  EXPECT_EQ(sumOf(s.scans_dropped), 0U);
  EXPECT_EQ(s.resets, 0U);
  EXPECT_EQ(s.header.stamp, drive.scanStamp(kCaseScans - 1));
  EXPECT_EQ(s.model, kTestModel);
  uint64_t labels = 0;
  for (const ClassCount& count : s.labels) labels += count.count;
  EXPECT_EQ(labels, s.points_in);
  ASSERT_EQ(s.labels.size(), 4U);
  EXPECT_EQ(s.labels[0].name, "unknown");
  EXPECT_EQ(s.labels[3].name, "linear");
  EXPECT_NEAR(s.scan_rate_hz, 10.0, 0.1);
  EXPECT_GT(s.latency_p50_ms, 0.0);
  EXPECT_LE(s.latency_p50_ms, s.latency_p99_ms);
  EXPECT_LE(s.latency_p99_ms, s.latency_max_ms);
  EXPECT_EQ(s.stages.size(), 6U);
  EXPECT_GT(s.occupied_voxels, 3000U);
  EXPECT_GT(s.memory_bytes, s.occupied_voxels * 64U);
}

TEST_F(TerrainCases, DiagnosticsTellHowItGoes) {
  std::map<std::string, std::string>& values = diagnostics_->values;
  ASSERT_TRUE(waitFor([&] { return values["scans"] == std::to_string(kCaseScans); }))
      << "scans: " << values["scans"];
  for (const char* key :
       {"scan rate (Hz)", "points per second", "latency p50 (ms)", "latency p99 (ms)",
        "scans dropped: no_transform", "scans dropped: queue_full", "scans dropped: bad_cloud",
        "points dropped: not_finite", "occupied voxels", "memory (MB)", "map resets", "model"}) {
    EXPECT_EQ(values.count(key), 1U) << key;
  }
  EXPECT_EQ(values["model"], kTestModel);
}

TEST_F(TerrainCases, ResetEmptiesTheMap) {
  ASSERT_TRUE(client_->waitForStatistics([](const auto& s) { return s.occupied_voxels > 3000; }));
  ASSERT_TRUE(client_->reset());
  // Four points in a corner that was empty: all that the map may hold now. Lonely as they are,
  // they stay unknown, which they would not do beside what was there before.
  const Drive drive;
  const std::vector<Eigen::Vector3d> p_odom = {
      {-7, 2, 0.02}, {-6, 2, 0.02}, {-5, 2, 0.02}, {-4, 2, 0.02}};
  std::vector<Eigen::Vector3d> p_sensor;
  for (const Eigen::Vector3d& p : p_odom) {
    p_sensor.push_back((vehiclePose(kCaseScans * kScanPeriod_s) * sensorMount()).inverse() * p);
  }
  client_->send(drive.vehicleTransforms(kCaseScans, kCaseScans + 1));
  const auto labeled = client_->label(
      toMessage(scanCloud(p_sensor, {1, 1, 1, 1}, false), drive.scanStamp(kCaseScans),
                kSensorFrame));
  ASSERT_TRUE(labeled);
  EXPECT_EQ(fieldValues(*labeled, "label"), std::vector<double>(4, 0.0));
  ASSERT_TRUE(client_->waitForStatistics([](const auto& s) { return s.scans == kCaseScans + 1; }));
  EXPECT_EQ(client_->statistics.occupied_voxels, 4U);
  EXPECT_EQ(client_->statistics.resets, 1U);
}

}  // namespace ladar_perception::test
