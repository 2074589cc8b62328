// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "ladar_perception/params/param_table.h"
#include "temporary_file.h"

namespace ladar_perception {
namespace {

using test::TemporaryFile;

struct Settings {
  bool lazy = false;
  int threads = 1;
  double voxel_size_m = 0.1;
  std::string map_frame = "odom";

  ParamTable table() {
    ParamTable table;
    table.add("lazy", &lazy, "publish only when somebody listens");
    table.add("threads", &threads, 1, 64, "threads", "of the pool");
    table.add("voxel_size_m", &voxel_size_m, 0.01, 2.0, "m", "edge of a voxel");
    table.add("map_frame", &map_frame, "where the map lives");
    return table;
  }
};

void expectMentions(const std::string& text, std::initializer_list<std::string> parts) {
  for (const std::string& part : parts) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
  }
}

/// The one violation of these values; all targets must be untouched.
std::string violationOf(const ParamMap& values) {
  Settings settings;
  const auto violations = settings.table().apply(values);
  EXPECT_EQ(violations.size(), 1U);
  const Settings defaults;
  EXPECT_EQ(settings.lazy, defaults.lazy);
  EXPECT_EQ(settings.threads, defaults.threads);
  EXPECT_EQ(settings.voxel_size_m, defaults.voxel_size_m);
  EXPECT_EQ(settings.map_frame, defaults.map_frame);
  return violations.empty() ? "" : violations.front();
}

TEST(ParamTable, SetsWhatIsGivenAndNothingElse) {
  Settings settings;
  EXPECT_TRUE(settings.table().apply({{"threads", 4}, {"map_frame", std::string("map")}}).empty());
  EXPECT_EQ(settings.threads, 4);
  EXPECT_EQ(settings.map_frame, "map");
  EXPECT_EQ(settings.voxel_size_m, 0.1);
  EXPECT_TRUE(settings.table().apply({{"lazy", true}, {"voxel_size_m", 0.25}}).empty());
  EXPECT_TRUE(settings.lazy);
  EXPECT_EQ(settings.voxel_size_m, 0.25);
  EXPECT_TRUE(settings.table().apply({}).empty());
}

TEST(ParamTable, SpecsTellWhatThereIs) {
  Settings settings;
  const ParamTable table = settings.table();
  ASSERT_EQ(table.specs().size(), 4U);
  const ParamSpec& spec = table.specs()[2];
  EXPECT_EQ(spec.name, "voxel_size_m");
  EXPECT_EQ(spec.min, 0.01);
  EXPECT_EQ(spec.max, 2.0);
  EXPECT_EQ(spec.unit, "m");
  EXPECT_EQ(spec.meaning, "edge of a voxel");
  EXPECT_EQ(std::get<double*>(spec.target), &settings.voxel_size_m);
}

TEST(ParamTable, AWholeNumberIsAFineRealOne) {
  Settings settings;
  EXPECT_TRUE(settings.table().apply({{"voxel_size_m", 1}}).empty());
  EXPECT_EQ(settings.voxel_size_m, 1.0);
}

TEST(ParamTable, LimitsBelongToTheRange) {
  Settings settings;
  EXPECT_TRUE(settings.table().apply({{"threads", 64}, {"voxel_size_m", 0.01}}).empty());
  EXPECT_TRUE(settings.table().apply({{"threads", 1}, {"voxel_size_m", 2.0}}).empty());
  expectMentions(violationOf({{"threads", 0}}), {"threads", "0", "out of range", "[1, 64]"});
  expectMentions(violationOf({{"threads", 65}}), {"threads", "65", "[1, 64]"});
  expectMentions(violationOf({{"voxel_size_m", 2.001}}), {"voxel_size_m", "2.001", "[0.01, 2] m"});
  expectMentions(violationOf({{"voxel_size_m", 3}}), {"voxel_size_m", "3", "out of range"});
  expectMentions(violationOf({{"voxel_size_m", std::nan("")}}), {"voxel_size_m", "nan"});
  expectMentions(violationOf({{"voxel_size_m", HUGE_VAL}}), {"voxel_size_m", "inf"});
}

TEST(ParamTable, WrongTypesSayWhatWasExpectedAndGiven) {
  expectMentions(violationOf({{"threads", 0.5}}), {"threads", "a whole number", "0.5"});
  expectMentions(violationOf({{"threads", 2.0}}), {"threads", "a whole number", "2"});
  expectMentions(violationOf({{"threads", true}}), {"threads", "a whole number", "true"});
  expectMentions(violationOf({{"threads", std::string("2")}}), {"a whole number", "text '2'"});
  expectMentions(violationOf({{"voxel_size_m", std::string()}}), {"a number", "text ''"});
  expectMentions(violationOf({{"voxel_size_m", false}}), {"a number", "false"});
  expectMentions(violationOf({{"lazy", 1}}), {"lazy", "true or false", "1"});
  expectMentions(violationOf({{"lazy", std::string("yes")}}), {"true or false", "yes"});
  expectMentions(violationOf({{"map_frame", 3}}), {"map_frame", "text", "3"});
  expectMentions(violationOf({{"map_frame", true}}), {"map_frame", "text", "true"});
  expectMentions(violationOf({{"map_frame", UnsupportedValue{"a list"}}}), {"text", "a list"});
  expectMentions(violationOf({{"threads", UnsupportedValue{"nothing"}}}), {"nothing"});
}

TEST(ParamTable, UnknownNamesGetASuggestionWhenOneIsNear) {
  expectMentions(violationOf({{"voxel_size", 0.2}}), {"voxel_size:", "unknown", "'voxel_size_m'"});
  expectMentions(violationOf({{"thraeds", 2}}), {"thraeds", "'threads'"});
  const std::string far = violationOf({{"completely_different", 2}});
  expectMentions(far, {"completely_different", "unknown"});
  EXPECT_EQ(far.find("did you mean"), std::string::npos);
}

TEST(ParamTable, ReportsEveryViolationAndSetsTheGoodOnes) {
  Settings settings;
  const auto violations = settings.table().apply({{"threads", 0},
                                                  {"voxel_size_m", true},
                                                  {"foo_bar_baz", 1},
                                                  {"map_frame", std::string("m")}});
  EXPECT_EQ(violations.size(), 3U);
  EXPECT_EQ(settings.map_frame, "m");
  EXPECT_EQ(settings.threads, 1);
}

ParamMap load(const std::string& text) { return loadParamFile(TemporaryFile(text).path()); }

/// What loading complains about; the path stands in front.
std::string loadError(const std::string& text) {
  const TemporaryFile file(text);
  try {
    loadParamFile(file.path());
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind(file.path() + ":", 0), 0U) << message;
    return message.substr(file.path().size());
  }
  ADD_FAILURE() << "no error for: " << text;
  return "";
}

TEST(LoadParamFile, PlainScalarsHaveTheirYamlType) {
  const ParamMap values = load(
      "# a comment\n"
      "whole: 3\nnegative: -4\nreal: 0.5\nscientific: 1e-3\nyes: true\nno: False\n"
      "text: odom\npath: /a/b c\ninfinite: -.inf\nbig: 3000000000\n");
  EXPECT_EQ(std::get<int>(values.at("whole")), 3);
  EXPECT_EQ(std::get<int>(values.at("negative")), -4);
  EXPECT_EQ(std::get<double>(values.at("real")), 0.5);
  EXPECT_EQ(std::get<double>(values.at("scientific")), 1e-3);
  EXPECT_EQ(std::get<bool>(values.at("yes")), true);
  EXPECT_EQ(std::get<bool>(values.at("no")), false);
  EXPECT_EQ(std::get<std::string>(values.at("text")), "odom");
  EXPECT_EQ(std::get<std::string>(values.at("path")), "/a/b c");
  EXPECT_EQ(std::get<double>(values.at("infinite")), -HUGE_VAL);
  EXPECT_EQ(std::get<double>(values.at("big")), 3e9);
}

TEST(LoadParamFile, QuotedScalarsAreText) {
  const ParamMap values = load("a: '3'\nb: \"0.5\"\nc: 'true'\nd: ''\n");
  EXPECT_EQ(std::get<std::string>(values.at("a")), "3");
  EXPECT_EQ(std::get<std::string>(values.at("b")), "0.5");
  EXPECT_EQ(std::get<std::string>(values.at("c")), "true");
  EXPECT_EQ(std::get<std::string>(values.at("d")), "");
}

TEST(LoadParamFile, OtherKindsAreNamed) {
  const ParamMap values = load("a: [1, 2]\nb: {c: 1}\nd:\ne: ~\n");
  EXPECT_EQ(describeValue(values.at("a")), "a list");
  EXPECT_EQ(describeValue(values.at("b")), "a map");
  EXPECT_EQ(describeValue(values.at("d")), "nothing");
  EXPECT_EQ(describeValue(values.at("e")), "nothing");
}

TEST(LoadParamFile, AnEmptyFileHasNoParameters) {
  EXPECT_TRUE(load("").empty());
  EXPECT_TRUE(load("# only a comment\n\n").empty());
}

TEST(LoadParamFile, BrokenFilesNameFileAndLine) {
  expectMentions(loadError("a: 1\nb: 2\na: 3\n"), {":3:", "'a'", "twice"});
  EXPECT_EQ(loadError("a: 1\nb: [1, 2\nc: 3\n").rfind(":", 0), 0U);
  expectMentions(loadError("a: 1\n  b: 2\n"), {":2:"});
  expectMentions(loadError("- 1\n- 2\n"), {"map"});
  expectMentions(loadError("just text\n"), {"map"});
}

TEST(LoadParamFile, AbsentFilesAndFolders) {
  for (const std::string path : {"/nowhere/terrain.yaml", "/tmp"}) {
    try {
      loadParamFile(path);
      ADD_FAILURE() << path;
    } catch (const std::runtime_error& error) {
      expectMentions(error.what(), {path + ":", "opened"});
    }
  }
}

}  // namespace
}  // namespace ladar_perception
