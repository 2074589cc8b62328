// SPDX-License-Identifier: BSD-3-Clause
#include "scan_drop.h"

#include <algorithm>

namespace ladar_perception {

const char* scanDropName(ScanDrop reason) {
  switch (reason) {
    case ScanDrop::kEmpty:
      return "empty";
    case ScanDrop::kBadCloud:
      return "bad_cloud";
    case ScanDrop::kNoStamp:
      return "no_stamp";
    case ScanDrop::kNoTransform:
      return "no_transform";
    case ScanDrop::kBadPose:
      return "bad_pose";
    case ScanDrop::kQueueFull:
      return "queue_full";
    case ScanDrop::kError:
      return "error";
  }
  return "";
}

uint64_t pointsReceived(const sensor_msgs::PointCloud2& scan) {
  const uint64_t room = scan.point_step > 0 ? scan.data.size() / scan.point_step : 0;
  return std::min(uint64_t{scan.width} * scan.height, room);
}

}  // namespace ladar_perception
