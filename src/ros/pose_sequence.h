// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <cstdint>
#include <optional>
#include <string>

namespace ladar_perception {

/// Where a pose stands in the sequence of those that came before.
enum class PosePlace {
  kNext,
  kRestarted,   ///< next, but ids count from a lower number again: another re-sampler's first
  kTimeJump,    ///< a higher id with an earlier stamp: time was set back
  kDuplicate,   ///< id or stamp of the pose before
  kOutOfOrder,  ///< both id and stamp lie before those of the pose before
};

/// Follows the ids and stamps of the poses of one state.
class PoseSequence {
 public:
  /// Begins anew after a pose of this stamp, of a state that was loaded; nothing is known of ids.
  void beginAfter(const ros::Time& newest) {
    last_id_.reset();
    last_stamp_ = newest;
  }
  void begin() { beginAfter(ros::Time()); }

  PosePlace placeOf(uint64_t id, const ros::Time& stamp) const {
    if (last_id_ && id == *last_id_) return PosePlace::kDuplicate;
    if (last_id_ && stamp == last_stamp_) return PosePlace::kDuplicate;
    // The first pose after a load tells of no jump: nothing came before it.
    if (stamp <= last_stamp_) {
      return last_id_ && id > *last_id_ ? PosePlace::kTimeJump : PosePlace::kOutOfOrder;
    }
    return last_id_ && id < *last_id_ ? PosePlace::kRestarted : PosePlace::kNext;
  }
  /// Goes on to a pose; returns how many ids were left out before it.
  uint64_t advance(uint64_t id, const ros::Time& stamp) {
    const uint64_t missing = last_id_ && id > *last_id_ ? id - *last_id_ - 1 : 0;
    last_id_ = id;
    last_stamp_ = stamp;
    return missing;
  }
  /// "id 7 at 12.300 s" or, of a state that was loaded, "the loaded state's at 12.300 s".
  std::string describeLast() const;

 private:
  std::optional<uint64_t> last_id_;
  ros::Time last_stamp_;
};

}  // namespace ladar_perception
