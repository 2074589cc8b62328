// SPDX-License-Identifier: BSD-3-Clause
// The scenes and the vehicle's way through them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "ladar_perception/sim/ladar.h"
#include "ladar_perception/sim/scan_cloud.h"
#include "ladar_perception/sim/sensors.h"
#include "ladar_perception/sim/world.h"

namespace ladar_perception::sim {
namespace {

class SimWorld : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Scenes, SimWorld, testing::ValuesIn(sceneNames()),
                         [](const auto& scene) { return scene.param; });

std::vector<uint8_t> scanBytes(const World& world, uint64_t scan, uint64_t seed) {
  const VehiclePath path(world.circuit, world.scene.ground(), 4.0);
  const LadarConfig config;
  return encodeScan(Ladar(config, world.scene, path, seed).takeScan(scan), config);
}

/// First thing that is not ground within the vehicle's clear space, looking from its middle.
bool isClear(const World& world, double s_m) {
  const Eigen::Vector2d p = world.circuit.position(s_m);
  for (int turn = 0; turn < 24; ++turn) {
    const double a = 0.2617993877991494 * turn;
    for (double z = 0.3; z < kClearHeightM; z += 0.45) {
      const Eigen::Vector3d origin(p.x(), p.y(), world.scene.ground().height(p.x(), p.y()) + z);
      const Ray ray{origin, {std::cos(a), std::sin(a), 0.0}};
      const Hit hit = world.scene.castRay(ray, kClearHalfWidthM, false);
      const bool grass = hit.material == Material::kGrass || hit.material == Material::kDryGrass;
      if (hit.valid() && !grass) return false;
    }
  }
  return true;
}

/// Worlds are built once for all tests.
const World& worldOf(const std::string& scene_name, uint64_t seed) {
  static std::map<std::pair<std::string, uint64_t>, World> worlds;
  const auto key = std::make_pair(scene_name, seed);
  const auto known = worlds.find(key);
  if (known != worlds.end()) return known->second;
  return worlds.emplace(key, makeWorld(scene_name, seed)).first->second;
}

TEST_P(SimWorld, HoldsAllClassesAndPlausibleShares) {
  const World& world = worldOf(GetParam(), 1);
  const VehiclePath path(world.circuit, world.scene.ground(), 4.0);
  const Ladar ladar(LadarConfig(), world.scene, path, 1);
  ScanSummary sum;
  for (uint64_t k = 0; k < 8; ++k) sum.add(ladar.takeScan(k * 75));
  const auto share = [&](uint64_t part) {
    return static_cast<double>(part) / static_cast<double>(sum.returned);
  };
  const double returned = static_cast<double>(sum.returned) / static_cast<double>(sum.beams);
  EXPECT_GT(returned, 0.5);
  EXPECT_LT(returned, 0.97);
  EXPECT_GT(share(sum.surface), 0.2);
  EXPECT_GT(share(sum.scatter), 0.02);
  EXPECT_GT(share(sum.linear), 0.004);
  EXPECT_GT(share(sum.mixed), 0.002);
  EXPECT_LT(share(sum.mixed), 0.15);
}

TEST_P(SimWorld, TheTrackIsClear) {
  for (const uint64_t seed : {1, 2}) {
    const World& world = worldOf(GetParam(), seed);
    for (double s = 0.0; s < world.circuit.length(); s += 1.0) {
      ASSERT_TRUE(isClear(world, s)) << "seed " << seed << " at " << s << " m";
    }
  }
}

TEST_P(SimWorld, SameSeedSameWorld) {
  const World& a = worldOf(GetParam(), 1);
  const World b = makeWorld(GetParam(), 1);
  const World& other = worldOf(GetParam(), 2);
  const auto bytes = scanBytes(a, 40, 1);
  EXPECT_EQ(bytes, scanBytes(b, 40, 1));
  EXPECT_NE(bytes, scanBytes(other, 40, 1));
  EXPECT_NE(bytes, scanBytes(a, 40, 2));
}

/// Points of a drive once round the track with a sensor that looks all round and up.
struct Survey {
  struct Point {
    Label label;
    double above_m;  ///< the ground below
    double track_m;  ///< from the middle of the track
  };
  std::vector<Point> points;

  std::size_t count(Label label) const {
    return static_cast<std::size_t>(std::count_if(
        points.begin(), points.end(), [&](const Point& point) { return point.label == label; }));
  }
  /// Height that a share of a label's points stay below.
  double height(Label label, double share) const {
    std::vector<double> heights;
    for (const Point& point : points) {
      if (point.label == label) heights.push_back(point.above_m);
    }
    std::sort(heights.begin(), heights.end());
    return heights.empty() ? std::nan("") : heights[share * (heights.size() - 1)];
  }
};

Survey takeSurvey(const std::string& scene_name) {
  const World& world = worldOf(scene_name, 1);
  LadarConfig config = sensorConfig("os64");
  config.columns = 512;
  config.height_deg = 80.0;
  const VehiclePath path(world.circuit, world.scene.ground(), 5.0);
  const Ladar ladar(config, world.scene, path, 1);
  Survey survey;
  for (uint64_t k = 0; k < 700; k += 35) {
    for (const Return& r : ladar.takeScan(k)) {
      const double time_s = ladar.startTime(k) + double{r.time_s};
      if (!r.valid()) continue;
      const Eigen::Vector3d p =
          path.T_odom_base(time_s) * ladar.T_base_ladar(time_s) * r.p_ladar.cast<double>();
      survey.points.push_back({r.label, p.z() - world.scene.ground().height(p.x(), p.y()),
                               world.circuit.distanceTo(p.x(), p.y())});
    }
  }
  return survey;
}

/// Surveys are taken once for all tests.
const Survey& surveyOf(const std::string& scene_name) {
  static std::map<std::string, Survey> surveys;
  const auto known = surveys.find(scene_name);
  if (known != surveys.end()) return known->second;
  return surveys.emplace(scene_name, takeSurvey(scene_name)).first->second;
}

struct Promise {
  const char* scene;
  std::vector<Label> labels;
};

class SimScenePromise : public testing::TestWithParam<Promise> {};
INSTANTIATE_TEST_SUITE_P(
    Scenes, SimScenePromise,
    testing::Values(
        Promise{"flat_ground",
                {Label::kGround, Label::kRock, Label::kTrunk, Label::kTwig, Label::kPole,
                 Label::kWire, Label::kFence, Label::kFoliage, Label::kShrub, Label::kGrass}},
        Promise{"forest",
                {Label::kGround, Label::kRock, Label::kTrunk, Label::kBranch, Label::kTwig,
                 Label::kLog, Label::kFoliage, Label::kShrub, Label::kGrass}},
        Promise{"tall_grass",
                {Label::kGround, Label::kRock, Label::kTrunk, Label::kTwig, Label::kPole,
                 Label::kFoliage, Label::kShrub, Label::kGrass}},
        Promise{"campus",
                {Label::kGround, Label::kPavement, Label::kStep, Label::kFacade, Label::kVehicle,
                 Label::kObject, Label::kTrunk, Label::kTwig, Label::kPole, Label::kWire,
                 Label::kFence, Label::kTube, Label::kFoliage, Label::kShrub, Label::kGrass}},
        Promise{"street",
                {Label::kGround, Label::kPavement, Label::kStep, Label::kFacade, Label::kWall,
                 Label::kVehicle, Label::kObject, Label::kTrunk, Label::kBranch, Label::kTwig,
                 Label::kPole, Label::kWire, Label::kFence, Label::kTube, Label::kFoliage,
                 Label::kShrub, Label::kGrass}},
        Promise{
            "scrubland",
            {Label::kGround, Label::kRock, Label::kTrunk, Label::kTwig, Label::kPole, Label::kWire,
             Label::kFence, Label::kLog, Label::kFoliage, Label::kShrub, Label::kGrass}}),
    [](const auto& promise) { return std::string(promise.param.scene); });

TEST_P(SimScenePromise, HoldsWhatItPromises) {
  const Survey& survey = surveyOf(GetParam().scene);
  for (const Label label : GetParam().labels) {
    EXPECT_GT(survey.count(label), 30U) << "label " << static_cast<int>(label);
  }
}

TEST(SimStreet, IsAsTallAsATown) {
  const Survey& survey = surveyOf("street");
  EXPECT_GT(survey.height(Label::kFoliage, 0.9), 6.0);
  EXPECT_GT(survey.height(Label::kFoliage, 1.0), 9.0);
  EXPECT_GT(survey.height(Label::kFoliage, 0.02), 1.0) << "lower trunks are bare";
  EXPECT_GT(survey.height(Label::kWire, 0.05), 3.5);
  EXPECT_GT(survey.height(Label::kWire, 0.9), 5.5);
  EXPECT_LT(survey.height(Label::kWire, 1.0), 15.0);
  EXPECT_GT(survey.height(Label::kFacade, 1.0), 9.0);
  EXPECT_GT(survey.height(Label::kVehicle, 1.0), 1.4);
  EXPECT_LT(survey.height(Label::kVehicle, 1.0), 2.6);
  EXPECT_LT(survey.height(Label::kShrub, 0.9), 2.2);
  EXPECT_LT(survey.height(Label::kGrass, 1.0), 0.5);
  // Banks, terraces and walls beside the street: what is a garden in one place is 1 m up in
  // another.
  const World& world = worldOf("street", 1);
  double steepest = 0.0;
  for (double s = 0.0; s < world.circuit.length(); s += 1.0) {
    for (double left = -15.0; left <= 15.0; left += 0.5) {
      const Eigen::Vector2d p = world.circuit.beside(s, left);
      steepest = std::max(steepest, std::acos(world.scene.ground().normal(p.x(), p.y()).z()));
    }
  }
  EXPECT_GT(steepest, 0.35);
}

/// Steepest pitch and roll of the vehicle, and of the ground within 12 m of the track, in degrees.
std::array<double, 3> slopesOf(const World& world) {
  constexpr double kDegPerRad = 57.29577951308232;
  const VehiclePath path(world.circuit, world.scene.ground(), 1.0);
  std::array<double, 3> steepest{};
  for (double s = 0.0; s < world.circuit.length(); s += 0.5) {
    const Eigen::Matrix3d turn = path.T_odom_base(s).linear();
    steepest[0] = std::max(steepest[0], kDegPerRad * std::abs(std::asin(turn(2, 0))));
    steepest[1] = std::max(steepest[1], kDegPerRad * std::abs(std::asin(turn(2, 1))));
    for (double left = -12.0; left <= 12.0; left += 1.5) {
      const Eigen::Vector2d p = world.circuit.beside(s, left);
      const double up = world.scene.ground().normal(p.x(), p.y()).z();
      steepest[2] = std::max(steepest[2], kDegPerRad * std::acos(up));
    }
  }
  return steepest;
}

TEST(SimScrubland, IsLowAndSteep) {
  const Survey& survey = surveyOf("scrubland");
  EXPECT_LT(survey.height(Label::kShrub, 0.5), 0.8);
  EXPECT_LT(survey.height(Label::kShrub, 0.98), 2.2);
  EXPECT_LT(survey.height(Label::kGrass, 0.98), 0.9);
  EXPECT_GT(survey.height(Label::kGrass, 0.98), 0.3);
  for (const uint64_t seed : {1, 2, 3}) {
    const auto [pitch, roll, beside] = slopesOf(worldOf("scrubland", seed));
    EXPECT_GT(std::max(pitch, roll), 18.0) << "seed " << seed;
    EXPECT_LT(std::max(pitch, roll), 33.0) << "seed " << seed;
    EXPECT_GT(beside, 30.0) << "seed " << seed;
  }
}

TEST(SimWorldNames, UnknownSceneIsNamedWithTheKnownOnes) {
  try {
    makeWorld("moon", 1);
    FAIL() << "no exception";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'moon'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("tall_grass"), std::string::npos);
  }
}

TEST(SimCircuit, GoesRoundWithoutEndAtUnitSpeed) {
  const Circuit circuit({50.0, 36.0, 3.0, 0.05, 0.05, 1.0, 2.0});
  const double length = circuit.length();
  EXPECT_GT(length, 200.0);
  EXPECT_TRUE(circuit.position(3.0).isApprox(circuit.position(3.0 + 250.0 * length), 1e-6));
  for (double s = -10.0; s < length; s += 0.37) {
    const Eigen::Vector2d step = circuit.position(s + 0.01) - circuit.position(s);
    EXPECT_NEAR(step.norm(), 0.01, 1e-5);
    EXPECT_NEAR(std::remainder(std::atan2(step.y(), step.x()) - circuit.heading(s), 6.2831853), 0.0,
                5e-3);
    EXPECT_LT(circuit.distanceTo(circuit.position(s).x(), circuit.position(s).y()), 0.6);
    const Eigen::Vector2d aside = circuit.beside(s, 3.0);
    EXPECT_NEAR(circuit.distanceTo(aside.x(), aside.y()), 3.0, 0.15);
    for (const double left : {-9.0, -2.0, 4.0, 14.0}) {
      const Eigen::Vector2d p = circuit.beside(s, left);
      const TrackPlace place = circuit.placeOf(p.x(), p.y());
      EXPECT_NEAR(place.left_m, left, 0.1);
      EXPECT_NEAR(std::remainder(place.s_m - s, length), 0.0, 0.1 + 0.02 * std::abs(left));
    }
  }
}

TEST(SimVehiclePath, FollowsASlopeWithPitchAndRoll) {
  const Circuit circuit({40.0, 40.0});
  // Rises towards +y: at arc length 0 the vehicle stands at (40, 0) and heads for +y.
  const HeightField slope(
      95.0, [](double, double y) { return 0.2 * y; },
      [](double, double) { return Material::kSoil; });
  const VehiclePath path(circuit, slope, 5.0);
  const Eigen::Isometry3d start = path.T_odom_base(0.0);
  EXPECT_NEAR(start.translation().z(), 0.0, 0.02);
  EXPECT_NEAR(std::asin(start.linear()(2, 0)), std::atan(0.2), 0.01) << "x axis points uphill";
  // A quarter further it heads for -x, with the slope on its right.
  const Eigen::Isometry3d quarter = path.T_odom_base(0.25 * circuit.length() / 5.0);
  EXPECT_NEAR(quarter.linear()(0, 0), -1.0, 0.05);
  EXPECT_NEAR(std::asin(quarter.linear()(2, 1)), -std::atan(0.2), 0.01) << "left side is lower";
}

}  // namespace
}  // namespace ladar_perception::sim
