// SPDX-License-Identifier: BSD-3-Clause
// The terrain nodelet as a program of its own.
#include "terrain_node.h"

#include "run_node.h"

int main(int argc, char** argv) {
  return ladar_perception::runNode<ladar_perception::TerrainNode>(argc, argv, "terrain");
}
