// SPDX-License-Identifier: BSD-3-Clause
// Scans of a small scene of known classes, seen from a vehicle on a gentle curve, as messages.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <sensor_msgs/PointCloud2.h>

#include "cloud_builder.h"
#include "cloud_message.h"
#include "hand_model.h"
#include "ladar_perception/cloud/point_reader.h"
#include "test_random.h"

namespace ladar_perception::test {

constexpr const char* kMapFrame = "odom";
constexpr const char* kVehicleFrame = "base_link";
constexpr const char* kSensorFrame = "ladar";
constexpr double kScanPeriod_s = 0.1;
constexpr int kScanRows = 4;

/// The vehicle's pose `t` seconds into the drive: 1 m/s, turning at 0.05 rad/s.
inline Eigen::Isometry3d vehiclePose(double t) {
  Eigen::Isometry3d T_odom_vehicle = Eigen::Isometry3d::Identity();
  T_odom_vehicle.translation() = Eigen::Vector3d(t, 0.0, 0.0);
  T_odom_vehicle.rotate(Eigen::AngleAxisd(0.05 * t, Eigen::Vector3d::UnitZ()));
  return T_odom_vehicle;
}

/// The ladar on the vehicle: a metre up, looking slightly down.
inline Eigen::Isometry3d sensorMount() {
  Eigen::Isometry3d T_vehicle_sensor = Eigen::Isometry3d::Identity();
  T_vehicle_sensor.translation() = Eigen::Vector3d(0.3, 0.0, 1.0);
  T_vehicle_sensor.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()));
  return T_vehicle_sensor;
}

inline geometry_msgs::TransformStamped transformMessage(const ros::Time& stamp,
                                                        const std::string& parent,
                                                        const std::string& child,
                                                        const Eigen::Isometry3d& T_parent_child) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  const Eigen::Vector3d p = T_parent_child.translation();
  const Eigen::Quaterniond q(T_parent_child.rotation());
  message.transform.translation.x = p.x();
  message.transform.translation.y = p.y();
  message.transform.translation.z = p.z();
  message.transform.rotation.x = q.x();
  message.transform.rotation.y = q.y();
  message.transform.rotation.z = q.z();
  message.transform.rotation.w = q.w();
  return message;
}

struct ScenePoint {
  Eigen::Vector3d p_odom;
  uint8_t truth;
};

/// A floor, a wall and a wire, and a box of leaves, apart from one another; all within the default
/// map and in range. `density` scales the 20,000 points.
inline std::vector<ScenePoint> scenePoints(uint64_t seed, double density) {
  TestRandom random(seed);
  std::vector<ScenePoint> points;
  const auto noise = [&] { return 0.005 * random.normal(); };
  const auto repeat = [&](int count, auto make) {
    for (int i = 0; i < static_cast<int>(count * density); ++i) points.push_back(make());
  };
  repeat(10000, [&] {
    const double x = random.real(-8, 8);
    const double y = random.real(-3.5, 3);
    return ScenePoint{{x, y, 0.02 + noise()}, kSurfaceLabel};
  });
  repeat(4000, [&] {
    const double x = random.real(-6, 6);
    const double z = random.real(-0.5, 1.8);
    return ScenePoint{{x, 6.5 + noise(), z}, kSurfaceLabel};
  });
  repeat(1200, [&] {
    const double x = random.real(-6, 6);
    const double y = 4.5 + noise();
    return ScenePoint{{x, y, 1.45 + noise()}, kLinearLabel};
  });
  repeat(4800, [&] {
    const double x = random.real(2, 4);
    const double y = random.real(-7, -5);
    return ScenePoint{{x, y, random.real(-0.5, 1.5)}, kScatterLabel};
  });
  return points;
}

/// Rows of points with what drivers send besides: intensity, ring, truth, and bytes of no field at
/// the ends of points and rows. `with_time` adds a time for each point, up to 40 ms after the
/// stamp, which motion compensation will use.
inline CloudBuilder scanCloud(const std::vector<Eigen::Vector3d>& p_sensor,
                              const std::vector<uint8_t>& truth, bool with_time) {
  CloudBuilder cloud;
  for (const char* name : {"x", "y", "z", "intensity"}) {
    cloud.layout.append(name, ScalarType::kFloat32);
  }
  cloud.layout.append("ring", ScalarType::kUint16);
  cloud.layout.append("truth", ScalarType::kUint8);
  if (with_time) cloud.layout.append("time", ScalarType::kFloat32);
  cloud.layout.point_step = 32;
  cloud.layout.width = static_cast<uint32_t>(p_sensor.size() / kScanRows);
  cloud.layout.height = kScanRows;
  cloud.layout.row_step = cloud.layout.width * cloud.layout.point_step + 12;
  cloud.allocate();
  for (std::size_t i = 0; i < cloud.layout.pointCount(); ++i) {
    const std::size_t row = i / cloud.layout.width;
    const std::size_t col = i % cloud.layout.width;
    cloud.set(row, col, "x", p_sensor[i].x());
    cloud.set(row, col, "y", p_sensor[i].y());
    cloud.set(row, col, "z", p_sensor[i].z());
    cloud.set(row, col, "intensity", 0.25 * static_cast<double>(i % 1000));
    cloud.set(row, col, "ring", static_cast<double>(i % 64));
    cloud.set(row, col, "truth", truth[i]);
    if (with_time) cloud.set(row, col, "time", 0.04 * static_cast<double>(i) / p_sensor.size());
  }
  return cloud;
}

inline sensor_msgs::PointCloud2 toMessage(const CloudBuilder& cloud, const ros::Time& stamp,
                                          const std::string& frame) {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.is_dense = true;
  setLayout(cloud.layout, &message);
  message.data = cloud.bytes;
  return message;
}

/// A drive: scan i is taken at `scanStamp(i)`, and transforms come at 50 Hz around it.
class Drive {
 public:
  explicit Drive(double start_s = 1000.0) : start_(start_s) {}

  ros::Time scanStamp(int i) const { return start_ + ros::Duration(i * kScanPeriod_s); }
  double secondsInto(const ros::Time& stamp) const { return (stamp - start_).toSec(); }

  CloudBuilder cloud(int i, double density = 1.0, bool with_time = false) const {
    const std::vector<ScenePoint> points = scenePoints(1000 + i, density);
    const Eigen::Isometry3d T_sensor_odom =
        (vehiclePose(i * kScanPeriod_s) * sensorMount()).inverse();
    std::vector<Eigen::Vector3d> p_sensor;
    std::vector<uint8_t> truth;
    for (const ScenePoint& point : points) {
      p_sensor.push_back(T_sensor_odom * point.p_odom);
      truth.push_back(point.truth);
    }
    return scanCloud(p_sensor, truth, with_time);
  }
  sensor_msgs::PointCloud2 scan(int i, double density = 1.0, bool with_time = false) const {
    return toMessage(cloud(i, density, with_time), scanStamp(i), kSensorFrame);
  }
  geometry_msgs::TransformStamped vehicleTransform(const ros::Time& stamp) const {
    return transformMessage(stamp, kMapFrame, kVehicleFrame, vehiclePose(secondsInto(stamp)));
  }
  /// From before scan `begin` to after scan `end - 1`; consecutive ranges share none.
  std::vector<geometry_msgs::TransformStamped> vehicleTransforms(int begin, int end) const {
    std::vector<geometry_msgs::TransformStamped> transforms;
    for (int step = 5 * begin - 2; step < 5 * end - 2; ++step) {
      transforms.push_back(
          vehicleTransform(start_ + ros::Duration(step * kScanPeriod_s / 5 + 0.003)));
    }
    return transforms;
  }

 private:
  ros::Time start_;
};

/// Values of one field, all its scalars taken together, point by point.
inline std::vector<double> fieldValues(const sensor_msgs::PointCloud2& cloud,
                                       const std::string& name) {
  const CloudLayout layout = layoutOf(cloud);
  std::vector<double> values;
  const Field* field = layout.find(name);
  const CloudView view{layout, cloud.data.data(), cloud.data.size()};
  if (field != nullptr) readScalars(view, *field, &values);
  return values;
}

}  // namespace ladar_perception::test
