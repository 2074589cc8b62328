// SPDX-License-Identifier: BSD-3-Clause
// Inside a manager messages pass by pointer. The test's own process is the manager here.
#include <nodelet/loader.h>

#include <boost/make_shared.hpp>

#include "ros_pose_client.h"

namespace ladar_perception::test {
namespace {

TEST(PoseZeroCopy, MessagesPassByPointer) {
  setTestPoseParameters("/poses");
  nodelet::Loader manager(false);
  PoseClient client("/poses");
  ASSERT_TRUE(manager.load("/poses", kPoseNodelet, {}, {}));
  ASSERT_TRUE(client.connected());
  ros::Publisher points = ros::NodeHandle().advertise<sensor_msgs::PointCloud2>("points", 1);
  const Drive drive;
  auto scan = boost::make_shared<sensor_msgs::PointCloud2>(drive.scan(0, 0.25));
  const sensor_msgs::PointCloud2 before = *scan;
  points.publish(scan);

  // While it waits for tf, the nodelet holds the very message that was published.
  EXPECT_TRUE(waitFor([&] { return scan.use_count() > 1; }, 3.0));
  client.sendMount();
  client.send(drive.vehicleTransforms(0, 1));
  ASSERT_TRUE(waitFor([&] { return client.poses.size() == 1 && client.clouds.size() == 1; }));
  EXPECT_TRUE(waitFor([&] { return scan.use_count() == 1; })) << "it is let go of";
  EXPECT_TRUE(before.data == scan->data) << "others hold the same message: it must not change";
  EXPECT_TRUE(manager.unload("/poses"));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_zero_copy_test");
}
