// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "ladar_perception/cloud/sensor_motion.h"

namespace ladar_perception {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d pose(const Vector3d& translation, double yaw_rad) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = AngleAxisd(yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = translation;
  return T;
}

SensorMotion turning() {
  return SensorMotion(
      {{-0.1, pose({0, 0, 0}, 0.0)}, {0.0, pose({1, 0, 0}, 0.2)}, {0.3, pose({1, 3, 0}, 0.8)}});
}

TEST(SensorMotion, AtRestIsTheSameAlways) {
  const Isometry3d T = pose({1, 2, 3}, 0.4);
  const SensorMotion motion(T);
  for (const double offset_s : {-5.0, 0.0, 7.0}) {
    EXPECT_EQ(motion.poseAt(offset_s).matrix(), T.matrix());
  }
}

TEST(SensorMotion, GoesThroughItsKnotsAndStraightBetween) {
  const SensorMotion motion = turning();
  for (const auto& knot : motion.knots()) {
    EXPECT_TRUE(motion.poseAt(knot.offset_s).isApprox(knot.T_map_sensor, 1e-12));
  }
  EXPECT_TRUE(motion.poseAt(-0.05).isApprox(pose({0.5, 0, 0}, 0.1), 1e-12));
  EXPECT_TRUE(motion.poseAt(0.1).isApprox(pose({1, 1, 0}, 0.4), 1e-12));
}

TEST(SensorMotion, StaysAtTheEndsBeyondThem) {
  const SensorMotion motion = turning();
  EXPECT_EQ(motion.poseAt(-9.0).matrix(), motion.knots().front().T_map_sensor.matrix());
  EXPECT_EQ(motion.poseAt(9.0).matrix(), motion.knots().back().T_map_sensor.matrix());
}

TEST(SensorMotion, TellsWhenAPoseIsNotFinite) {
  EXPECT_TRUE(turning().isFinite());
  Isometry3d bad = Isometry3d::Identity();
  bad.translation().y() = std::nan("");
  EXPECT_FALSE(SensorMotion(bad).isFinite());
  EXPECT_FALSE(SensorMotion({{0.0, Isometry3d::Identity()}, {1.0, bad}}).isFinite());
}

TEST(MotionTable, IsCloseToTheMotionEverywhere) {
  const SensorMotion motion = turning();
  MotionTable table;
  table.assign(motion);
  for (double offset_s = -0.2; offset_s < 0.4; offset_s += 0.000377) {
    const Isometry3d expected = motion.poseAt(offset_s);
    const Isometry3d& nearest = table.nearest(static_cast<float>(offset_s));
    // 0.4 s in 1023 steps: half a step is 0.2 ms, at 10 m/s and 2 rad/s.
    ASSERT_LT((nearest.translation() - expected.translation()).norm(), 0.0021) << offset_s;
    ASSERT_LT((nearest.linear() - expected.linear()).norm(), 0.001) << offset_s;
  }
}

TEST(MotionTable, KeepsThePromiseOfItsHeader) {
  // 15 m/s and 100 ms a scan: within 0.75 mm.
  const SensorMotion motion({{0.0, pose({0, 0, 0}, 0)}, {0.1, pose({1.5, 0, 0}, 0)}});
  MotionTable table;
  table.assign(motion);
  for (double offset_s = 0.0; offset_s <= 0.1; offset_s += 0.0000137) {
    ASSERT_NEAR(table.nearest(static_cast<float>(offset_s)).translation().x(), 15.0 * offset_s,
                0.00075);
  }
}

TEST(MotionTable, OfASensorAtRest) {
  MotionTable table;
  table.assign(turning());
  const Isometry3d T = pose({1, 2, 3}, 0.4);
  table.assign(SensorMotion(T));
  for (const float offset_s : {-1e6F, 0.0F, 1e6F}) {
    EXPECT_EQ(table.nearest(offset_s).matrix(), T.matrix());
  }
}

}  // namespace
}  // namespace ladar_perception
