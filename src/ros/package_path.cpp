// SPDX-License-Identifier: BSD-3-Clause
#include "package_path.h"

#include <ros/package.h>

#include <stdexcept>

namespace ladar_perception {

std::string resolvePackagePath(const std::string& path) {
  const std::string scheme = "package://";
  if (path.compare(0, scheme.size(), scheme) != 0) return path;
  const std::size_t slash = path.find('/', scheme.size());
  if (slash == std::string::npos) {
    throw std::runtime_error(path + ": expected package://<package>/<path>");
  }
  const std::string package = path.substr(scheme.size(), slash - scheme.size());
  const std::string folder = ros::package::getPath(package);
  if (folder.empty()) {
    throw std::runtime_error(path + ": package '" + package +
                             "' is not found; is its setup.sh sourced?");
  }
  return folder + path.substr(slash);
}

}  // namespace ladar_perception
