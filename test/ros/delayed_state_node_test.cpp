// SPDX-License-Identifier: BSD-3-Clause
#include "ros_state_cases.h"

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "delayed_state_node_test");
}
