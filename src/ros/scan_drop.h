// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <cstdint>

namespace ladar_perception {

/// Why a whole scan was not used.
enum class ScanDrop {
  kEmpty,        ///< no points
  kBadCloud,     ///< no readable x y z, or nothing in them that can be used
  kNoStamp,      ///< stamp 0: nothing tells where the sensor was
  kNoTransform,  ///< tf did not have the poses in time
  kBadPose,      ///< a pose is not finite or farther out than a map can index
  kQueueFull,    ///< newer scans came faster than they could be processed
  kError,        ///< an exception, out of memory for example
};
constexpr int kScanDrops = 7;
const char* scanDropName(ScanDrop reason);

/// Points that came with a scan. A header can claim any size; what did not come is not lost.
uint64_t pointsReceived(const sensor_msgs::PointCloud2& scan);

}  // namespace ladar_perception
