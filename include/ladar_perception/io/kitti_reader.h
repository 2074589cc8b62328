// SPDX-License-Identifier: BSD-3-Clause
// Reader of KITTI scans and SemanticKITTI labels.
#pragma once

#include <string>

#include "ladar_perception/io/scan.h"

namespace ladar_perception {

/// Scan of float32 x y z intensity. Labels, if there are any for it, become the fields `label`
/// (lower 16 bits) and `instance` (upper 16 bits). Throws std::runtime_error that names the file
/// and its size if that is not a whole number of points, or if the label count is another.
Scan readKittiScan(const std::string& path);

/// Labels of a scan: `<stem>.label` beside it or in ../labels, where SemanticKITTI has them; ""
/// if there are none.
std::string findKittiLabels(const std::string& scan_path);

}  // namespace ladar_perception
