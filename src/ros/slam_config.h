// SPDX-License-Identifier: BSD-3-Clause
// Configuration of the delayed-state estimate and of the registrations that it makes.
#pragma once

#include <string>

#include "ladar_perception/params/param_table.h"
#include "ladar_perception/register/registration_config.h"
#include "ladar_perception/slam/delayed_state_config.h"

namespace ladar_perception {

struct SlamConfig {
  DelayedStateConfig state;
  RegistrationConfig registration;

  /// The table that feeds the strict reader, config/delayed_state.yaml and the documentation.
  ParamTable table();
};

/// Configuration from a map of values. Throws std::runtime_error with every violation, one a line,
/// under a first line that names `source`.
SlamConfig readSlamConfig(const ParamMap& values, const std::string& source);
/// From a YAML file; "" gives the defaults.
SlamConfig readSlamConfigFile(const std::string& path);

}  // namespace ladar_perception
