// SPDX-License-Identifier: BSD-3-Clause
#include "ros_terrain_client.h"
#include "ros_zero_copy.h"

namespace ladar_perception::test {
namespace {

TEST(ZeroCopy, MessagesPassByPointer) {
  setTestParameters<TerrainClient>("/terrain");
  nodelet::Loader manager(false);
  TerrainClient client("/terrain");
  ASSERT_TRUE(manager.load("/terrain", TerrainClient::kNodelet, {}, {}));
  ASSERT_TRUE(client.connected());
  const Drive drive;
  // While it waits for tf, the nodelet holds the very message that was published.
  expectPassesByPointer("points", drive.scan(0, 0.25), [&](const ros::Publisher&) {
    client.sendMount();
    client.send(drive.vehicleTransforms(0, 1));
    return waitFor([&] { return client.labeled.size() == 1 && client.maps.size() == 1; });
  });
  ASSERT_EQ(client.maps.size(), 1U);
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
