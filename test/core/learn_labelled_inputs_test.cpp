// SPDX-License-Identifier: BSD-3-Clause
#include "io_test_files.h"
#include "ladar_perception/learn/labelled_inputs.h"

namespace ladar_perception {
namespace {

std::vector<std::string> namesOf(const LabelledInput& input) {
  std::vector<std::string> names;
  for (const LabelledFile& file : input.files) {
    names.push_back(std::filesystem::path(file.path).filename().string());
  }
  return names;
}

TEST(LearnLabelledInputs, ExtensionsTellFormats) {
  const std::vector<std::pair<std::string, std::optional<ScanFormat>>> cases = {
      {"tile.xyz_label_conf", ScanFormat::kOakland},
      {"0.bin", ScanFormat::kKitti},
      {"a.ply", ScanFormat::kPly},
      {"a.pcd", ScanFormat::kPcd},
      {"a.csv", ScanFormat::kXyz},
      {"a.xyz", ScanFormat::kXyz},
      {"a.bag", std::nullopt}};
  for (const auto& [name, format] : cases) {
    const std::string path = writeFile(name, "");
    const auto inputs = listLabelledInputs({path}, "");
    ASSERT_EQ(inputs.size(), 1u);
    EXPECT_EQ(inputs[0].name, path);
    ASSERT_EQ(inputs[0].files.size(), 1u);
    EXPECT_EQ(inputs[0].files[0].format, format) << name;
  }
}

TEST(LearnLabelledInputs, AFolderIsOneInputWithItsFiles) {
  writeFile("k/10.bin", "");
  writeFile("k/9.bin", "");
  writeFile("k/9.label", "");
  writeFile("k/readme.txt", "");
  const auto inputs = listLabelledInputs({(testFolder() / "k").string()}, "");
  ASSERT_EQ(inputs.size(), 1u);
  EXPECT_EQ(namesOf(inputs[0]), (std::vector<std::string>{"9.bin", "10.bin"}));
  writeFile("b/2.bag", "");
  writeFile("b/1.bag", "");
  EXPECT_EQ(namesOf(listLabelledInputs({(testFolder() / "b").string()}, "")[0]),
            (std::vector<std::string>{"1.bag", "2.bag"}));
}

TEST(LearnLabelledInputs, AGivenFormatDecides) {
  const std::string path = writeFile("points.dat", "");
  EXPECT_EQ(listLabelledInputs({path}, "oakland")[0].files[0].format, ScanFormat::kOakland);
  EXPECT_EQ(listLabelledInputs({path}, "bag")[0].files[0].format, std::nullopt);
  writeFile("mixed/a.ply", "");
  writeFile("mixed/b.pcd", "");
  const std::string mixed = (testFolder() / "mixed").string();
  EXPECT_EQ(namesOf(listLabelledInputs({mixed}, "pcd")[0]), (std::vector<std::string>{"b.pcd"}));
}

TEST(LearnLabelledInputs, NamesWhatItCannotTell) {
  expectError([] { listLabelledInputs({"/nowhere.ply"}, ""); }, {"/nowhere.ply", "no such"});
  const std::string odd = writeFile("odd.txt", "");
  expectError([&] { listLabelledInputs({odd}, ""); }, {"odd.txt", ".ply", "--format"});
  expectError([&] { listLabelledInputs({odd}, "obj"); }, {"'obj'", "oakland"});
  writeFile("mixed/a.ply", "");
  writeFile("mixed/b.bag", "");
  const std::string mixed = (testFolder() / "mixed").string();
  expectError([&] { listLabelledInputs({mixed}, ""); }, {"mixed", "*.bag", "*.ply", "--format"});
  std::filesystem::create_directories(testFolder() / "empty");
  const std::string empty = (testFolder() / "empty").string();
  for (const char* format : {"", "bag", "ply"}) {
    expectError([&] { listLabelledInputs({empty}, format); }, {"empty"});
  }
}

TEST(LearnLabelledInputs, PassesOfFiles) {
  const LabelledFile tile{"t", ScanFormat::kOakland};
  const LabelledFile scan{"s", ScanFormat::kKitti};
  const LabelledFile bag{"b", std::nullopt};
  using Passes = std::vector<Pass>;
  EXPECT_EQ(passesOf(tile, {}), (Passes{Pass::kWhole, Pass::kStream}));
  EXPECT_EQ(passesOf(scan, {}), (Passes{Pass::kWhole}));
  EXPECT_EQ(passesOf(tile, {Pass::kStream}), (Passes{Pass::kStream}));
  EXPECT_EQ(passesOf(bag, {Pass::kStream}), (Passes{Pass::kRecorded}));
  EXPECT_EQ(passFromName("stream"), Pass::kStream);
  EXPECT_EQ(passFromName(passName(Pass::kWhole)), Pass::kWhole);
  expectError([] { passFromName("recorded"); }, {"'recorded'", "whole", "stream"});
}

}  // namespace
}  // namespace ladar_perception
