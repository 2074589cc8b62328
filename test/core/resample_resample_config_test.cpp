// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <stdexcept>

#include "expect_error.h"
#include "ladar_perception/resample/cloud_resampler.h"
#include "ladar_perception/resample/resample_config.h"

namespace ladar_perception {
namespace {

ResampleConfig countOf(int count) {
  ResampleConfig config;
  config.count = count;
  return config;
}

TEST(ResampleConfig, OneStopIsEnough) {
  EXPECT_TRUE(countOf(1).validate().empty());
  ResampleConfig config;
  config.radius_m = 0.1;
  EXPECT_TRUE(config.validate().empty());
  config.radius_m = 0.0;
  config.time_budget_s = 0.1;
  EXPECT_TRUE(config.validate().empty());
}

TEST(ResampleConfig, ToldAllThatIsWrong) {
  ResampleConfig config;
  config.engine = "dijkstra";
  config.crust = "meshes";
  const std::vector<std::string> violations = config.validate();
  ASSERT_EQ(violations.size(), 3u);
  EXPECT_NE(violations[0].find("'dijkstra', expected fast_marching or flood"), std::string::npos);
  EXPECT_NE(violations[1].find("'meshes', expected surfels or ellipsoids"), std::string::npos);
  EXPECT_NE(violations[2].find("count"), std::string::npos);
  test::expectError<std::invalid_argument>([&] { CloudResampler resampler(config); },
                                           {"dijkstra", "meshes", "count"});
}

}  // namespace
}  // namespace ladar_perception
