// SPDX-License-Identifier: BSD-3-Clause
// config/delayed_state.yaml against the table that it is for.
#include "slam_config.h"

#include <algorithm>
#include <set>
#include <sstream>

#include "program_run.h"

namespace ladar_perception::test {
namespace {

const std::string kConfigPath = LADAR_SOURCE_DIR "/config/delayed_state.yaml";

std::string targetText(const ParamSpec& spec) {
  const auto text = [](auto* target) {
    std::ostringstream stream;
    stream.precision(17);
    stream << *target;
    return stream.str();
  };
  return std::visit(text, spec.target);
}

TEST(SlamConfig, ListsEveryParameterOnce) {
  std::set<std::string> in_file;
  for (const auto& entry : loadParamFile(kConfigPath)) in_file.insert(entry.first);
  std::set<std::string> in_table;
  SlamConfig config;
  const ParamTable table = config.table();
  for (const ParamSpec& spec : table.specs()) {
    EXPECT_TRUE(in_table.insert(spec.name).second) << spec.name << " twice in the table";
  }
  EXPECT_EQ(in_file, in_table);
}

TEST(SlamConfig, ValuesAreTheDefaults) {
  // Start from values that are not the defaults, so that nothing is equal by being left out.
  SlamConfig read;
  ParamTable read_table = read.table();
  for (const ParamSpec& spec : read_table.specs()) {
    if (auto* const* whole = std::get_if<int*>(&spec.target)) **whole = -99;
    if (auto* const* real = std::get_if<double*>(&spec.target)) **real = -99.5;
    if (auto* const* text = std::get_if<std::string*>(&spec.target)) **text = "changed";
  }
  EXPECT_EQ(read_table.apply(loadParamFile(kConfigPath)), std::vector<std::string>());
  SlamConfig defaults;
  const ParamTable defaults_table = defaults.table();
  for (std::size_t i = 0; i < defaults_table.specs().size(); ++i) {
    EXPECT_EQ(targetText(read_table.specs()[i]), targetText(defaults_table.specs()[i]))
        << defaults_table.specs()[i].name;
  }
  EXPECT_NO_THROW(readSlamConfigFile(kConfigPath));
}

TEST(SlamConfig, ReportsEveryViolation) {
  try {
    readSlamConfig({{"loop_hops", 50}, {"solver", std::string("quick")}, {"treads", 2}}, "here");
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    const std::string report = error.what();
    for (const char* part : {"here", "loop_hops: 50", "solver: 'quick'", "treads"}) {
      EXPECT_NE(report.find(part), std::string::npos) << part << " is not in: " << report;
    }
  }
}

}  // namespace
}  // namespace ladar_perception::test
