// SPDX-License-Identifier: BSD-3-Clause
// The terrain nodelet as a program of its own.
#include "terrain_node.h"

#include <ros/ros.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "terrain");
  // Beside the node: ROS shuts down with the last handle, and then the report below is not heard.
  const ros::NodeHandle handle;
  const ros::NodeHandle private_handle("~");
  try {
    ladar_perception::TerrainNode node(handle, private_handle);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
