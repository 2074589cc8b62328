// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "ladar_perception/slam/delayed_state_config.h"

namespace ladar_perception {
namespace {

TEST(SlamDelayedStateConfig, DefaultsAreInOrder) {
  DelayedStateConfig config;
  EXPECT_TRUE(config.validate().empty());
  ParamTable table;
  config.addTo(&table);
  EXPECT_EQ(table.specs().size(), 18u);
  EXPECT_TRUE(table.apply({{"accept_overlap", 0.5}, {"threads", 2}}).empty());
  EXPECT_EQ(config.accept_overlap, 0.5);
  EXPECT_EQ(config.threads, 2);
}

TEST(SlamDelayedStateConfig, ReportsWhatIsWrong) {
  DelayedStateConfig config;
  ParamTable table;
  config.addTo(&table);
  EXPECT_EQ(table.apply({{"accept_overlap", 1.5}, {"overlap_dist_m", 3.0}}).size(), 2u);
  config.loop_hops = config.window_poses = 20;
  ASSERT_EQ(config.validate().size(), 1u);
  EXPECT_NE(config.validate()[0].find("loop_hops: 20"), std::string::npos);
}

TEST(SlamDelayedStateConfig, OdometryDriftsAsItSays) {
  DelayedStateConfig config;
  config.drift_m_per_100_m = 3.0;
  config.drift_deg_per_100_m = 1.0;
  config.odometry_floor_m = 1e-4;
  config.odometry_floor_deg = 1e-3;
  // A hundred steps of a metre.
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  step.translation().y() = 1.0;
  const Matrix6d covariance = 100.0 * config.odometryCovariance(step);
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 3.0, 1e-3);
  EXPECT_NEAR(std::sqrt(covariance(5, 5)) * 180.0 / M_PI, 1.0, 1e-3);
  // Standing still is not known better than the floor.
  const Matrix6d still = config.odometryCovariance(Eigen::Isometry3d::Identity());
  EXPECT_NEAR(std::sqrt(still(1, 1)), 1e-4, 1e-12);
}

}  // namespace
}  // namespace ladar_perception
