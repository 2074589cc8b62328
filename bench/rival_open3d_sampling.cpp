// SPDX-License-Identifier: BSD-3-Clause
// The only unit that sees Open3D's headers.
#include <open3d/geometry/PointCloud.h>

#include <memory>

#include "sampling_methods.h"

namespace ladar_perception::bench {

SamplingMethod open3dFarthestPoints(const Points& points, std::size_t count) {
  const auto input = std::make_shared<open3d::geometry::PointCloud>(points);
  auto output = std::make_shared<std::shared_ptr<open3d::geometry::PointCloud>>();
  return {[=] { *output = input->FarthestPointDownSample(count); },
          [=] { return (*output)->points_; }};
}

}  // namespace ladar_perception::bench
