// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/cloud/point_reader.h"

namespace ladar_perception::bench {

/// Positions as the bytes of a cloud with x, y and z in float32, seen from an origin.
class PositionCloud {
 public:
  PositionCloud(const std::vector<Eigen::Vector3d>& points_m, const Eigen::Vector3d& origin_m) {
    for (const char* name : {"x", "y", "z"}) layout_.append(name, ScalarType::kFloat32);
    layout_.width = static_cast<uint32_t>(points_m.size());
    layout_.height = 1;
    layout_.pack();
    values_.reserve(3 * points_m.size());
    for (const Eigen::Vector3d& p : points_m) {
      for (int axis = 0; axis < 3; ++axis) {
        values_.push_back(static_cast<float>(p[axis] - origin_m[axis]));
      }
    }
  }

  CloudView view() const {
    return {layout_, reinterpret_cast<const uint8_t*>(values_.data()),
            values_.size() * sizeof(float)};
  }
  PointFields fields() const {
    std::string error;
    return *findPointFields(view(), &error);
  }

 private:
  CloudLayout layout_;
  std::vector<float> values_;
};

}  // namespace ladar_perception::bench
