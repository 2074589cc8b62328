// SPDX-License-Identifier: BSD-3-Clause
// What a beam reports that lies on more than one thing: edges, thin wires, windows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladar_perception/sim/ladar.h"
#include "ladar_perception/sim/world.h"

namespace ladar_perception::sim {
namespace {

TEST(SimLadarEcho, MixedReturnsLieBetweenTheTwoDepths) {
  Circuit circuit({40.0, 40.0});
  Scene scene{HeightField()};
  // A wall at 12 m whose left half is missing, and another at 14 m: one vertical edge.
  scene.place(scene.addModel({makeBox({53.0, 12.0, 0}, {30, 0.2, 20}, 0, Material::kBrick),
                              makeBox({40.0, 14.0, 0}, {60, 0.2, 20}, 0, Material::kPlaster)}),
              Placement());
  scene.finish();
  const VehiclePath path(circuit, scene.ground(), 0.0);
  LadarConfig config;
  config.range_sigma_m = 0.0;
  config.pan_amplitude_deg = 0.0;
  const Ladar ladar(config, scene, path, 1);
  int mixed = 0;
  for (uint64_t k = 0; k < 20; ++k) {
    const double time_s = ladar.startTime(k);
    const Eigen::Isometry3d T_odom_ladar = path.T_odom_base(time_s) * ladar.T_base_ladar(time_s);
    for (const Return& r : ladar.takeScan(k)) {
      if (!r.mixed) continue;
      ++mixed;
      const double y = (T_odom_ladar * r.p_ladar.cast<double>()).y();
      EXPECT_GT(y, 11.8);
      EXPECT_LT(y, 14.1);
    }
  }
  EXPECT_GT(mixed, 5);
}

/// A thin wire across the view, 8 m to the right, before nothing.
Scan lookAtWire(const LadarConfig& config) {
  const Circuit circuit({40.0, 40.0});
  Scene scene{HeightField()};
  scene.place(
      scene.addModel({makeCapsule({48.0, -9, 1.7}, {48.0, 9, 1.7}, 0.008, Material::kWire)}),
      Placement());
  scene.finish();
  const VehiclePath path(circuit, scene.ground(), 0.0);
  return Ladar(config, scene, path, 1).takeScan(0);
}

TEST(SimLadarEcho, AWideBeamSeesAThinWireAndReportsItsOwnDirection) {
  LadarConfig config;  // looks sideways at the wire, as a spinning sensor would
  config.heads_deg = {-90.0};
  config.width_deg = 20.0;
  config.height_deg = 4.0;
  config.tilt_down_deg = config.nod_amplitude_deg = config.pan_amplitude_deg = 0.0;
  config.mount_forward_m = 0.0;
  config.range_sigma_m = config.angle_sigma_deg = config.drop_probability = 0.0;
  config.mount_height_m = 1.7;
  const auto returns = [](const Scan& scan) {
    return std::count_if(scan.begin(), scan.end(), [](const Return& r) { return r.valid(); });
  };
  config.divergence_mrad = 0.5;
  const auto narrow = returns(lookAtWire(config));
  config.divergence_mrad = 12.0;
  config.rays = 7;
  const Scan wide = lookAtWire(config);
  EXPECT_GT(returns(wide), 2 * narrow);
  for (const Return& r : wide) {
    if (!r.valid()) continue;
    EXPECT_EQ(r.label, Label::kWire);
    EXPECT_EQ(r.truth, Truth::kLinear);
    EXPECT_LT(std::abs(r.p_ladar.z()), 8.6 * 0.006 + 0.01) << "no farther off than half the beam";
  }
}

TEST(SimLadarEcho, HalfOfTheLightGoesThroughAWindow) {
  const Circuit circuit({40.0, 40.0});
  Scene scene{HeightField()};
  scene.place(scene.addModel({makeBox({40.0, 8.0, 0}, {40, 0.05, 20}, 0, Material::kGlass),
                              makeBox({40.0, 9.0, 0}, {40, 0.2, 20}, 0, Material::kBrick)}),
              Placement());
  scene.finish();
  const VehiclePath path(circuit, scene.ground(), 0.0);
  LadarConfig config;
  config.rays = 1;
  config.range_sigma_m = 0.0;
  const Ladar ladar(config, scene, path, 1);
  int pane = 0;
  int wall = 0;
  for (const Return& r : ladar.takeScan(0)) {
    if (!r.valid()) continue;
    const double time_s = double{r.time_s};
    const double y =
        (path.T_odom_base(time_s) * ladar.T_base_ladar(time_s) * r.p_ladar.cast<double>()).y();
    pane += std::abs(y - 7.975) < 0.05 ? 1 : 0;
    wall += std::abs(y - 8.9) < 0.05 ? 1 : 0;
  }
  EXPECT_GT(pane, 1000);
  EXPECT_GT(wall, 1000);
  EXPECT_NEAR(static_cast<double>(wall) / (wall + pane), 0.6, 0.1) << "dark panes return less";
}

}  // namespace
}  // namespace ladar_perception::sim
