// SPDX-License-Identifier: BSD-3-Clause
// replay.launch plays a bag through the nodelet, once and in a loop.
#include "ros_process.h"
#include "ros_terrain_client.h"
#include "ros_test_bag.h"

namespace ladar_perception::test {
namespace {

constexpr int kScans = 20;  // 2 s

class Replay : public testing::Test {
 protected:
  void SetUp() override { writeDriveBag(Drive(), kScans, 0.25, bag_); }

  std::vector<std::string> command(const std::vector<std::string>& arguments) {
    std::vector<std::string> words = {"roslaunch", "ladar_perception", "replay.launch",
                                      "bag:=" + bag_, "rviz:=false", "config:=" + kTestConfig,
                                      "model:=" + kTestModel};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return words;
  }

  TemporaryFolder folder_;
  std::string bag_ = folder_.file("drive.bag");
  std::string output_ = folder_.file("roslaunch.txt");
};

TEST_F(Replay, EveryScanOfTheBagIsLabelled) {
  TerrainClient client("/terrain");
  // The delay is for the nodelet to load, on a busy machine too.
  ChildProcess launch(command({"rate:=2", "delay:=4"}), output_);
  EXPECT_TRUE(waitFor([&] {
    const TerrainStatistics& now = client.statistics;
    return now.scans + sumOf(now.scans_dropped) >= kScans || !launch.running();
  })) << textOf(output_);
  EXPECT_TRUE(launch.running()) << textOf(output_);
  const TerrainStatistics& s = client.statistics;
  EXPECT_EQ(s.scans, static_cast<uint64_t>(kScans));
  EXPECT_EQ(sumOf(s.scans_dropped), 0U);
  EXPECT_EQ(s.points_in, s.points_inserted + sumOf(s.points_dropped));
  EXPECT_EQ(s.resets, 0U);
  bool sim_time = false;
  EXPECT_TRUE(ros::param::get("/use_sim_time", sim_time) && sim_time);
  ASSERT_FALSE(client.labeled.empty());
  EXPECT_GT(recallOf(*client.labeled.back(), kSurfaceLabel), 0.9);
  EXPECT_FALSE(client.maps.empty());
}

TEST_F(Replay, EveryTurnOfALoopResetsOnce) {
  LogListener log;
  TerrainClient client("/terrain");
  ChildProcess launch(command({"rate:=4", "delay:=4", "loop:=true"}), output_);
  const auto turns = [&] {
    uint32_t count = 0;
    for (std::size_t i = 1; i < client.labeled.size(); ++i) {
      count += client.labeled[i]->header.stamp < client.labeled[i - 1]->header.stamp ? 1 : 0;
    }
    return count;
  };
  // Between two turns all three agree: the jumps there were, those counted and those said.
  bool agree = false;
  waitFor([&] {
    const uint32_t seen = turns();
    agree = seen >= 2 && client.statistics.resets == seen &&
            log.count("jumped back") == static_cast<int>(seen);
    return agree || !launch.running();
  });
  EXPECT_TRUE(agree) << turns() << " turns, " << client.statistics.resets << " resets, "
                     << log.count("jumped back") << " warnings\n" << textOf(output_);
  // A few scans at the seams at most have no transform.
  const TerrainStatistics& s = client.statistics;
  EXPECT_GT(s.scans, 2U * (kScans - 3));
  ASSERT_FALSE(client.labeled.empty());
  EXPECT_GT(recallOf(*client.labeled.back(), kSurfaceLabel), 0.9);
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "replay_test");
}
