// SPDX-License-Identifier: BSD-3-Clause
#include "ros_pose_client.h"
#include "ros_zero_copy.h"

namespace ladar_perception::test {
namespace {

TEST(PoseZeroCopy, MessagesPassByPointer) {
  setTestParameters<PoseClient>("/poses");
  nodelet::Loader manager(false);
  PoseClient client("/poses");
  ASSERT_TRUE(manager.load("/poses", PoseClient::kNodelet, {}, {}));
  ASSERT_TRUE(client.connected());
  const Drive drive;
  // While it waits for tf, the nodelet holds the very message that was published.
  expectPassesByPointer("points", drive.scan(0, 0.25), [&](const ros::Publisher&) {
    client.sendMount();
    client.send(drive.vehicleTransforms(0, 1));
    return waitFor([&] { return client.poses.size() == 1 && client.clouds.size() == 1; });
  });
  EXPECT_TRUE(manager.unload("/poses"));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_zero_copy_test");
}
