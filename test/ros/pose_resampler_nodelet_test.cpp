// SPDX-License-Identifier: BSD-3-Clause
#include "ros_pose_cases.h"

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_resampler_nodelet_test");
}
