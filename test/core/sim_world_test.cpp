// SPDX-License-Identifier: BSD-3-Clause
// The scenes and the vehicle's way through them.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "ladar_perception/sim/ladar.h"
#include "ladar_perception/sim/scan_cloud.h"
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
