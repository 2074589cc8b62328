// SPDX-License-Identifier: BSD-3-Clause
// The sensors by name: where their beams go, when, and what they say was hit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "ladar_perception/io/class_mapping.h"
#include "ladar_perception/sim/scan_cloud.h"
#include "ladar_perception/sim/sensors.h"
#include "ladar_perception/sim/world.h"

namespace ladar_perception::sim {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

double azimuthDeg(const Eigen::Vector3d& beam) {
  return std::atan2(beam.y(), beam.x()) / kRadPerDeg;
}
double elevationDeg(const Eigen::Vector3d& beam) { return std::asin(beam.z()) / kRadPerDeg; }

const World& campus() {
  static const World world = makeWorld("campus", 1);
  return world;
}

/// A ladar of that name that stands still on the campus.
Ladar standing(const LadarConfig& config) {
  static const VehiclePath path(campus().circuit, campus().scene.ground(), 0.0);
  return Ladar(config, campus().scene, path, 1);
}

class SimSensor : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Sensors, SimSensor, testing::ValuesIn(sensorNames()),
                         [](const auto& sensor) { return sensor.param; });

TEST_P(SimSensor, IsValidAndSeesThingsOfEveryClass) {
  const LadarConfig config = sensorConfig(GetParam());
  EXPECT_TRUE(config.validate().empty()) << config.validate().front();
  const VehiclePath path(campus().circuit, campus().scene.ground(), 15.0);
  const Ladar ladar(config, campus().scene, path, 1);
  ScanSummary sum;
  for (uint64_t k = 0; k < 60; k += GetParam() == "pushbroom" ? 1 : 20) sum.add(ladar.takeScan(k));
  EXPECT_GT(sum.surface, 100U);
  EXPECT_GT(sum.scatter, 100U);
  EXPECT_GT(sum.linear, 100U);
}

TEST_P(SimSensor, ReturnsAreOnTheirBeamsAndLabelsAgreeWithTruth) {
  const LadarConfig config = sensorConfig(GetParam());
  const Ladar ladar = standing(config);
  const ClassMapping three =
      loadClassMapping(LADAR_SOURCE_DIR "/config/classes/simulated_three.yaml");
  const Scan scan = ladar.takeScan(0);
  ASSERT_EQ(scan.size(), static_cast<std::size_t>(config.rows) * config.columns);
  int returned = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Return& r = scan[i];
    const auto row = static_cast<int>(i / config.columns);
    const auto column = static_cast<int>(i % config.columns);
    ASSERT_EQ(r.time_s, static_cast<float>(ladar.beamTime(row, column)));
    ASSERT_LT(r.time_s, config.scanPeriod());
    if (!r.valid()) {
      ASSERT_EQ(r.label, Label::kNone);
      continue;
    }
    ++returned;
    const Eigen::Vector3d p = r.p_ladar.cast<double>();
    ASSERT_LT(p.cross(ladar.beam(row, column)).norm(), 1e-4);
    if (config.range_step_m > 0.0) {
      const double steps = p.norm() / config.range_step_m;
      ASSERT_NEAR(steps, std::round(steps), 0.02);
    }
    ASSERT_EQ(static_cast<int>(r.truth), three.truth(static_cast<uint32_t>(r.label)))
        << "label " << static_cast<int>(r.label);
  }
  EXPECT_GT(returned, static_cast<int>(scan.size() / 5));
}

TEST(SimSensors, Vlp16HasSixteenRingsTwoDegreesApart) {
  const Ladar ladar = standing(sensorConfig("vlp16"));
  ASSERT_EQ(ladar.config().rows, 16);
  for (int row = 0; row < 16; ++row) {
    EXPECT_NEAR(elevationDeg(ladar.beam(row, 77)), 15.0 - 2.0 * row, 1e-9);
  }
  // Clockwise all round in steps of 0.2 degrees.
  EXPECT_NEAR(azimuthDeg(ladar.beam(3, 0)), 179.9, 1e-9);
  EXPECT_NEAR(azimuthDeg(ladar.beam(3, 1)), 179.7, 1e-9);
  EXPECT_NEAR(azimuthDeg(ladar.beam(3, 1799)), -179.9, 1e-9);
  EXPECT_EQ(ladar.beamTime(0, 900), 0.05);
  EXPECT_EQ(ladar.beamTime(15, 900), 0.05) << "a column is measured at once";
}

TEST(SimSensors, SixtyFourRingsLieAsTheSensorsHaveThem) {
  const Ladar hdl64 = standing(sensorConfig("hdl64"));
  ASSERT_EQ(hdl64.config().rows, 64);
  EXPECT_NEAR(elevationDeg(hdl64.beam(0, 0)), 2.0, 1e-9);
  EXPECT_NEAR(elevationDeg(hdl64.beam(0, 0)) - elevationDeg(hdl64.beam(1, 0)), 1.0 / 3.0, 1e-9);
  EXPECT_NEAR(elevationDeg(hdl64.beam(62, 0)) - elevationDeg(hdl64.beam(63, 0)), 0.5, 1e-9);
  EXPECT_NEAR(elevationDeg(hdl64.beam(63, 0)), -24.33, 1e-9);
  const Ladar os64 = standing(sensorConfig("os64"));
  EXPECT_NEAR(elevationDeg(os64.beam(0, 5)), 22.5 * 63 / 64, 1e-9);
  EXPECT_NEAR(elevationDeg(os64.beam(63, 5)), -22.5 * 63 / 64, 1e-9);
}

TEST(SimSensors, PushbroomSweepsAPlaneAcrossTheTrack) {
  const Ladar ladar = standing(sensorConfig("pushbroom"));
  const LadarConfig& config = ladar.config();
  EXPECT_NEAR(config.rate_hz * config.columns, 37.5, 1e-9);
  for (int column = 0; column < config.columns; ++column) {
    for (int row = 0; row < config.rows; ++row) {
      const Eigen::Vector3d beam = ladar.beam(row, column);
      ASSERT_NEAR(beam.x(), 0.0, 1e-12) << "across the direction of travel";
      ASSERT_LT(beam.y(), 0.0) << "to the right";
    }
  }
  EXPECT_NEAR(elevationDeg(ladar.beam(0, 0)), 89.75, 0.01);
  EXPECT_NEAR(elevationDeg(ladar.beam(180, 0)), 0.0, 1e-9);
  EXPECT_NEAR(elevationDeg(ladar.beam(100, 0)) - elevationDeg(ladar.beam(101, 0)), 0.5, 2e-3);
  EXPECT_NEAR(elevationDeg(ladar.beam(360, 0)), -89.75, 0.01);
  EXPECT_NEAR(ladar.beamTime(0, 1) - ladar.beamTime(0, 0), 1.0 / 37.5, 1e-12);
  EXPECT_GT(ladar.beamTime(360, 0), 0.006);
  EXPECT_LT(ladar.beamTime(360, 4), config.scanPeriod());
}

TEST(SimSensors, TwoHeadsTakeColumnsInTurn) {
  LadarConfig config = sensorConfig("pushbroom");
  config.heads_deg = {90.0, -90.0};
  config.columns = 10;
  ASSERT_TRUE(config.validate().empty());
  const Ladar ladar = standing(config);
  for (int column = 0; column < 10; ++column) {
    EXPECT_NEAR(azimuthDeg(ladar.beam(100, column)), column % 2 == 0 ? 90.0 : -90.0, 1e-9);
  }
}

TEST(SimSensors, UnknownNameIsNamedWithTheKnownOnes) {
  try {
    sensorConfig("sonar");
    FAIL() << "no exception";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'sonar'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("vlp16"), std::string::npos);
  }
}

TEST(SimLabels, MappingsCoverEveryMaterialAndAgreeWithTruth) {
  const std::string folder = LADAR_SOURCE_DIR "/config/classes/";
  const ClassMapping three = loadClassMapping(folder + "simulated_three.yaml");
  const ClassMapping five = loadClassMapping(folder + "simulated_five.yaml");
  EXPECT_EQ(three.names, loadClassMapping(folder + "oakland_three.yaml").names);
  EXPECT_EQ(five.names, loadClassMapping(folder + "oakland_five.yaml").names);
  std::set<uint32_t> labels;
  for (int i = 0; i < static_cast<int>(Material::kCount); ++i) {
    const MaterialProperties& properties = propertiesOf(static_cast<Material>(i));
    const auto label = static_cast<uint32_t>(properties.label);
    labels.insert(label);
    EXPECT_NE(properties.label, Label::kNone) << "material " << i;
    EXPECT_EQ(three.truth(label), static_cast<uint8_t>(properties.truth)) << "material " << i;
    // No class of the five may gather what the three keep apart.
    const std::string in_five = five.truth(label) == 0 ? "" : five.names[five.truth(label) - 1];
    const auto belongs = [&](Truth truth, std::initializer_list<const char*> names) {
      for (const char* name : names) EXPECT_TRUE(in_five != name || properties.truth == truth);
    };
    belongs(Truth::kLinear, {"wire", "pole_trunk"});
    belongs(Truth::kSurface, {"ground", "facade"});
    belongs(Truth::kScatter, {"vegetation"});
  }
  EXPECT_EQ(labels.size(), three.truth_of_label.size()) << "labels nothing is made of";
}

}  // namespace
}  // namespace ladar_perception::sim
