// SPDX-License-Identifier: BSD-3-Clause
#include "state_drop.h"

namespace ladar_perception {

const char* stateDropName(StateDrop reason) {
  switch (reason) {
    case StateDrop::kEmpty:
      return "empty";
    case StateDrop::kBadCloud:
      return "bad_cloud";
    case StateDrop::kBadPose:
      return "bad_pose";
    case StateDrop::kNoStamp:
      return "no_stamp";
    case StateDrop::kOtherFrame:
      return "other_frame";
    case StateDrop::kDuplicate:
      return "duplicate";
    case StateDrop::kOutOfOrder:
      return "out_of_order";
    case StateDrop::kQueueFull:
      return "queue_full";
    case StateDrop::kError:
      return "error";
  }
  return "";
}

}  // namespace ladar_perception
