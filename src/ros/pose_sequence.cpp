// SPDX-License-Identifier: BSD-3-Clause
#include "pose_sequence.h"

#include <cstdio>

namespace ladar_perception {

std::string PoseSequence::describeLast() const {
  char stamp[32];
  std::snprintf(stamp, sizeof(stamp), "%.3f s", last_stamp_.toSec());
  const std::string whose = last_id_ ? "id " + std::to_string(*last_id_) : "the loaded state's";
  return whose + " at " + stamp;
}

}  // namespace ladar_perception
