// SPDX-License-Identifier: BSD-3-Clause
// What classify_bag makes of a good bag; of others: classify_bag_input_test.cpp.
#include <array>
#include <cmath>
#include <set>

#include "ladar_perception/classify/classifier_model.h"
#include "program_classify_bag.h"

namespace ladar_perception::test {
namespace {

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

void expectPercentiles(const Json& values, const std::string& name) {
  const std::vector<double> ordered = {
      0.0, values.at("p50").get<double>(), values.at("p95").get<double>(),
      values.at("p99").get<double>(), values.at("max").get<double>()};
  EXPECT_TRUE(std::is_sorted(ordered.begin(), ordered.end())) << name << ": " << values;
}

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
      const bool is_renamed = field.name == "rgb" || field.name == "label";
      const std::string kept = is_renamed ? field.name + "_input" : field.name;
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

TEST_F(ClassifyBag, Helps) {
  expectHelp("classify_bag",
             {"input", "--out", "--metrics", "--config", "--model", "--topic", "--threads"});
  expectFailure(runProgram("classify_bag", {}), {"input"});
}

}  // namespace
}  // namespace ladar_perception::test
