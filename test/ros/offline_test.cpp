// SPDX-License-Identifier: BSD-3-Clause
// classify_bag says of a bag what the nodelet says of its messages, bit by bit, for any threads.
#include <cstdio>

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <yaml-cpp/yaml.h>

#include "ros_process.h"
#include "ros_terrain_client.h"
#include "ros_test_bag.h"

namespace ladar_perception::test {
namespace {

constexpr int kScans = 8;
using Clouds = std::vector<sensor_msgs::PointCloud2ConstPtr>;

struct OfflineRun {
  Clouds labeled;
  Clouds maps;
  YAML::Node metrics;  // JSON is YAML
};

Clouds cloudsOf(const rosbag::Bag& bag, const std::string& topic) {
  Clouds clouds;
  rosbag::View view(bag, rosbag::TopicQuery(topic));
  for (const rosbag::MessageInstance& message : view) {
    clouds.push_back(message.instantiate<sensor_msgs::PointCloud2>());
  }
  return clouds;
}

void expectEqual(const Clouds& a, const Clouds& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    SCOPED_TRACE("message " + std::to_string(i));
    EXPECT_EQ(a[i]->header.stamp, b[i]->header.stamp);
    EXPECT_EQ(a[i]->header.frame_id, b[i]->header.frame_id);
    EXPECT_EQ(a[i]->width, b[i]->width);
    EXPECT_EQ(a[i]->height, b[i]->height);
    EXPECT_EQ(a[i]->is_dense, b[i]->is_dense);
    EXPECT_EQ(layoutOf(*a[i]).describeFields(), layoutOf(*b[i]).describeFields());
    EXPECT_TRUE(a[i]->data == b[i]->data) << "the bytes differ";
  }
}

class Offline : public testing::Test {
 protected:
  void SetUp() override { writeDriveBag(drive_, kScans, 0.5, input_); }

  OfflineRun classify(int threads) {
    const std::string output = folder_.file("out.bag");
    const std::string metrics = folder_.file("metrics.json");
    const std::string log = folder_.file("log.txt");
    ChildProcess program({programPath("classify_bag"), input_, "--out", output, "--metrics",
                          metrics, "--config", kTestConfig, "--model", kTestModel, "--threads",
                          std::to_string(threads)},
                         log);
    EXPECT_TRUE(waitFor([&] { return !program.running(); }));
    EXPECT_EQ(program.exitCode(), 0) << textOf(log);
    OfflineRun run;
    rosbag::Bag bag(output);
    run.labeled = cloudsOf(bag, "/labeled_points");
    run.maps = cloudsOf(bag, "/labeled_map");
    run.metrics = YAML::LoadFile(metrics);
    return run;
  }

  /// Sends the messages of the bag, one scan at a time.
  void play(TerrainClient* client) {
    client->sendMount();
    rosbag::Bag bag(input_);
    for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
      if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
        if (message.getTopic() == "/tf") client->send(transforms->transforms);
      } else if (const auto scan = message.instantiate<sensor_msgs::PointCloud2>()) {
        ASSERT_TRUE(client->label(*scan));
      }
    }
  }

  TemporaryFolder folder_;
  std::string input_ = folder_.file("in.bag");
  Drive drive_;
};

TEST_F(Offline, GivesTheNodeletsResult) {
  const OfflineRun one = classify(1);
  ASSERT_EQ(one.labeled.size(), static_cast<std::size_t>(kScans));
  ASSERT_EQ(one.metrics["scans"].as<int>(), kScans);
  // The scene is labelled, so that equal results are not equally empty ones.
  EXPECT_GT(recallOf(*one.labeled.back(), kScatterLabel), 0.7);
  EXPECT_GT(recallOf(*one.labeled.back(), kSurfaceLabel), 0.9);
  {
    SCOPED_TRACE("one thread and two");
    const OfflineRun two = classify(2);
    EXPECT_EQ(one.metrics["label_hash"].as<std::string>(),
              two.metrics["label_hash"].as<std::string>());
    expectEqual(one.labeled, two.labeled);
    expectEqual(one.maps, two.maps);
  }
  {
    SCOPED_TRACE("a run and the next");
    const OfflineRun again = classify(1);
    EXPECT_EQ(one.metrics["label_hash"].as<std::string>(),
              again.metrics["label_hash"].as<std::string>());
  }
  for (const int threads : {1, 2}) {
    SCOPED_TRACE("nodelet of threads: " + std::to_string(threads));
    LoadedTerrain terrain("/offline_" + std::to_string(threads),
                          {{"threads", threads}, {"queue_size", 100}});
    ASSERT_TRUE(terrain.ready());
    play(&*terrain);
    expectEqual(one.labeled, terrain->labeled);
    ASSERT_TRUE(waitFor([&] { return terrain->maps.size() >= one.maps.size(); }));
    expectEqual(one.maps, terrain->maps);
    ASSERT_TRUE(terrain->waitForStatistics([](const auto& s) { return s.scans == kScans; }));
    const TerrainStatistics& s = terrain->statistics;
    EXPECT_EQ(s.points_in, one.metrics["points_in"].as<uint64_t>());
    EXPECT_EQ(s.points_inserted, one.metrics["points_inserted"].as<uint64_t>());
    for (const DropCount& drop : s.points_dropped) {
      EXPECT_EQ(drop.count, one.metrics["dropped"][drop.reason].as<uint64_t>()) << drop.reason;
    }
    EXPECT_GT(countOf(s.points_dropped, "not_finite"), 0U);
  }
}

TEST_F(Offline, KeepsTheOtherMessages) {
  const OfflineRun run = classify(1);
  rosbag::Bag in(input_);
  rosbag::Bag out(folder_.file("out.bag"));
  for (const char* topic : {"/tf", "/tf_static"}) {
    rosbag::View in_view(in, rosbag::TopicQuery(std::string(topic)));
    rosbag::View out_view(out, rosbag::TopicQuery(std::string(topic)));
    EXPECT_GT(out_view.size(), 0U) << topic;
    EXPECT_EQ(in_view.size(), out_view.size()) << topic;
  }
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "offline_test");
}
