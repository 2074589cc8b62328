// SPDX-License-Identifier: BSD-3-Clause
// The shipped configuration and models against the code they are for.
#include <algorithm>
#include <regex>
#include <set>
#include <utility>

#include "delayed_state_node_config.h"
#include "pose_resampler_node_config.h"
#include "program_run.h"
#include "terrain_node_config.h"

namespace ladar_perception::test {
namespace {

const std::string kConfigPath = LADAR_SOURCE_DIR "/config/terrain.yaml";

/// A configuration and the file that is shipped for it.
struct Terrain {
  using Config = TerrainNodeConfig;
  static std::string path() { return kConfigPath; }
};
struct Poses {
  using Config = PoseResamplerNodeConfig;
  static std::string path() { return LADAR_SOURCE_DIR "/config/pose_resampler.yaml"; }
};
struct Slam {
  using Config = DelayedStateNodeConfig;
  static std::string path() { return LADAR_SOURCE_DIR "/config/delayed_state.yaml"; }
};

std::string targetText(const ParamSpec& spec) {
  const auto text = [](auto* target) {
    std::ostringstream stream;
    stream.precision(17);
    stream << *target;
    return stream.str();
  };
  return std::visit(text, spec.target);
}

bool isNumber(const ParamSpec& spec) {
  return std::holds_alternative<int*>(spec.target) || std::holds_alternative<double*>(spec.target);
}

template <typename Shipped>
class ShippedConfig : public testing::Test {};
using ShippedConfigs = testing::Types<Terrain, Poses, Slam>;
TYPED_TEST_SUITE(ShippedConfig, ShippedConfigs, );

TYPED_TEST(ShippedConfig, ListsEveryParameterOnce) {
  std::set<std::string> in_file;
  for (const auto& entry : loadParamFile(TypeParam::path())) in_file.insert(entry.first);
  std::set<std::string> in_table;
  typename TypeParam::Config config;
  const ParamTable table = config.table();
  for (const ParamSpec& spec : table.specs()) {
    EXPECT_TRUE(in_table.insert(spec.name).second) << spec.name << " twice in the table";
  }
  EXPECT_EQ(in_file, in_table);
}

TYPED_TEST(ShippedConfig, ValuesAreTheDefaults) {
  // Start from values that are not the defaults, so that nothing is equal by being left out.
  typename TypeParam::Config read;
  ParamTable read_table = read.table();
  for (const ParamSpec& spec : read_table.specs()) {
    if (auto* const* flag = std::get_if<bool*>(&spec.target)) **flag = !**flag;
    if (auto* const* whole = std::get_if<int*>(&spec.target)) **whole = -99;
    if (auto* const* real = std::get_if<double*>(&spec.target)) **real = -99.5;
    if (auto* const* text = std::get_if<std::string*>(&spec.target)) **text = "changed";
  }
  EXPECT_EQ(read_table.apply(loadParamFile(TypeParam::path())), std::vector<std::string>());
  typename TypeParam::Config defaults;
  const ParamTable defaults_table = defaults.table();
  for (std::size_t i = 0; i < defaults_table.specs().size(); ++i) {
    EXPECT_EQ(targetText(read_table.specs()[i]), targetText(defaults_table.specs()[i]))
        << defaults_table.specs()[i].name;
  }
}

TYPED_TEST(ShippedConfig, CommentsTellTheTablesRanges) {
  using Range = std::pair<double, double>;
  typename TypeParam::Config config;
  std::map<std::string, ParamSpec> specs;
  const ParamTable table = config.table();
  for (const ParamSpec& spec : table.specs()) specs.emplace(spec.name, spec);

  // Parameters under one comment share it: its ranges are those of all of them.
  const std::regex range_form(R"(\[(-?[0-9.]+), (-?[0-9.]+)\])");
  std::set<Range> told;
  std::set<Range> expected;
  std::string names;
  int compared = 0;
  const auto compare = [&] {
    EXPECT_EQ(told, expected) << names;
    compared += names.empty() ? 0 : 1;
    told.clear();
    expected.clear();
    names.clear();
  };
  std::istringstream lines(fileBytes(TypeParam::path()));
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line[0] == '#') {
      if (!names.empty()) compare();
      for (std::sregex_iterator at(line.begin(), line.end(), range_form), end; at != end; ++at) {
        told.emplace(std::stod((*at)[1]), std::stod((*at)[2]));
      }
    } else if (line.find(':') != std::string::npos) {
      const std::string name = line.substr(0, line.find(':'));
      ASSERT_EQ(specs.count(name), 1u) << name;
      names += name + " ";
      const ParamSpec& spec = specs.at(name);
      if (isNumber(spec)) expected.emplace(spec.min, spec.max);
    }
  }
  compare();
  EXPECT_GT(compared, 10);
}

TYPED_TEST(ShippedConfig, CommentsTellTheUnits) {
  typename TypeParam::Config config;
  const ParamTable table = config.table();
  for (const ParamSpec& spec : table.specs()) {
    for (const auto& [ending, unit] :
         {std::pair("_m", "m"), std::pair("_s", "s"), std::pair("_hz", "Hz")}) {
      if (spec.name.find("_per_") != std::string::npos) continue;  // ends in what it is per
      const std::size_t at = spec.name.rfind(ending);
      if (at != std::string::npos && at + std::string(ending).size() == spec.name.size()) {
        EXPECT_EQ(spec.unit, unit) << spec.name;
      }
    }
    EXPECT_FALSE(spec.meaning.empty()) << spec.name;
  }
}

TEST(Config, ReportsEveryViolation) {
  try {
    readConfig<DelayedStateNodeConfig>({{"loop_hops", 50},
                                        {"solver", std::string("quick")},
                                        {"treads", 2},
                                        {"time_jump", std::string("panic")},
                                        {"odom_frame", std::string("map")}},
                                       "here");
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    const std::string report = error.what();
    for (const char* part : {"here: 5 bad parameters", "loop_hops: 50", "solver: 'quick'", "treads",
                             "time_jump: 'panic'", "map_frame: 'map' is odom_frame"}) {
      EXPECT_NE(report.find(part), std::string::npos) << part << " is not in: " << report;
    }
  }
}

TEST(Config, ShippedModelsFit) {
  providePackagePath();
  int models = 0;
  for (const auto& entry : std::filesystem::directory_iterator(LADAR_SOURCE_DIR "/config/models")) {
    TerrainNodeConfig config = readConfigFile<TerrainNodeConfig>(kConfigPath);
    config.model = entry.path().string();
    EXPECT_NO_THROW({
      const ClassifierModel model = loadFittingModel(config);
      EXPECT_GE(model.classes.size(), 2u) << config.model;
      EXPECT_FALSE(model.provenance.empty()) << config.model;
    }) << config.model;
    ++models;
  }
  EXPECT_GE(models, 1);
}

TEST(Config, DefaultModelIsAShippedOne) {
  providePackagePath();
  const std::string scheme = "package://ladar_perception/";
  const std::string model = TerrainNodeConfig().model;
  ASSERT_EQ(model.rfind(scheme, 0), 0u) << model;
  EXPECT_TRUE(
      std::filesystem::exists(std::string(LADAR_SOURCE_DIR) + "/" + model.substr(scheme.size())))
      << model;
  EXPECT_NO_THROW(loadFittingModel(TerrainNodeConfig()));
}

}  // namespace
}  // namespace ladar_perception::test
