// SPDX-License-Identifier: BSD-3-Clause
#include "ros_state_client.h"
#include "ros_yard.h"
#include "ros_zero_copy.h"

namespace ladar_perception::test {
namespace {

TEST(StateZeroCopy, MessagesPassByPointer) {
  setTestParameters<StateClient>("/delayed_state");
  nodelet::Loader manager(false);
  StateClient client("/delayed_state");
  ASSERT_TRUE(manager.load("/delayed_state", StateClient::kNodelet, {}, {}));
  ASSERT_TRUE(client.connected());
  const YardDrive drive;
  constexpr int kBefore = 20;
  // While poses before it are registered, the nodelet holds the very message that was published.
  for (int i = 0; i < kBefore; ++i) client.send(drive.pose(i));
  expectPassesByPointer("pose_cloud", drive.pose(kBefore), [&](const ros::Publisher&) {
    return client.waitForStatistics([](const auto& s) { return s.poses == kBefore + 1; });
  });
  EXPECT_TRUE(manager.unload("/delayed_state"));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "state_zero_copy_test");
}
