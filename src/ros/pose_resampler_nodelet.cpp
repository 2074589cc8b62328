// SPDX-License-Identifier: BSD-3-Clause
#include <pluginlib/class_list_macros.hpp>

#include "nodelet_of.h"
#include "pose_resampler_node.h"

namespace ladar_perception {

class PoseResamplerNodelet : public NodeletOf<PoseResamplerNode> {};

}  // namespace ladar_perception

PLUGINLIB_EXPORT_CLASS(ladar_perception::PoseResamplerNodelet, nodelet::Nodelet)
