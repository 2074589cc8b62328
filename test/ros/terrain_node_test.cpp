// SPDX-License-Identifier: BSD-3-Clause
#include "ros_terrain_cases.h"

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "terrain_node_test");
}
