// SPDX-License-Identifier: BSD-3-Clause
// What classify_bag says of bags, models and configurations it cannot use, and of odd ones it can.
#include <algorithm>

#include "program_classify_bag.h"

namespace ladar_perception::test {
namespace {

using ClassifyBagInput = ClassifyBag;

TEST_F(ClassifyBagInput, RefusesAModelThatDoesNotFit) {
  const std::string config = folder_.write("coarse.yaml", "voxel_size_m: 0.2\n");
  expectFailure(classify(forest(), {"--config", config}),
                {"starter.yaml", "does not fit", "0.1", "0.2"});
  const std::string wide = folder_.write("wide.yaml", "support_radius_voxels: 3\n");
  expectFailure(classify(forest(), {"--config", wide}),
                {"starter.yaml", "does not fit", "voxels 6", "has 3"});
  EXPECT_EQ(folder_.list(), "coarse.yaml wide.yaml");
}

TEST_F(ClassifyBagInput, RefusesABadModel) {
  const std::string missing = folder_.file("missing.yaml");
  expectFailure(classify(forest(), {"--model", missing}), {missing});
  expectFailure(classify(forest(), {"--model", "package://no_such_package/a.yaml"}),
                {"classify_bag: package://no_such_package", "not found"}, 3);  // rospack speaks too
  const std::string text = folder_.write("text.yaml", "format: something/else\n");
  expectFailure(classify(forest(), {"--model", text}), {text});
  EXPECT_EQ(folder_.list(), "text.yaml");
}

TEST_F(ClassifyBagInput, NamesWhatIsWrongInTheConfiguration) {
  const auto with = [&](const std::string& text) {
    return classify(forest(), {"--config", folder_.write("typo.yaml", text)});
  };
  expectFailure(with("voxel_size: 0.1\n"),
                {"typo.yaml", "voxel_size", "did you mean 'voxel_size_m'"}, 2);
  expectFailure(with("map_rate_hz: -1\nthreads: 1.5\nmap_frame: 3\n"),
                {"typo.yaml", "map_rate_hz", "threads", "map_frame"}, 4);
  expectFailure(with("- a list\n"), {"typo.yaml", "map of parameters"});
  expectFailure(with("threads: [1\n"), {"typo.yaml:2"});
  expectFailure(classify(forest(), {"--config", folder_.file("none.yaml")}), {"none.yaml"});
  expectFailure(classify(forest(), {"--threads", "0"}), {"--threads", "0"});
  EXPECT_EQ(folder_.list(), "typo.yaml");
}

TEST_F(ClassifyBagInput, NeedsATopic) {
  const std::string no_clouds =
      editedBag(forest(), folder_.file("no_clouds.bag"), [](const auto& message, rosbag::Bag* to) {
        if (message.getTopic() != "/points") writeAsItIs(message, to);
      });
  expectFailure(classify(no_clouds), {no_clouds, "sensor_msgs/PointCloud2"});

  const std::string two =
      editedBag(forest(), folder_.file("two.bag"), [](const auto& message, rosbag::Bag* to) {
        writeAsItIs(message, to);
        if (message.getTopic() == "/points") to->write("/rear/points", message.getTime(), message);
      });
  expectFailure(classify(two), {two, "/points", "/rear/points"});
  expectFailure(classify(two, {"--topic", "/front"}), {two, "/front", "/points", "/rear/points"});
  EXPECT_EQ(folder_.list(), "no_clouds.bag two.bag");

  expectSuccess(classify(two, {"--topic", "/rear/points"}, "rear"));
  expectSuccess(classify(forest(), {}, "front"));
  EXPECT_EQ(metrics("rear")["topic"], "/rear/points");
  EXPECT_EQ(metrics("rear")["label_hash"], metrics("front")["label_hash"]);
  EXPECT_EQ(readClouds(out("rear"), "/points").size(), kScans) << "the other topic is kept";
}

TEST_F(ClassifyBagInput, FailsWithoutTransforms) {
  const std::string no_tf =
      editedBag(forest(), folder_.file("no_tf.bag"), [](const auto& message, rosbag::Bag* to) {
        if (message.getTopic() != "/tf") writeAsItIs(message, to);
      });
  expectFailure(classify(no_tf), {no_tf, "not one scan", "no_transform", "odom"});
  const Json m = metrics();
  EXPECT_EQ(m["scans"], 0);
  EXPECT_EQ(m["scans_dropped"]["no_transform"], kScans);
  EXPECT_EQ(m["points_inserted"], 0);
  expectSumsUp(m);
}

TEST_F(ClassifyBagInput, CountsScansItCannotUse) {
  int scan = 0;
  const std::string mixed =
      editedBag(forest(), folder_.file("mixed.bag"), [&](const auto& message, rosbag::Bag* to) {
        if (message.getTopic() != "/points") return writeAsItIs(message, to);
        auto cloud = *message.template instantiate<sensor_msgs::PointCloud2>();
        ++scan;
        if (scan == 3) cloud.header.stamp = ros::Time();
        if (scan == 5) cloud.fields[2].name = "height";
        if (scan == 7) cloud.data.resize(100);
        if (scan == 9) cloud.header.frame_id = "elsewhere";
        if (scan == 11) {
          cloud.width = cloud.height = cloud.row_step = 0;
          cloud.data.clear();
        }
        to->write(message.getTopic(), message.getTime(), cloud);
      });
  expectSuccess(classify(mixed));
  const Json m = metrics();
  EXPECT_EQ(m["scans"], kScans - 5);
  EXPECT_EQ(m["scans_dropped"]["no_stamp"], 1);
  EXPECT_EQ(m["scans_dropped"]["bad_cloud"], 2);
  EXPECT_EQ(m["scans_dropped"]["no_transform"], 1);
  EXPECT_EQ(m["scans_dropped"]["empty"], 1);
  EXPECT_EQ(m["dropped"]["no_stamp"], kPointsPerScan);
  expectSumsUp(m);
  EXPECT_EQ(readClouds(out(), "/labeled_points").size(), kScans - 5);
}

TEST_F(ClassifyBagInput, RefusesWhatIsNoBag) {
  const std::string bytes = fileBytes(forest());
  const std::string truncated = folder_.write("truncated.bag", bytes.substr(0, bytes.size() / 2));
  expectFailure(classify(truncated), {truncated});
  const std::string text = folder_.write("text.bag", "not a bag\n");
  expectFailure(classify(text), {text});
  const std::string empty = folder_.write("empty.bag", "");
  expectFailure(classify(empty), {empty});
  expectFailure(classify(folder_.file("missing.bag")), {"missing.bag"});
  expectFailure(classify(folder_.path()), {folder_.path()});
  EXPECT_EQ(folder_.list(), "empty.bag text.bag truncated.bag");
}

TEST_F(ClassifyBagInput, NamesABagThatIsDamagedInside) {
  std::string bytes = fileBytes(forest());
  // The record header of a message half way, well inside a chunk: opening does not find it.
  std::size_t at = bytes.size() / 2;
  for (int i = 0; i < 4; ++i) at = bytes.find("op=\x02", at + 1);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at - 30, 70, 70, '\xff');
  const std::string damaged = folder_.write("damaged.bag", bytes);
  const ProgramRun run = classify(damaged);
  EXPECT_EQ(run.status, 1) << run;
  EXPECT_NE(run.err.find("classify_bag: " + damaged), std::string::npos) << run;
  EXPECT_EQ(folder_.list(), "damaged.bag");
}

TEST_F(ClassifyBagInput, RefusesPathsItCannotWrite) {
  const std::string bag = folder_.file("none/out.bag");
  expectFailure(runProgram("classify_bag", {forest(), "--out", bag}), {bag, "cannot be written"});
  const std::string json = folder_.file("none/m.json");
  expectFailure(runProgram("classify_bag", {forest(), "--metrics", json}),
                {json, "cannot be written"});
  EXPECT_EQ(folder_.list(), "");
}

/// A drive recorded twice into one bag; the first pass has its stamps `shift_s` later.
std::string drivenTwice(const std::string& from, const std::string& path, double shift_s) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  for (const bool first : {true, false}) {
    const ros::Duration stamp_shift(first ? shift_s : 0.0);
    const ros::Duration record_shift(first ? 0.0 : 10.0);
    const auto edit = [&](const rosbag::MessageInstance& message, rosbag::Bag* to) {
      const ros::Time recorded = message.getTime() + record_shift;
      if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) {
        cloud->header.stamp += stamp_shift;
        to->write(message.getTopic(), recorded, *cloud);
      } else if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
        for (auto& transform : transforms->transforms) transform.header.stamp += stamp_shift;
        to->write(message.getTopic(), recorded, *transforms);
      }
    };
    copyBag(from, edit, &bag);
  }
  bag.close();
  return path;
}

TEST_F(ClassifyBagInput, StampsThatJumpBackResetOnce) {
  // A bag that loops, and one whose clock was set back farther than tf remembers.
  for (const double shift_s : {0.0, 100.0}) {
    const std::string twice = drivenTwice(forest(), folder_.file("twice.bag"), shift_s);
    expectSuccess(classify(twice));
    const Json m = metrics();
    EXPECT_EQ(m["resets"], 1) << shift_s;
    // Poses of the second pass that came before its first scan went with those of the first pass:
    // that scan and the next, which begins where it ends, cannot be placed.
    EXPECT_GE(m["scans"].get<std::size_t>(), 2 * kScans - 2) << m["scans_dropped"];
    EXPECT_EQ(m["scans"].get<std::size_t>() + sumOf(m["scans_dropped"]), 2 * kScans);
    expectSumsUp(m);
    const auto labeled = readClouds(out(), "/labeled_points");
    EXPECT_LE(labeled.back().cloud.header.stamp.toSec(), 1002.0);
    const auto labels = valuesOf<uint8_t>(labeled.back().cloud, "label");
    EXPECT_GT(std::count_if(labels.begin(), labels.end(), [](uint8_t l) { return l > 0; }), 1000);
  }
}

}  // namespace
}  // namespace ladar_perception::test
