// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

#include <string>

namespace ladar_perception {

/// main() of the program that is a nodelet's node.
template <typename Node>
int runNode(int argc, char** argv, const std::string& name) {
  ros::init(argc, argv, name);
  // Beside the node: ROS shuts down with the last handle, and then the report below is not heard.
  const ros::NodeHandle handle;
  const ros::NodeHandle private_handle("~");
  try {
    Node node(handle, private_handle);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
  return 0;
}

}  // namespace ladar_perception
