// SPDX-License-Identifier: BSD-3-Clause
// Simple scenes and scans for tests of the terrain pipeline.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "cloud_builder.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "test_random.h"

namespace ladar_perception::test {

/// The middle of the quantisation step nearest to a coordinate at 0.1 m voxels. From there no
/// rounding of a far sum, nor of a float32, crosses to another step.
inline double stepMiddle(double coordinate_m) {
  return (std::floor(coordinate_m * 2560.0) + 0.5) / 2560.0;
}

inline Eigen::Vector3d stepMiddle(const Eigen::Vector3d& p) {
  return {stepMiddle(p.x()), stepMiddle(p.y()), stepMiddle(p.z())};
}

/// Ground at z = -0.45, x and y within 5 m.
inline std::vector<Eigen::Vector3d> groundPoints(TestRandom* random, int count) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double x = random->real(-5, 5);
    const double y = random->real(-5, 5);
    points.push_back(stepMiddle({x, y, -0.45 + 0.003 * random->normal()}));
  }
  return points;
}

/// A wire along y at x = 2, z = 1.25.
inline std::vector<Eigen::Vector3d> wirePoints(TestRandom* random, int count) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double y = random->real(-5, 5);
    const double x = 2.0 + 0.003 * random->normal();
    points.push_back(stepMiddle({x, y, 1.25 + 0.003 * random->normal()}));
  }
  return points;
}

/// Leaves in a box of 1.6 m around (7.5, 0, 0.8).
inline std::vector<Eigen::Vector3d> leafPoints(TestRandom* random, int count) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double x = random->real(6.7, 8.3);
    const double y = random->real(-0.8, 0.8);
    points.push_back(stepMiddle({x, y, random->real(0.0, 1.6)}));
  }
  return points;
}

/// Ground, a wire and leaves, in that order, around the sensor.
struct MixedScene {
  explicit MixedScene(int seed = 1) {
    TestRandom random(seed);
    for (const auto& part :
         {groundPoints(&random, 20000), wirePoints(&random, 1000), leafPoints(&random, 4000)}) {
      points.insert(points.end(), part.begin(), part.end());
    }
  }
  std::vector<Eigen::Vector3d> points;
};

/// Feeds points given in the sensor frame, all measured at the stamp.
inline const ScanReport& processPoints(TerrainPipeline* pipeline, const CloudBuilder& cloud,
                                       const Eigen::Isometry3d& T_map_sensor,
                                       const Eigen::Vector3d& p_map_vehicle,
                                       const std::vector<float>& time_offsets_s = {},
                                       double stamp_s = 0.0) {
  std::string error;
  const CloudView view = cloud.view();
  const auto fields = findPointFields(view, &error);
  return pipeline->process(view, *fields, time_offsets_s, SensorMotion(T_map_sensor), p_map_vehicle,
                           stamp_s);
}

/// A sensor without rotation at the vehicle's place.
inline const ScanReport& processAt(TerrainPipeline* pipeline,
                                   const std::vector<Eigen::Vector3d>& p_sensor,
                                   const Eigen::Vector3d& p_map_vehicle, double stamp_s = 0.0) {
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  T_map_sensor.translation() = p_map_vehicle;
  return processPoints(pipeline, xyzCloud(p_sensor), T_map_sensor, p_map_vehicle, {}, stamp_s);
}

/// Points given in the map frame, to the step, seen from far below the vehicle, so that none is too
/// near.
inline const ScanReport& processInMap(TerrainPipeline* pipeline,
                                      const std::vector<Eigen::Vector3d>& p_map,
                                      const Eigen::Vector3d& p_map_vehicle) {
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  T_map_sensor.translation() = p_map_vehicle - Eigen::Vector3d(0, 0, 16);
  std::vector<Eigen::Vector3d> p_sensor;
  for (const Eigen::Vector3d& p : p_map) {
    p_sensor.push_back(stepMiddle(p) - T_map_sensor.translation());
  }
  return processPoints(pipeline, xyzCloud(p_sensor), T_map_sensor, p_map_vehicle);
}

}  // namespace ladar_perception::test
