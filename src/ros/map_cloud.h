// SPDX-License-Identifier: BSD-3-Clause
// All samples of a delayed state, where its poses are now.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"
#include "ladar_perception/slam/delayed_state.h"

namespace ladar_perception {

struct MapCloud {
  /// x y z normal_x normal_y normal_z (float32), rgb (uint32) and label (uint8) if any pose has
  /// them, pose (uint32, the index); one row.
  CloudLayout layout;
  std::vector<uint8_t> bytes;
};

/// In the map frame; of every pose the first `samples_per_pose`, 0 for all.
MapCloud makeMapCloud(const std::vector<StatePose>& poses, const PoseGraph& graph,
                      std::size_t samples_per_pose);

}  // namespace ladar_perception
