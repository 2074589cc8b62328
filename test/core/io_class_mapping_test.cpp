// SPDX-License-Identifier: BSD-3-Clause
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
}

TEST(IoClassMapping, NamesWhatIsWrongAndWhere) {
  const auto expectMessage = [](const std::string& yaml, const Names& parts) {
    const std::string path = writeFile("bad.yaml", yaml);
    expectError([&] { loadClassMapping(path); }, parts);
  };
  expectMessage("class: []\n", {"bad.yaml:1", "unknown key 'class'", "classes"});
  expectMessage("", {"bad.yaml", "classes"});
  expectMessage("classes: []\n", {"bad.yaml:1", "1 to 255"});
  expectMessage("classes:\n  - name: a\n", {"bad.yaml:2", "no 'labels'"});
  expectMessage("classes:\n  - name: a\n    labels: [1]\n    color: red\n",
                {"bad.yaml:4", "unknown key 'color'"});
  expectMessage("classes:\n  - {name: a, labels: [1]}\n  - {name: b, labels: [2, 1]}\n",
                {"bad.yaml:3", "label 1", "'a' already"});
  expectMessage("classes:\n  - {name: a, labels: [1]}\n  - {name: a, labels: [2]}\n",
                {"bad.yaml:3", "second class", "'a'"});
  expectMessage("classes: [{name: a, labels: [grass]}]\n", {"bad.yaml:1", "'grass'", "integer"});
  expectMessage("classes: [{name: a, labels: [1.5]}]\n", {"'1.5'"});
  expectMessage("classes: [{name: a, labels: [-3]}]\n", {"'-3'"});
  expectMessage("classes: [{name: a, labels: 3}]\n", {"list of integers"});
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
