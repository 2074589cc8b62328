// SPDX-License-Identifier: BSD-3-Clause
// Inside a manager messages pass by pointer. The test's own process is the manager here.
#include <boost/make_shared.hpp>
#include <nodelet/loader.h>

#include "ros_terrain_client.h"

namespace ladar_perception::test {
namespace {

TEST(ZeroCopy, MessagesPassByPointer) {
  setTestParameters("/terrain");
  nodelet::Loader manager(false);
  TerrainClient client("/terrain");
  ASSERT_TRUE(manager.load("/terrain", "ladar_perception/TerrainNodelet", {}, {}));
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
  ASSERT_TRUE(waitFor([&] { return client.labeled.size() == 1 && client.maps.size() == 1; }));
  EXPECT_TRUE(waitFor([&] { return scan.use_count() == 1; })) << "it is let go of";
  EXPECT_TRUE(before.data == scan->data) << "others hold the same message: it must not change";
  EXPECT_GT(recallOf(*client.labeled[0], kSurfaceLabel), 0.9);

  // The map is latched: its publisher keeps the very message that came here.
  EXPECT_GT(client.maps[0].use_count(), 1);
  EXPECT_TRUE(manager.unload("/terrain"));
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "zero_copy_test");
}
