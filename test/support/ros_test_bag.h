// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <utility>

#include "ros_scene.h"
#include "scan_bag_writer.h"

namespace ladar_perception::test {

/// Scans are recorded this long after their stamp, when the last point is in.
constexpr double kRecordDelay_s = 0.05;

/// Records a drive of `scans` scans as a vehicle would: static transforms first, then everything by
/// the time it was sent. Points have times; every 50th is NaN, which a cloud may have.
inline void writeDriveBag(const Drive& drive, int scans, double density, const std::string& path) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  ScanBagWriter bag(path, "/points");
  const auto transforms = drive.vehicleTransforms(0, scans);
  bag.writeStaticTransform(transforms.front().header.stamp, kVehicleFrame, kSensorFrame,
                           sensorMount());
  std::size_t next = 0;
  const auto writeTransformsUntil = [&](const ros::Time& time) {
    for (; next < transforms.size() && transforms[next].header.stamp <= time; ++next) {
      const ros::Time& stamp = transforms[next].header.stamp;
      bag.writeTransform(stamp, kMapFrame, kVehicleFrame, vehiclePose(drive.secondsInto(stamp)));
    }
  };
  for (int i = 0; i < scans; ++i) {
    const ros::Time recorded = drive.scanStamp(i) + ros::Duration(kRecordDelay_s);
    writeTransformsUntil(recorded);
    CloudBuilder cloud = drive.cloud(i, density, true);
    for (std::size_t col = 0; col < cloud.layout.width; col += 50) cloud.set(0, col, "x", kNaN);
    bag.writeCloud(drive.scanStamp(i), recorded, kSensorFrame, cloud.layout, std::move(cloud.bytes),
                   false);
  }
  bag.close();
}

}  // namespace ladar_perception::test
