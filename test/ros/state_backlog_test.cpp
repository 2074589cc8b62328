// SPDX-License-Identifier: BSD-3-Clause
// Poses that come faster than they can be registered: what waits and what is dropped is told.
#include "ros_state_client.h"
#include "ros_yard.h"

namespace ladar_perception::test {
namespace {

constexpr int kPoses = 40;

class StateBacklog : public testing::Test {
 protected:
  /// An estimate that takes its time.
  static ParamMap slow(int queue_size) {
    return {{"queue_size", queue_size}, {"max_candidates", 20}, {"restarts", 8}};
  }
  void burst(StateClient* client, int first = 0) {
    std::vector<PoseCloud> poses;
    for (int i = first; i < kPoses; ++i) poses.push_back(drive_.pose(i));
    for (const PoseCloud& pose : poses) client->send(pose);
  }
  /// Waits for the end, and looks at what was told on the way.
  bool waitForAll(StateClient* client) {
    return client->waitForStatistics(
        [&](const auto& s) {
          most_waiting_ = std::max(most_waiting_, s.poses_waiting);
          longest_ = std::max(longest_, s.backlog_s);
          return s.poses_received == kPoses && s.poses_waiting == 0;
        },
        3 * kPatience_s);
  }

  YardDrive drive_;
  uint32_t most_waiting_ = 0;
  float longest_ = 0.0F;
};

TEST_F(StateBacklog, EveryPoseOfABurstIsAdded) {
  LoadedState state("/burst", slow(100));
  ASSERT_TRUE(state.ready());
  burst(&*state);
  ASSERT_TRUE(waitForAll(&*state));
  expectAccounted(state->statistics());
  EXPECT_EQ(state->statistics().poses, static_cast<uint32_t>(kPoses));
  EXPECT_GT(most_waiting_, 5U);
  EXPECT_GT(longest_, 0.0F);
  EXPECT_GT(state->statistics().lag_max_ms, 5.0F * state->statistics().stages.back().p50_ms)
      << "the last pose of the burst waited for others";
}

TEST_F(StateBacklog, TheOldestAreDroppedAndCounted) {
  LogListener log;
  DiagnosticsListener diagnostics("delayed_state");
  LoadedState state("/overrun", slow(3));
  ASSERT_TRUE(state.ready());
  ASSERT_TRUE(log.hears("/manager"));
  ASSERT_TRUE(state->add(drive_.pose(0)));
  burst(&*state, 1);
  ASSERT_TRUE(waitForAll(&*state));
  const DelayedStateStatistics& s = state->statistics();
  expectAccounted(s);
  EXPECT_GT(countOf(s.poses_dropped, "queue_full"), 0U);
  EXPECT_EQ(countOf(s.poses_dropped, "queue_full"), sumOf(s.poses_dropped));
  EXPECT_EQ(s.poses_missing, sumOf(s.poses_dropped)) << "ids tell the same";
  EXPECT_EQ(s.header.stamp, drive_.stamp(kPoses - 1)) << "the oldest leave, the newest stay";
  EXPECT_LE(most_waiting_, 5U);
  EXPECT_TRUE(waitFor([&] { return log.count("more than queue_size 3 poses waiting") > 0; }));
  EXPECT_TRUE(waitFor([&] {
    return diagnostics.values["poses dropped: queue_full"] ==
           std::to_string(sumOf(s.poses_dropped));
  }));
}

TEST_F(StateBacklog, ServicesWaitForOnePoseNotForAll) {
  LoadedState state("/busy", slow(100));
  ASSERT_TRUE(state.ready());
  burst(&*state);
  ASSERT_TRUE(state->waitForStatistics([](const auto& s) { return s.poses >= 3; }));
  ASSERT_TRUE(state->reset());
  EXPECT_TRUE(state->waitForStatistics([](const auto& s) { return s.resets == 1; }));
  EXPECT_GT(state->statistics().poses_waiting, 0U) << "those that wait are of the new state";
  ASSERT_TRUE(waitForAll(&*state));
  EXPECT_LT(state->statistics().poses, static_cast<uint32_t>(kPoses - 2));
  expectAccounted(state->statistics());
}

TEST_F(StateBacklog, UnloadingTellsWhatIsLost) {
  LogListener log;
  {
    LoadedState state("/cut", slow(100));
    ASSERT_TRUE(state.ready());
    ASSERT_TRUE(log.hears("/manager"));
    burst(&*state);
    ASSERT_TRUE(state->waitForStatistics([](const auto& s) { return s.poses_waiting > 10; }));
  }
  EXPECT_TRUE(waitFor([&] { return log.count("poses were registered") == 1; }));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "state_backlog_test");
}
