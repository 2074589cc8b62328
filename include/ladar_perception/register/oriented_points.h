// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ladar_perception {

/// Points of surfaces. Both arrays have one length.
struct OrientedPoints {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<Eigen::Vector3f>
      normals;  ///< unit, towards the sensor; zero where there is no surface

  std::size_t size() const { return positions_m.size(); }
};

}  // namespace ladar_perception
