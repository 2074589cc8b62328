// SPDX-License-Identifier: BSD-3-Clause
#include "ros_bad_parameters.h"
#include "ros_state_client.h"
#include "ros_yard.h"

namespace ladar_perception::test {
namespace {

std::vector<BadStart> badStarts() {
  using std::string;
  return {
      {"several",
       {{"gate_chi", 3.0},
        {"threads", 0},
        {"window_poses", 10.5},
        {"solver", string("quick")},
        {"map_frame", string("/map")},
        {"publish_tf", 1},
        {"queue_size", 0},
        {"time_jump", string("panic")},
        {"map_rate_hz", 11.0}},
       {"9 bad parameters", "gate_chi", "did you mean 'gate_chi2'", "threads: 0", "window_poses",
        "10.5", "solver: 'quick'", "map_frame", "slash", "publish_tf", "queue_size: 0",
        "time_jump: 'panic'", "map_rate_hz", "[0, 10]"}},
      {"contradiction", {{"loop_hops", 50}}, {"1 bad parameter", "loop_hops: 50", "window_poses"}},
      {"one_frame",
       {{"map_frame", string("odom")}},
       {"1 bad parameter", "map_frame: 'odom' is odom_frame"}},
      {"no_frame", {{"odom_frame", string()}}, {"1 bad parameter", "odom_frame", "empty"}},
  };
}

TEST(StateBadParameters, TheNodeEndsWithAReport) {
  expectProgramRefuses<StateClient>("delayed_state_node", badStarts());
}

TEST(StateBadParameters, TheNodeletIsNotLoadedAndTheManagerGoesOn) {
  expectManagerRefuses<StateClient>(badStarts());
  LoadedState good("/good");
  ASSERT_TRUE(good.ready());
  EXPECT_TRUE(good->add(YardDrive().pose(0)));
}

TEST(StateBadParameters, WhatIsSwitchedOffIsNotThere) {
  LoadedState quiet("/quiet", {{"publish_tf", false}});
  ASSERT_TRUE(quiet.ready());
  ASSERT_TRUE(quiet->add(YardDrive().pose(0)));
  waitFor([] { return false; }, 0.5);
  EXPECT_TRUE(quiet->transforms.empty());
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "state_bad_parameters_test");
}
