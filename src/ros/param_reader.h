// SPDX-License-Identifier: BSD-3-Clause
// What the strict readers of the nodes' parameters share.
#pragma once

#include <ros/node_handle.h>

#include <string>
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

}  // namespace ladar_perception
