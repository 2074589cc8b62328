// SPDX-License-Identifier: BSD-3-Clause
#include "whole_tile.h"

#include <cmath>
#include <stdexcept>

namespace ladar_perception::bench {
namespace {

using Eigen::Vector3d;

struct Extent {
  explicit Extent(const std::vector<Vector3d>& points_m) {
    if (points_m.empty()) throw std::runtime_error("a tile without points");
    low = high = points_m.front();
    for (const Vector3d& p : points_m) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  Vector3d center() const { return 0.5 * (low + high); }

  Vector3d low, high;
};

/// Under the middle of the cloud, so far that no point is too near.
Eigen::Isometry3d sensorPose(const Extent& extent) {
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  T_map_sensor.translation() = extent.center();
  T_map_sensor.translation().z() = extent.low.z() - 10.0;
  return T_map_sensor;
}

/// The model's voxels and support, in a map with a margin of a metre.
TerrainConfig configFor(const Extent& extent, const ClassifierModel& model) {
  constexpr double kMargin_m = 1.0;
  const Vector3d size = (extent.high - extent.low).array() + 2.0 * kMargin_m;
  TerrainConfig config;
  config.voxel_size_m = model.voxel_size_m;
  config.support_radius_voxels = model.support_radius_voxels;
  config.support_kernel = model.support_kernel;
  config.map_size_x_m = std::ceil(size.x());
  config.map_size_y_m = std::ceil(size.y());
  config.map_size_z_m = std::ceil(size.z());
  config.map_center_height_m = 0.0;
  config.max_range_m = 1000.0;
  config.threads = 1;
  std::string errors;
  for (const std::string& error : config.validate()) errors += error + "\n";
  if (!errors.empty()) throw std::runtime_error("the tile does not fit into a map:\n" + errors);
  return config;
}

}  // namespace

WholeTile::WholeTile(const std::vector<Vector3d>& points_m, const ClassifierModel& model)
    : points_(points_m.size()),
      p_map_center_(Extent(points_m).center()),
      T_map_sensor_(sensorPose(Extent(points_m))),
      pipeline_(configFor(Extent(points_m), model), model),
      cloud_(points_m, T_map_sensor_.translation()),
      fields_(cloud_.fields()) {}

void WholeTile::process() {
  pipeline_.process(cloud_.view(), fields_, {}, SensorMotion(T_map_sensor_), p_map_center_);
}

Labels WholeTile::labels() const {
  Labels labels;
  labels.reserve(points_);
  for (const PointLabel& label : pipeline_.pointLabels()) labels.push_back(label.label);
  return labels;
}

}  // namespace ladar_perception::bench
