// SPDX-License-Identifier: BSD-3-Clause
// The delayed-state estimate's nodelet as a program of its own.
#include "delayed_state_node.h"

#include "run_node.h"

int main(int argc, char** argv) {
  return ladar_perception::runNode<ladar_perception::DelayedStateNode>(argc, argv, "delayed_state");
}
