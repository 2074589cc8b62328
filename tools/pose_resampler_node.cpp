// SPDX-License-Identifier: BSD-3-Clause
// The pose re-sampler's nodelet as a program of its own.
#include "pose_resampler_node.h"

#include <ros/ros.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "pose_resampler");
  // Beside the node: ROS shuts down with the last handle, and then the report below is not heard.
  const ros::NodeHandle handle;
  const ros::NodeHandle private_handle("~");
  try {
    ladar_perception::PoseResamplerNode node(handle, private_handle);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
