// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ladar_perception {

/// Path behind package://<package>/<path>; other texts are paths already. Throws std::runtime_error
/// that names the package if ROS does not know it.
std::string resolvePackagePath(const std::string& path);

}  // namespace ladar_perception
