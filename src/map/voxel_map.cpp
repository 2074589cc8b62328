// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {

template class BasicVoxelMap<Moments>;

}  // namespace ladar_perception
