// SPDX-License-Identifier: BSD-3-Clause
#include <pluginlib/class_list_macros.hpp>

#include "nodelet_of.h"
#include "terrain_node.h"

namespace ladar_perception {

class TerrainNodelet : public NodeletOf<TerrainNode> {};

}  // namespace ladar_perception

PLUGINLIB_EXPORT_CLASS(ladar_perception::TerrainNodelet, nodelet::Nodelet)
