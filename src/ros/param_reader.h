// SPDX-License-Identifier: BSD-3-Clause
// The strict readers of the nodes' parameters.
#pragma once

#include <ros/node_handle.h>

#include <string>
#include <utility>
#include <vector>

#include "ladar_perception/params/param_table.h"

namespace ladar_perception {

/// All parameters in the handle's namespace, but those that belong to diagnostic_updater.
ParamMap paramsOf(const ros::NodeHandle& private_handle);
/// What reports call the handle's namespace.
std::string sourceName(const ros::NodeHandle& private_handle);

/// Appends what is wrong with a frame's name.
void checkFrame(const std::string& name, const std::string& frame, bool may_be_empty,
                std::vector<std::string>* violations);

/// Throws std::runtime_error with every violation, one a line, under a first line that names
/// `source`; returns if there are none.
void refuse(const std::vector<std::string>& violations, const std::string& source);

/// Configuration from a map of values. `Config` has a table() of its parameters and a validate()
/// that returns what no single range can tell. Throws as refuse() does.
template <typename Config>
Config readConfig(const ParamMap& values, const std::string& source) {
  Config config;
  std::vector<std::string> violations = config.table().apply(values);
  for (std::string& violation : config.validate()) violations.push_back(std::move(violation));
  refuse(violations, source);
  return config;
}
/// From a YAML file; "" gives the defaults.
template <typename Config>
Config readConfigFile(const std::string& path) {
  return path.empty() ? Config() : readConfig<Config>(loadParamFile(path), path);
}
/// From the parameters in the handle's namespace.
template <typename Config>
Config readConfig(const ros::NodeHandle& private_handle) {
  return readConfig<Config>(paramsOf(private_handle), sourceName(private_handle));
}
/// Appends what a part of a configuration has found.
inline void append(std::vector<std::string> more, std::vector<std::string>* violations) {
  for (std::string& violation : more) violations->push_back(std::move(violation));
}

}  // namespace ladar_perception
