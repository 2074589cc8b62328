// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "ladar_perception/register/registration_config.h"

namespace ladar_perception {
namespace {

TEST(RegistrationConfig, DefaultsAreValid) {
  RegistrationConfig config;
  EXPECT_TRUE(config.validate().empty());
  ParamTable table;
  config.addTo(&table);
  for (const ParamSpec& spec : table.specs()) {
    if (const auto* number = std::get_if<double*>(&spec.target)) {
      EXPECT_GE(**number, spec.min) << spec.name;
      EXPECT_LE(**number, spec.max) << spec.name;
    }
    EXPECT_NE(spec.meaning, "") << spec.name;
  }
}

TEST(RegistrationConfig, TakesItsParameters) {
  RegistrationConfig config;
  ParamTable table;
  config.addTo(&table);
  EXPECT_TRUE(table
                  .apply({{"solver", std::string("plain")},
                          {"initial_radius_m", 5.0},
                          {"coarse_samples", 300}})
                  .empty());
  EXPECT_EQ(config.solver, "plain");
  EXPECT_EQ(config.initial_radius_m, 5.0);
  EXPECT_EQ(config.coarse_samples, 300);
  EXPECT_EQ(table.apply({{"radius_factor", 1.0}}).size(), 1U);  // would never end
}

TEST(RegistrationConfig, NamesEveryViolation) {
  RegistrationConfig config;
  config.solver = "fast";
  config.cost = "low";
  config.initial_radius_m = 0.2;
  const std::vector<std::string> violations = config.validate();
  ASSERT_EQ(violations.size(), 3U);
  EXPECT_NE(violations[0].find("solver: 'fast'"), std::string::npos);
  EXPECT_NE(violations[1].find("cost: 'low'"), std::string::npos);
  EXPECT_NE(violations[2].find("initial_radius_m"), std::string::npos);
}

}  // namespace
}  // namespace ladar_perception
