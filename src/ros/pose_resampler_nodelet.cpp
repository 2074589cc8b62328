// SPDX-License-Identifier: BSD-3-Clause
#include <nodelet/nodelet.h>

#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "pose_resampler_node.h"

namespace ladar_perception {

class PoseResamplerNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    try {
      node_ = std::make_unique<PoseResamplerNode>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      // The manager reports that loading failed, but not why: what() is lost on the way.
      NODELET_FATAL("%s", error.what());
      throw;
    }
  }

  std::unique_ptr<PoseResamplerNode> node_;
};

}  // namespace ladar_perception

PLUGINLIB_EXPORT_CLASS(ladar_perception::PoseResamplerNodelet, nodelet::Nodelet)
