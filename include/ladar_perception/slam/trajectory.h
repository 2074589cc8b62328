// SPDX-License-Identifier: BSD-3-Clause
// Trajectories as files, and how far one is from the truth.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace ladar_perception {

using Trajectory = std::vector<Eigen::Isometry3d>;

/// A line a pose: stamp_s x y z qx qy qz qw, with nanoseconds. As many stamps as poses. Throws
/// std::runtime_error that names the path if it cannot be written.
void writeTum(const std::string& path, const std::vector<double>& stamps_s,
              const Trajectory& poses);
/// A line a pose: the row-major 3x4 matrix. Throws as writeTum() does.
void writeKitti(const std::string& path, const Trajectory& poses);

/// Distances of positions from the true ones, m.
struct TrajectoryError {
  double rms_m = 0.0;
  double max_m = 0.0;
};

/// Both begin at the same pose: what a vehicle that trusts its map will miss a place by.
TrajectoryError errorFromStart(const Trajectory& poses, const Trajectory& truth);
/// After the rigid motion that lays one on the other best (Umeyama's, without scale): the absolute
/// trajectory error of benchmarks. At least three poses that are not on a line, else as from the
/// start.
TrajectoryError errorAligned(const Trajectory& poses, const Trajectory& truth);

}  // namespace ladar_perception
