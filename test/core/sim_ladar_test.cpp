// SPDX-License-Identifier: BSD-3-Clause
// The sensor model: geometry, time, noise, losses, bytes. Edges: sim_ladar_echo_test.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ladar_perception/sim/ladar.h"
#include "ladar_perception/sim/scan_cloud.h"
#include "ladar_perception/sim/world.h"

namespace ladar_perception::sim {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

/// Level ground and, if wanted, a wall of posts for depth edges.
World makePlain(bool with_posts) {
  Circuit circuit({40.0, 40.0});
  Scene scene(HeightField(
      95.0, [](double, double) { return 0.0; }, [](double, double) { return Material::kSoil; }));
  const uint32_t post =
      scene.addModel({makeCylinder({0, 0, -1}, {0, 0, 3}, 0.06, Material::kPost)});
  for (int i = 0; with_posts && i < 700; ++i) {
    const Eigen::Vector2d p = circuit.beside(0.8 * (i / 2), i % 2 == 0 ? 5.0 : -5.0);
    scene.place(post, {{p.x(), p.y(), 0.0}, 0.0, 1.0});
  }
  scene.finish();
  return {std::move(circuit), std::move(scene)};
}

Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double u) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = (1.0 - u) * a.translation() + u * b.translation();
  pose.linear() = Eigen::Quaterniond(a.rotation())
                      .slerp(u, Eigen::Quaterniond(b.rotation()))
                      .toRotationMatrix();
  return pose;
}

/// What tf gives a listener: interpolation between samples at 100 Hz, link by link.
Eigen::Isometry3d lookUp(const VehiclePath& path, const Ladar& ladar, double time_s) {
  const double before = std::floor(time_s * 100.0) / 100.0;
  const double u = (time_s - before) * 100.0;
  return interpolate(path.T_odom_base(before), path.T_odom_base(before + 0.01), u) *
         interpolate(ladar.T_base_ladar(before), ladar.T_base_ladar(before + 0.01), u);
}

bool sameBits(const Scan& a, const Scan& b, const LadarConfig& config) {
  return encodeScan(a, config) == encodeScan(b, config);
}

TEST(SimLadar, DefaultsAreValidAndViolationsAreNamed) {
  EXPECT_TRUE(LadarConfig().validate().empty());
  LadarConfig bad;
  bad.rows = 0;
  bad.drop_probability = 1.5;
  bad.pan_period_s = std::nan("");
  bad.heads_deg = {0.0, 90.0, 200.0, 0.0, 0.0, 0.0, 0.0};
  bad.row_elevations_deg = {1.0, -91.0};
  bad.rays = 17;
  auto errors = bad.validate();
  for (const char* field : {"row_elevations_deg = 2", "row_elevations_deg = -91", "heads_deg = 7",
                            "heads_deg = 200", "rays = 17"}) {
    const auto named = std::find_if(errors.begin(), errors.end(), [&](const std::string& error) {
      return error.find(field) == 0;
    });
    ASSERT_NE(named, errors.end()) << field;
    errors.erase(named);
  }
  ASSERT_EQ(errors.size(), 3U);
  EXPECT_NE(errors[0].find("rows"), std::string::npos);
  EXPECT_NE(errors[1].find("drop_probability"), std::string::npos);
  EXPECT_NE(errors[2].find("pan_period_s"), std::string::npos);
}

TEST(SimLadar, BeamsFillTheFieldOfViewFromTopLeft) {
  const World world = makePlain(false);
  const VehiclePath path(world.circuit, world.scene.ground(), 0.0);
  const LadarConfig config;
  const Ladar ladar(config, world.scene, path, 1);
  const auto azimuth = [](const Eigen::Vector3d& v) { return std::atan2(v.y(), v.x()); };
  const Eigen::Vector3d first = ladar.beam(0, 0);
  const Eigen::Vector3d last = ladar.beam(31, 179);
  EXPECT_NEAR(azimuth(first) / kRadPerDeg, 45.0 - 0.25, 1e-9);
  EXPECT_NEAR(azimuth(last) / kRadPerDeg, -45.0 + 0.25, 1e-9);
  EXPECT_NEAR(std::asin(first.z()) / kRadPerDeg, 10.0 - 0.3125, 1e-9);
  EXPECT_NEAR(std::asin(last.z()) / kRadPerDeg, -10.0 + 0.3125, 1e-9);
  EXPECT_NEAR(ladar.beamTime(31, 179), 0.05 * 179 / 180, 1e-12);
  EXPECT_EQ(ladar.takeScan(0).size(), 180U * 32U);
}

TEST(SimLadar, PointsLieAlongTheirBeamsWithinRange) {
  const World world = makePlain(true);
  const VehiclePath path(world.circuit, world.scene.ground(), 2.0);
  const LadarConfig config;
  const Ladar ladar(config, world.scene, path, 1);
  const Scan scan = ladar.takeScan(3);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Return& r = scan[i];
    if (!r.valid()) {
      EXPECT_EQ(r.truth, Truth::kNone);
      EXPECT_EQ(r.rgb, 0U);
      continue;
    }
    const Eigen::Vector3d p = r.p_ladar.cast<double>();
    const Eigen::Vector3d beam = ladar.beam(static_cast<int>(i / 180), static_cast<int>(i % 180));
    EXPECT_LT(p.cross(beam).norm(), 1e-4);
    EXPECT_GE(p.norm(), config.min_range_m);
    EXPECT_LE(p.norm(), config.max_range_m + 1e-4);
    EXPECT_TRUE(r.mixed || r.truth != Truth::kNone);
    EXPECT_GE(r.intensity, 0.0F);
    EXPECT_LE(r.intensity, 255.0F);
  }
}

TEST(SimLadar, MotionCompensatedGroundIsFlatAndRawPostsAreMisplaced) {
  const World world = makePlain(true);
  const VehiclePath path(world.circuit, world.scene.ground(), 15.0);
  LadarConfig config;
  config.range_sigma_m = 0.0;
  config.angle_sigma_deg = 0.0;
  config.divergence_mrad = 0.0;
  const Ladar ladar(config, world.scene, path, 1);
  double worst_ground_m = 0.0;
  double worst_post_m = 0.0;
  double worst_raw_m = 0.0;
  for (uint64_t k = 0; k < 12; ++k) {
    const double start = ladar.startTime(k * 7);
    for (const Return& r : ladar.takeScan(k * 7)) {
      if (!r.valid() || r.mixed) continue;
      const Eigen::Vector3d p = r.p_ladar.cast<double>();
      const Eigen::Vector3d p_odom = lookUp(path, ladar, start + double{r.time_s}) * p;
      if (r.truth == Truth::kSurface) {
        worst_ground_m = std::max(worst_ground_m, std::abs(p_odom.z()));
        continue;
      }
      // Posts stand on circles of radius 35 and 45 m; their radius is 6 cm.
      const auto off = [](const Eigen::Vector3d& q) {
        const double d = q.head<2>().norm();
        return std::min(std::abs(d - 35.0), std::abs(d - 45.0));
      };
      worst_post_m = std::max(worst_post_m, off(p_odom));
      worst_raw_m = std::max(worst_raw_m, off(lookUp(path, ladar, start) * p));
    }
  }
  EXPECT_LT(worst_ground_m, 0.002);
  EXPECT_LT(worst_post_m, 0.065);
  EXPECT_GT(worst_raw_m, 0.25) << "without the times, posts must stand in the wrong place";
}

TEST(SimLadar, GroundNoiseIsCentimetres) {
  const World world = makePlain(false);
  const VehiclePath path(world.circuit, world.scene.ground(), 3.0);
  const Ladar ladar(LadarConfig(), world.scene, path, 1);
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (uint64_t k = 0; k < 5; ++k) {
    for (const Return& r : ladar.takeScan(k)) {
      if (!r.valid() || r.p_ladar.norm() > 15.0F) continue;
      const double time_s = ladar.startTime(k) + double{r.time_s};
      const double z = (lookUp(path, ladar, time_s) * r.p_ladar.cast<double>()).z();
      sum += z;
      squares += z * z;
      ++count;
    }
  }
  ASSERT_GT(count, 3000);
  EXPECT_LT(std::abs(sum / count), 0.001);
  EXPECT_GT(std::sqrt(squares / count), 0.003);
  EXPECT_LT(std::sqrt(squares / count), 0.012);
}

TEST(SimLadar, LossesAndMixedReturnsAreFewAndGrowWithRange) {
  const World world = makePlain(true);
  const VehiclePath path(world.circuit, world.scene.ground(), 2.0);
  LadarConfig config;
  config.nod_amplitude_deg = 0.0;
  const Ladar ladar(config, world.scene, path, 1);
  int beams[2] = {0, 0};
  int lost[2] = {0, 0};
  ScanSummary summary;
  for (uint64_t k = 0; k < 10; ++k) {
    const Scan scan = ladar.takeScan(k * 5);
    summary.add(scan);
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const std::size_t row = i / 180;
      if (row > 18 && row < 24) continue;
      if (row < 16) continue;  // sky and the far ground
      const int near = row >= 24 ? 1 : 0;
      ++beams[near];
      lost[near] += scan[i].valid() ? 0 : 1;
    }
  }
  const double near_loss = static_cast<double>(lost[1]) / beams[1];
  const double far_loss = static_cast<double>(lost[0]) / beams[0];
  EXPECT_GT(near_loss, 0.008);
  EXPECT_LT(near_loss, 0.05);
  EXPECT_GT(far_loss, near_loss);
  const double mixed = static_cast<double>(summary.mixed) / static_cast<double>(summary.returned);
  EXPECT_GT(mixed, 0.001);
  EXPECT_LT(mixed, 0.10);
  const uint64_t of_a_class = summary.surface + summary.scatter + summary.linear;
  EXPECT_GE(summary.returned, of_a_class);
  EXPECT_LE(summary.returned, of_a_class + summary.mixed);
  EXPECT_GT(summary.returned, of_a_class) << "posts mixed with ground are of no class";
}

TEST(SimLadar, SameSeedSameBitsInAnyOrder) {
  const World world = makePlain(true);
  const VehiclePath path(world.circuit, world.scene.ground(), 2.0);
  const LadarConfig config;
  const Ladar a(config, world.scene, path, 7);
  const Ladar b(config, world.scene, path, 7);
  const Ladar c(config, world.scene, path, 8);
  const Scan a3 = a.takeScan(3);
  const Scan a4 = a.takeScan(4);
  EXPECT_TRUE(sameBits(b.takeScan(4), a4, config));
  EXPECT_TRUE(sameBits(b.takeScan(3), a3, config));
  EXPECT_FALSE(sameBits(c.takeScan(3), a3, config));
}

TEST(SimScanCloud, FieldsCanBeReadBack) {
  const LadarConfig config;
  Scan scan(static_cast<std::size_t>(config.columns) * config.rows);
  const std::size_t at = 5 * 180 + 17;
  scan[at].p_ladar = {1.5F, -2.25F, 0.5F};
  scan[at].intensity = 33.0F;
  scan[at].time_s = 0.0125F;
  scan[at].truth = Truth::kLinear;
  scan[at].rgb = 0x00a1b2c3;
  scan[at].label = Label::kFence;
  const CloudLayout layout = scanLayout(config);
  const std::vector<uint8_t> data = encodeScan(scan, config);
  const CloudView view{layout, data.data(), data.size()};
  EXPECT_EQ(layoutError(view), "");
  const auto read = [&](const char* name, auto value) {
    std::memcpy(&value, view.point(5, 17) + layout.find(name)->offset, sizeof(value));
    return value;
  };
  EXPECT_EQ(read("x", 0.0F), 1.5F);
  EXPECT_EQ(read("y", 0.0F), -2.25F);
  EXPECT_EQ(read("z", 0.0F), 0.5F);
  EXPECT_EQ(read("intensity", 0.0F), 33.0F);
  EXPECT_EQ(read("time", 0.0F), 0.0125F);
  EXPECT_EQ(read("ring", uint16_t{0}), 5);
  EXPECT_EQ(read("truth", uint8_t{0}), 3);
  EXPECT_EQ(read("rgb", uint32_t{0}), 0x00a1b2c3U);
  EXPECT_EQ(read("label", uint16_t{0}), 14);
}

}  // namespace
}  // namespace ladar_perception::sim
