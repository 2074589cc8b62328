// SPDX-License-Identifier: BSD-3-Clause
#include <pluginlib/class_list_macros.hpp>

#include "delayed_state_node.h"
#include "nodelet_of.h"

namespace ladar_perception {

class DelayedStateNodelet : public NodeletOf<DelayedStateNode> {};

}  // namespace ladar_perception

PLUGINLIB_EXPORT_CLASS(ladar_perception::DelayedStateNodelet, nodelet::Nodelet)
