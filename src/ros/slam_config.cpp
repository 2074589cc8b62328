// SPDX-License-Identifier: BSD-3-Clause
#include "slam_config.h"

#include <vector>

#include "param_reader.h"

namespace ladar_perception {

ParamTable SlamConfig::table() {
  ParamTable table;
  state.addTo(&table);
  registration.addTo(&table);
  return table;
}

SlamConfig readSlamConfig(const ParamMap& values, const std::string& source) {
  SlamConfig config;
  std::vector<std::string> violations = config.table().apply(values);
  for (const std::string& violation : config.state.validate()) violations.push_back(violation);
  for (const std::string& violation : config.registration.validate()) {
    violations.push_back(violation);
  }
  refuse(violations, source);
  return config;
}

SlamConfig readSlamConfigFile(const std::string& path) {
  return path.empty() ? SlamConfig() : readSlamConfig(loadParamFile(path), path);
}

}  // namespace ladar_perception
