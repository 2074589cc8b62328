// SPDX-License-Identifier: BSD-3-Clause
// The pose re-sampler's nodelet as a program of its own.
#include "pose_resampler_node.h"

#include "run_node.h"

int main(int argc, char** argv) {
  return ladar_perception::runNode<ladar_perception::PoseResamplerNode>(argc, argv,
                                                                        "pose_resampler");
}
