// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ladar_perception {

/// Why a pose did not become part of the delayed state.
enum class StateDrop {
  kEmpty,       ///< no samples
  kBadCloud,    ///< a field is missing or not finite
  kBadPose,     ///< not finite, or no rotation
  kNoStamp,     ///< stamp 0
  kOtherFrame,  ///< in another frame than the one configured, or of another vehicle frame
  kDuplicate,   ///< its id or its stamp is that of the pose before
  kOutOfOrder,  ///< its stamp is before that of the newest pose
  kQueueFull,   ///< newer poses came faster than they could be registered
  kError,       ///< an exception, out of memory for example
};
constexpr int kStateDrops = 9;
const char* stateDropName(StateDrop reason);

}  // namespace ladar_perception
