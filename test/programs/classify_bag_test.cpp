// SPDX-License-Identifier: BSD-3-Clause
#include <std_msgs/String.h>

#include <array>
#include <cmath>
#include <memory>
#include <set>

#include "ladar_perception/classify/classifier_model.h"
#include "program_bag.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

using Json = nlohmann::json;

const std::string kModelPath = LADAR_SOURCE_DIR "/config/models/starter.yaml";

/// 64-bit FNV-1a over label and confidence of every point, written from its definition.
std::string labelHash(const std::vector<RecordedCloud>& labeled) {
  uint64_t hash = 14695981039346656037ULL;
  for (const RecordedCloud& scan : labeled) {
    const auto label = valuesOf<uint8_t>(scan.cloud, "label");
    const auto confidence = valuesOf<std::array<uint8_t, 4>>(scan.cloud, "confidence");
    for (std::size_t i = 0; i < label.size(); ++i) {
      hash = (hash ^ label[i]) * 1099511628211ULL;
      for (const uint8_t byte : confidence[i]) hash = (hash ^ byte) * 1099511628211ULL;
    }
  }
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

uint64_t sumOf(const Json& counts) {
  uint64_t sum = 0;
  for (const auto& count : counts) sum += count.get<uint64_t>();
  return sum;
}

void expectSumsUp(const Json& metrics) {
  EXPECT_EQ(metrics.at("points_in").get<uint64_t>(),
            metrics.at("points_inserted").get<uint64_t>() + sumOf(metrics.at("dropped")))
      << metrics;
}

void expectPercentiles(const Json& values, const std::string& name) {
  const std::vector<double> ordered = {
      0.0, values.at("p50").get<double>(), values.at("p95").get<double>(),
      values.at("p99").get<double>(), values.at("max").get<double>()};
  EXPECT_TRUE(std::is_sorted(ordered.begin(), ordered.end())) << name << ": " << values;
}

/// The same bag for all tests: a simulated forest with a latched message of somebody else.
class ClassifyBag : public ::testing::Test {
 protected:
  static constexpr std::size_t kScans = 40;
  static constexpr std::size_t kPointsPerScan = std::size_t{180} * 32;

  static void SetUpTestSuite() {
    shared_ = std::make_unique<ScratchFolder>();
    const std::string simulated = shared_->file("simulated.bag");
    expectSuccess(runProgram("simulate_ladar", {"--scene", "forest", "--duration", "2", "--seed",
                                                "17", "--out", simulated}));
    rosbag::Bag bag(shared_->file("forest.bag"), rosbag::bagmode::Write);
    copyBag(simulated, writeAsItIs, &bag);
    std_msgs::String note;
    note.data = "keep me";
    const auto header = boost::make_shared<ros::M_string>();
    (*header)["latching"] = "1";
    (*header)["callerid"] = "/writer";
    (*header)["type"] = ros::message_traits::datatype(note);
    (*header)["md5sum"] = ros::message_traits::md5sum(note);
    (*header)["message_definition"] = ros::message_traits::definition(note);
    bag.write("/note", ros::Time(1000.7), note, header);
    bag.close();
  }
  static void TearDownTestSuite() { shared_.reset(); }

  static std::string forest() { return shared_->file("forest.bag"); }

  /// Runs on `input` with --out and --metrics in this test's folder.
  ProgramRun classify(const std::string& input, std::vector<std::string> more = {},
                      const std::string& name = "run") {
    more.insert(more.begin(),
                {input, "--out", out(name), "--metrics", folder_.file(name + ".json")});
    return runProgram("classify_bag", more);
  }
  std::string out(const std::string& name = "run") const { return folder_.file(name + ".bag"); }
  Json metrics(const std::string& name = "run") const {
    return readJson(folder_.file(name + ".json"));
  }

  ScratchFolder folder_;

 private:
  static std::unique_ptr<ScratchFolder> shared_;
};
std::unique_ptr<ScratchFolder> ClassifyBag::shared_;

TEST_F(ClassifyBag, MetricsHaveEveryKey) {
  expectSuccess(classify(forest()));
  const Json m = metrics();
  for (const char* key : {"scans", "points_in", "points_inserted", "dropped", "voxels_max",
                          "rss_mb_max", "latency_ms", "stages_ms", "points_per_second",
                          "label_counts", "label_hash", "confusion", "recall", "mean_recall"}) {
    EXPECT_TRUE(m.contains(key)) << key;
  }
  EXPECT_EQ(m["scans"], kScans);
  EXPECT_EQ(m["points_in"], kScans * kPointsPerScan);
  expectSumsUp(m);
  EXPECT_EQ(sumOf(m["label_counts"]), kScans * kPointsPerScan);
  EXPECT_GT(m["points_inserted"].get<uint64_t>(), kScans * kPointsPerScan / 4);
  EXPECT_GT(m["voxels_max"].get<int>(), 1000);
  EXPECT_GT(m["rss_mb_max"].get<double>(), 5.0);
  EXPECT_GT(m["points_per_second"].get<double>(), 0.0);
  expectPercentiles(m["latency_ms"], "latency_ms");
  EXPECT_GE(m["stages_ms"].size(), 3u);
  for (const auto& [name, stage] : m["stages_ms"].items()) expectPercentiles(stage, name);
}

TEST_F(ClassifyBag, LabelsAForestRight) {
  expectSuccess(classify(forest()));
  const Json m = metrics();
  EXPECT_GE(m["mean_recall"].get<double>(), 0.6) << m["confusion"];
  double sum = 0.0;
  for (const auto& [name, row] : m["confusion"].items()) {
    const double recall = row[name].get<double>() / static_cast<double>(sumOf(row));
    EXPECT_NEAR(m["recall"][name].get<double>(), recall, 1e-9) << name;
    sum += recall;
  }
  EXPECT_NEAR(m["mean_recall"].get<double>(), sum / 3.0, 1e-9);
}

TEST_F(ClassifyBag, SameBitsForAnyNumberOfThreads) {
  std::set<std::size_t> digests;
  std::set<std::string> hashes;
  for (const std::string threads : {"1", "1", "2", "3"}) {
    expectSuccess(classify(forest(), {"--threads", threads}));
    digests.insert(digestOf(out()));
    hashes.insert(metrics()["label_hash"].get<std::string>());
  }
  EXPECT_EQ(digests.size(), 1u);
  EXPECT_EQ(hashes.size(), 1u);
  EXPECT_EQ(hashes, std::set<std::string>{labelHash(readClouds(out(), "/labeled_points"))});
}

TEST_F(ClassifyBag, OutputIsTheInputWithLabels) {
  expectSuccess(classify(forest()));
  const auto input = readClouds(forest(), "/points");
  const auto output = readClouds(out(), "/labeled_points");
  ASSERT_EQ(output.size(), input.size());
  for (std::size_t s = 0; s < input.size(); ++s) {
    const auto& scan = input[s].cloud;
    const auto& labeled = output[s].cloud;
    EXPECT_EQ(output[s].recorded, input[s].recorded);
    EXPECT_EQ(labeled.header.stamp, scan.header.stamp);
    EXPECT_EQ(labeled.header.frame_id, scan.header.frame_id);
    ASSERT_EQ(labeled.width, scan.width);
    ASSERT_EQ(labeled.height, scan.height);
    for (const auto& field : scan.fields) {
      // A scan may have a colour of its own; it makes room for the class's.
      const std::string kept = field.name == "rgb" ? "rgb_input" : field.name;
      const auto* copy = findField(labeled, kept);
      ASSERT_NE(copy, nullptr) << kept << " is not in " << fieldsOf(labeled);
      ASSERT_EQ(copy->datatype, field.datatype) << kept;
      const std::size_t size = field.datatype == 2 ? 1 : field.datatype == 4 ? 2 : 4;
      bool same = true;
      for (std::size_t i = 0; i < kPointsPerScan; ++i) {
        same = same && std::memcmp(&scan.data[i * scan.point_step + field.offset],
                                   &labeled.data[i * labeled.point_step + copy->offset], size) == 0;
      }
      EXPECT_TRUE(same) << kept << " of scan " << s;
    }
  }
}

TEST_F(ClassifyBag, OutputHasAllOtherMessages) {
  expectSuccess(classify(forest()));
  const auto input = readRaw(forest(), {"/points"});
  const auto output = readRaw(out(), {"/labeled_points", "/labeled_map"});
  EXPECT_GT(input.size(), 400u);
  EXPECT_TRUE(std::multiset<RawMessage>(input.begin(), input.end()) ==
              std::multiset<RawMessage>(output.begin(), output.end()));
}

TEST_F(ClassifyBag, LabelsAndMetricsAgree) {
  expectSuccess(classify(forest()));
  const Json m = metrics();
  const ClassifierModel model = loadClassifierModel(kModelPath);
  std::map<std::string, uint64_t> counts;
  std::map<std::pair<int, int>, uint64_t> confusion;
  uint64_t with_truth = 0;
  for (const RecordedCloud& scan : readClouds(out(), "/labeled_points")) {
    const auto label = valuesOf<uint8_t>(scan.cloud, "label");
    const auto confidence = valuesOf<float>(scan.cloud, "confidence");
    const auto rgb = valuesOf<uint32_t>(scan.cloud, "rgb");
    const auto truth = valuesOf<uint8_t>(scan.cloud, "truth");
    for (std::size_t i = 0; i < label.size(); ++i) {
      ASSERT_LE(label[i], model.classes.size());
      ASSERT_EQ(rgb[i], model.labelColor(label[i]));
      ASSERT_GE(confidence[i], 0.0F);
      ASSERT_LE(confidence[i], 1.0F);
      ASSERT_EQ(confidence[i] == 0.0F, label[i] == 0);
      ++counts[model.labelName(label[i])];
      ++confusion[{truth[i], label[i]}];
      if (truth[i] > 0) ++with_truth;
    }
  }
  for (const auto& [name, count] : m["label_counts"].items()) {
    EXPECT_EQ(counts[name], count.get<uint64_t>()) << name;
  }
  for (int truth = 1; truth <= 3; ++truth) {
    for (int label = 1; label <= 3; ++label) {
      const std::string row = model.labelName(static_cast<uint8_t>(truth));
      const std::string column = model.labelName(static_cast<uint8_t>(label));
      EXPECT_EQ(m["confusion"][row][column].get<uint64_t>(), (confusion[{truth, label}]));
    }
  }
  EXPECT_EQ(m["truth_points"].get<uint64_t>() + m["truth_points_outside_map"].get<uint64_t>(),
            with_truth);
}

TEST_F(ClassifyBag, WritesTheMap) {
  expectSuccess(classify(forest()));
  const auto maps = readClouds(out(), "/labeled_map");
  ASSERT_EQ(maps.size(), 2u);  // 1 Hz over 2 s
  for (const RecordedCloud& map : maps) {
    EXPECT_EQ(map.cloud.header.frame_id, "odom");
    EXPECT_EQ(map.cloud.height, 1u);
    EXPECT_GT(map.cloud.width, 500u);
    for (const char* field : {"x", "y", "z", "rgb", "confidence", "scatter", "surface", "linear",
                              "normal_x", "normal_y", "normal_z", "points", "label"}) {
      EXPECT_NE(findField(map.cloud, field), nullptr) << field;
    }
  }
}

TEST_F(ClassifyBag, WorksWithoutOutputFiles) {
  const ProgramRun run = runProgram("classify_bag", {forest()});
  expectSuccess(run);
  EXPECT_NE(run.out.find("40 scans labelled"), std::string::npos) << run.out;
}

TEST_F(ClassifyBag, MayReplaceItsInput) {
  const std::string path = folder_.file("run.bag");
  std::filesystem::copy_file(forest(), path);
  expectSuccess(classify(path));
  EXPECT_EQ(readClouds(path, "/labeled_points").size(), kScans);
  EXPECT_EQ(folder_.list(), "run.bag run.json");
}

TEST_F(ClassifyBag, UsesTheGivenConfiguration) {
  const std::string config =
      folder_.write("half.yaml", "map_size_x_m: 10\nmap_size_y_m: 10.0\nmap_rate_hz: 0\n");
  expectSuccess(classify(forest(), {"--config", config}, "half"));
  expectSuccess(classify(forest(), {}, "whole"));
  EXPECT_LT(metrics("half")["voxels_max"], metrics("whole")["voxels_max"]);
  EXPECT_LT(metrics("half")["points_inserted"], metrics("whole")["points_inserted"]);
  expectSumsUp(metrics("half"));
  EXPECT_EQ(readClouds(out("half"), "/labeled_map").size(), 0u);
  // The shipped file says what the defaults say.
  expectSuccess(classify(forest(), {"--config", LADAR_SOURCE_DIR "/config/terrain.yaml"}, "file"));
  EXPECT_EQ(digestOf(out("file")), digestOf(out("whole")));
}

TEST_F(ClassifyBag, RefusesAModelThatDoesNotFit) {
  const std::string config = folder_.write("coarse.yaml", "voxel_size_m: 0.2\n");
  expectFailure(classify(forest(), {"--config", config}),
                {"starter.yaml", "does not fit", "0.1", "0.2"});
  const std::string wide = folder_.write("wide.yaml", "support_radius_voxels: 3\n");
  expectFailure(classify(forest(), {"--config", wide}), {"starter.yaml", "does not fit", "3", "4"});
  EXPECT_EQ(folder_.list(), "coarse.yaml wide.yaml");
}

TEST_F(ClassifyBag, RefusesABadModel) {
  const std::string missing = folder_.file("missing.yaml");
  expectFailure(classify(forest(), {"--model", missing}), {missing});
  expectFailure(classify(forest(), {"--model", "package://no_such_package/a.yaml"}),
                {"classify_bag: package://no_such_package", "not found"}, 3);  // rospack speaks too
  const std::string text = folder_.write("text.yaml", "format: something/else\n");
  expectFailure(classify(forest(), {"--model", text}), {text});
  EXPECT_EQ(folder_.list(), "text.yaml");
}

TEST_F(ClassifyBag, NamesWhatIsWrongInTheConfiguration) {
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

TEST_F(ClassifyBag, NeedsATopic) {
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

TEST_F(ClassifyBag, FailsWithoutTransforms) {
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

TEST_F(ClassifyBag, CountsScansItCannotUse) {
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

TEST_F(ClassifyBag, RefusesWhatIsNoBag) {
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

TEST_F(ClassifyBag, NamesABagThatIsDamagedInside) {
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

TEST_F(ClassifyBag, RefusesPathsItCannotWrite) {
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

TEST_F(ClassifyBag, StampsThatJumpBackResetOnce) {
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

TEST_F(ClassifyBag, Helps) {
  expectHelp("classify_bag",
             {"input", "--out", "--metrics", "--config", "--model", "--topic", "--threads"});
  expectFailure(runProgram("classify_bag", {}), {"input"});
}

}  // namespace
}  // namespace ladar_perception::test
