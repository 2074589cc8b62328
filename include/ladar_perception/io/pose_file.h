// SPDX-License-Identifier: BSD-3-Clause
// Poses of scans from text files.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace ladar_perception {

enum class PoseFormat {
  kKitti,  ///< a line: row-major 3x4 (12 numbers) or 4x4 (16 numbers)
  kTum,    ///< a line: stamp_s x y z qx qy qz qw
};

struct Poses {
  std::vector<Eigen::Isometry3d> T_map_lidar;
  std::vector<double> stamps_s;  ///< as many, increasing; empty for kKitti
};

/// Reads one pose a line, '#' starts a comment. Throws std::runtime_error that names file and line
/// of a wrong count of numbers, a token that is no finite number, a rotation that is off by more
/// than 1e-3, or a stamp that does not increase.
Poses readPoses(const std::string& path, PoseFormat format);

}  // namespace ladar_perception
