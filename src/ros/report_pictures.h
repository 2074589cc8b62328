// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ladar_perception {

/// Runs one of the package's Python scripts on the folder of a report, whose JSON must be there;
/// "", or why there are no pictures (matplotlib is missing, for one).
std::string drawPictures(const std::string& script, const std::string& folder);

}  // namespace ladar_perception
