// SPDX-License-Identifier: BSD-3-Clause
// The terrain nodelet as a program of its own.
#include "terrain_node.h"

#include <ros/ros.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "terrain");
  try {
    ladar_perception::TerrainNode node(ros::NodeHandle(), ros::NodeHandle("~"));
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}
