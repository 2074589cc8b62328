// SPDX-License-Identifier: BSD-3-Clause
#include <set>

#include "io_test_files.h"
#include "ladar_perception/io/class_mapping.h"

namespace ladar_perception {
namespace {

using Names = std::vector<std::string>;

TEST(IoClassMapping, CountsClassesFromOne) {
  const ClassMapping mapping = loadClassMapping(
      writeFile("c.yaml", "classes: [{name: a, labels: [1, 2]}, {name: b, labels: [7]}]\n"));
  EXPECT_EQ(mapping.names, (Names{"a", "b"}));
  EXPECT_EQ(mapping.truth(2), 1);
  EXPECT_EQ(mapping.truth(7), 2);
  EXPECT_EQ(mapping.truth(3), 0);
}

TEST(IoClassMapping, TakesColorsOrChoosesThem) {
  const ClassMapping mapping = loadClassMapping(
      writeFile("c.yaml",
                "classes:\n  - {name: a, labels: [1]}\n  - {name: linear, labels: [2]}\n"
                "  - {name: b, labels: [3], color: \"#0072B2\"}\n  - {name: c, labels: [4]}\n"));
  // The first of the palette is taken by b.
  EXPECT_EQ(mapping.colors, (std::vector<uint32_t>{0xe69f00, 0x3264ff, 0x0072b2, 0x009e73}));
}

TEST(IoClassMapping, SixteenClassesHaveSixteenColors) {
  Names names;
  for (int i = 0; i < 13; ++i) names.push_back("class " + std::to_string(i));
  names.insert(names.end(), {"surface", "scatter", "linear"});
  const std::vector<uint32_t> colors = classColors(names, {});
  const std::set<uint32_t> different(colors.begin(), colors.end());
  EXPECT_EQ(different.size(), 16u);
  EXPECT_EQ(different.count(kNoColor), 0u);
  EXPECT_EQ(colors[13], 0xdc2828u);
}

TEST(IoClassMapping, ShipsThreeAndFiveClasses) {
  const std::string folder = LADAR_SOURCE_DIR "/config/classes/";
  const ClassMapping three = loadClassMapping(folder + "oakland_three.yaml");
  EXPECT_EQ(three.names, (Names{"surface", "scatter", "linear"}));
  EXPECT_EQ(three.truth(1203), 1);
  EXPECT_EQ(three.truth(1300), 2);
  EXPECT_EQ(three.truth(1103), 3);
  EXPECT_EQ(three.truth(1001), 0);
  const ClassMapping five = loadClassMapping(folder + "oakland_five.yaml");
  EXPECT_EQ(five.names, (Names{"wire", "pole_trunk", "ground", "vegetation", "facade"}));
  EXPECT_EQ(five.truth(1411), 5);
  EXPECT_EQ(five.truth(1501), 0);
  EXPECT_EQ(three.colors, classColors(three.names, {}));
  EXPECT_EQ(five.colors.size(), 5u);
}

TEST(IoClassMapping, ShipsSemanticKitti) {
  const ClassMapping kitti =
      loadClassMapping(LADAR_SOURCE_DIR "/config/classes/semantic_kitti_three.yaml");
  EXPECT_EQ(kitti.names, (Names{"surface", "scatter", "linear"}));
  EXPECT_EQ(kitti.truth(40), 1);   // road
  EXPECT_EQ(kitti.truth(252), 1);  // moving car
  EXPECT_EQ(kitti.truth(70), 2);   // vegetation
  EXPECT_EQ(kitti.truth(80), 3);   // pole
  EXPECT_EQ(kitti.truth(0), 0);    // unlabeled
}

TEST(IoClassMapping, NamesWhatIsWrongAndWhere) {
  const auto expectMessage = [](const std::string& yaml, const Names& parts) {
    const std::string path = writeFile("bad.yaml", yaml);
    expectError([&] { loadClassMapping(path); }, parts);
  };
  expectMessage("class: []\n", {"bad.yaml:1", "unknown key 'class'", "classes"});
  expectMessage("", {"bad.yaml", "classes"});
  expectMessage("classes: []\n", {"bad.yaml:1", "2 to 16"});
  expectMessage("classes: [{name: a, labels: [1]}]\n", {"bad.yaml:1", "2 to 16"});
  const std::string end = "  - {name: z, labels: [99]}\n";
  expectMessage("classes:\n  - name: a\n" + end, {"bad.yaml:2", "no 'labels'"});
  expectMessage("classes:\n  - name: a\n    labels: [1]\n    colour: red\n" + end,
                {"bad.yaml:4", "unknown key 'colour'", "color"});
  expectMessage("classes:\n  - name: a\n    labels: [1]\n    color: red\n" + end,
                {"bad.yaml:4", "'red'", "#rrggbb"});
  expectMessage(
      "classes:\n  - {name: a, labels: [1], color: \"#102030\"}\n"
      "  - {name: b, labels: [2], color: \"#102030\"}\n",
      {"bad.yaml:3", "second class", "#102030"});
  expectMessage("classes:\n  - {name: unknown, labels: [1]}\n" + end, {"bad.yaml:2", "'unknown'"});
  expectMessage("classes:\n  - {name: a, labels: [1]}\n  - {name: b, labels: [2, 1]}\n",
                {"bad.yaml:3", "label 1", "'a' already"});
  expectMessage("classes:\n  - {name: a, labels: [1]}\n  - {name: a, labels: [2]}\n",
                {"bad.yaml:3", "second class", "'a'"});
  expectMessage("classes: [{name: a, labels: [grass]}, {name: z, labels: [9]}]\n",
                {"bad.yaml:1", "'grass'", "integer"});
  expectMessage("classes: [{name: a, labels: [1.5]}, {name: z, labels: [9]}]\n", {"'1.5'"});
  expectMessage("classes: [{name: a, labels: [-3]}, {name: z, labels: [9]}]\n", {"'-3'"});
  expectMessage("classes: [{name: a, labels: 3}, {name: z, labels: [9]}]\n", {"list of integers"});
  expectMessage("classes:\n  - [\n", {"bad.yaml:"});
  expectError([] { loadClassMapping("/nowhere.yaml"); }, {"/nowhere.yaml", "cannot be opened"});
}

TEST(IoClassMapping, AddsTruthToAScan) {
  const auto scanWith = [](double label) {
    return makeScan({{"x", ScalarType::kFloat32, {0, 0}},
                     {"y", ScalarType::kFloat32, {0, 0}},
                     {"z", ScalarType::kFloat32, {0, 0}},
                     {"label", ScalarType::kFloat32, {5, label}}});
  };
  ClassMapping mapping;
  mapping.names = {"a"};
  mapping.truth_of_label = {{5, uint8_t{1}}};
  Scan scan = scanWith(6);
  addTruth(scan, "label", mapping);
  EXPECT_EQ(readColumn(scan, "truth"), (std::vector<double>{1, 0}));
  EXPECT_EQ(scan.layout.find("truth")->type, ScalarType::kUint8);
  expectError([&] { addTruth(scan, "label", mapping); }, {"already", "'truth'"});
  expectError([&] { addTruth(scan, "class", mapping); }, {"'class'"});
  Scan fraction = scanWith(0.5);
  expectError([&] { addTruth(fraction, "label", mapping); }, {"'label'", "point 1", "0.5"});
}

}  // namespace
}  // namespace ladar_perception
