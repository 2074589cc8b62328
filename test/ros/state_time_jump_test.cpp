// SPDX-License-Identifier: BSD-3-Clause
// Time that jumps back, as with a bag that loops, and states that are continued.
#include <rosgraph_msgs/Clock.h>

#include "ros_process.h"
#include "ros_state_client.h"
#include "ros_yard.h"

namespace ladar_perception::test {
namespace {

constexpr int kTurn = 5;  // poses

class StateTimeJump : public testing::Test {
 protected:
  StateTimeJump() { clock_ = ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", 100); }

  /// One turn of a loop: ids go on counting, as the re-sampler's do. How many were added.
  int play(StateClient* client, int turn) {
    int added = 0;
    for (int i = 0; i < kTurn; ++i) {
      rosgraph_msgs::Clock clock;
      clock.clock = drive_.stamp(i);
      clock_.publish(clock);
      PoseCloud pose = drive_.pose(i);
      pose.id += static_cast<uint64_t>(turn * kTurn);
      added += client->add(pose) ? 1 : 0;
    }
    return added;
  }

  YardDrive drive_;
  ros::Publisher clock_;
};

TEST_F(StateTimeJump, EveryTurnBeginsAState) {
  LogListener log;
  LoadedState state("/looped");
  ASSERT_TRUE(state.ready());
  ASSERT_TRUE(log.hears("/manager"));
  for (int turn = 0; turn < 3; ++turn) {
    EXPECT_EQ(play(&*state, turn), kTurn);
    EXPECT_EQ(state->statistics().poses, static_cast<uint32_t>(kTurn));
    EXPECT_EQ(state->statistics().resets, static_cast<uint32_t>(turn));
    EXPECT_TRUE(waitFor([&] { return log.count("jumped back") == turn; }));
    EXPECT_TRUE(waitFor([&] { return state->path().poses.size() == kTurn; }));
  }
  EXPECT_NE(log.find("jumped back").find("to 1000.000 s"), std::string::npos);
  EXPECT_NE(log.find("jumped back").find("forgot 5 poses"), std::string::npos);
  expectAccounted(state->statistics());
}

TEST_F(StateTimeJump, TfFollowsTheClockBack) {
  LoadedState state("/back");
  ASSERT_TRUE(state.ready());
  for (int turn = 0; turn < 2; ++turn) {
    EXPECT_EQ(play(&*state, turn), kTurn);
    state->transforms.clear();
    ASSERT_TRUE(waitFor([&] { return state->transforms.size() > 2; })) << "though the clock stands";
    for (const auto& transform : state->transforms) {
      EXPECT_GE(transform.header.stamp, drive_.stamp(kTurn - 1));
      EXPECT_LT(transform.header.stamp, drive_.stamp(kTurn - 1) + ros::Duration(1.0));
    }
  }
}

TEST_F(StateTimeJump, ItMayBeRefused) {
  LogListener log;
  LoadedState state("/refused", {{"time_jump", std::string("refuse")}});
  ASSERT_TRUE(state.ready());
  ASSERT_TRUE(log.hears("/manager"));
  EXPECT_EQ(play(&*state, 0), kTurn);
  EXPECT_EQ(play(&*state, 1), 0) << "even the last has the stamp of one that is there";
  EXPECT_EQ(countOf(state->statistics().poses_dropped, "out_of_order"), kTurn - 1U);
  EXPECT_EQ(countOf(state->statistics().poses_dropped, "duplicate"), 1U);
  EXPECT_EQ(state->statistics().resets, 0U);
  EXPECT_TRUE(waitFor([&] { return log.count("~reset begins a new state") > 0; }));
}

TEST_F(StateTimeJump, PosesBeforeALoadedStateAreRefusedAndOnesAfterGoOn) {
  TemporaryFolder folder;
  const std::string half = folder.file("half.bin");
  const std::string whole = folder.file("whole.bin");
  const std::string continued = folder.file("continued.bin");
  LoadedState first("/first");
  ASSERT_TRUE(first.ready());
  EXPECT_EQ(play(&*first, 0), kTurn);
  ASSERT_TRUE(first->save(half));
  LoadedState second("/second");
  ASSERT_TRUE(second.ready());
  ASSERT_TRUE(second->load(half));
  EXPECT_EQ(play(&*second, 1), 0) << "a state that was loaded is not lost to an old bag";
  EXPECT_EQ(second->statistics().poses, static_cast<uint32_t>(kTurn));
  for (int i = kTurn; i < 2 * kTurn; ++i) {
    EXPECT_TRUE(first->add(drive_.pose(i)));
    EXPECT_TRUE(second->add(drive_.pose(i)));
  }
  ASSERT_TRUE(first->save(whole));
  ASSERT_TRUE(second->save(continued));
  EXPECT_TRUE(textOf(whole) == textOf(continued)) << "the break changed bits";
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "state_time_jump_test");
}
