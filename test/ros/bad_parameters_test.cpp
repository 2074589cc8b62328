// SPDX-License-Identifier: BSD-3-Clause
// Parameters that do not fit stop the start with one report that names each of them; the manager
// and its other nodelets go on.
#include <fstream>

#include "ros_process.h"
#include "ros_terrain_client.h"
#include "terrain_node_config.h"

namespace ladar_perception::test {
namespace {

/// Parameters of one start, and what the report must say of them.
struct BadStart {
  std::string name;
  std::function<void(const std::string& node)> set;
  std::vector<std::string> report;
};

std::string brokenModel() {
  static TemporaryFolder folder;
  static const std::string path = folder.file("broken.yaml");
  std::ofstream(path) << "format: ladar_perception/classifier/1\nvoxel_size_m: 0.1\nspeling: 1\n";
  return path;
}

std::vector<BadStart> badStarts() {
  using ros::param::set;
  return {
      {"several",
       [](const std::string& node) {
         set(node + "/voxel_size_m", 0.0001);        // out of range
         set(node + "/queue_size", 2.5);             // wrong type: read as an int it would be 2
         set(node + "/tf_timeout_s", std::string());  // wrong type: roscpp would take the default
         set(node + "/motion_compensation", 1);
         set(node + "/map_size_x", 40.0);  // unknown
         set(node + "/threads", 0);
         set(node + "/map_frame", std::string("/odom"));
         set(node + "/max_range_m", std::vector<double>{1.0, 2.0});
         set(node + "/map_radius_m", std::map<std::string, double>{{"x", 1.0}});
       },
       {"9 bad parameters", "voxel_size_m", "[0.01, 2]", "queue_size", "2.5", "tf_timeout_s",
        "motion_compensation", "map_size_x", "did you mean 'map_size_x_m'", "threads: 0",
        "map_frame", "slash", "max_range_m", "a list", "map_radius_m", "a map"}},
      {"contradiction",
       [](const std::string& node) {
         set(node + "/min_range_m", 50.0);
         set(node + "/max_range_m", 10.0);
       },
       {"1 bad parameter", "min_range_m", "max_range_m"}},
      {"misfit",
       [](const std::string& node) {
         set(node + "/voxel_size_m", 0.2);
         set(node + "/support_radius_voxels", 3);
       },
       {kTestModel, "does not fit", "voxel_size_m 0.1", "0.2", "support_radius_voxels 6", "3"}},
      {"missing_model",
       [](const std::string& node) { set(node + "/model", std::string("/nowhere/model.yaml")); },
       {"/nowhere/model.yaml", "cannot be opened"}},
      {"broken_model",
       [](const std::string& node) { set(node + "/model", brokenModel()); },
       {"broken.yaml:3", "speling"}},
      {"missing_package",
       [](const std::string& node) {
         set(node + "/model", std::string("package://no_such_package/model.yaml"));
       },
       {"no_such_package"}},
  };
}

void expectReport(const std::string& text, const BadStart& start) {
  for (const std::string& part : start.report) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in:\n" << text;
  }
}

TEST(BadParameters, TheNodeEndsWithAReport) {
  for (const BadStart& start : badStarts()) {
    SCOPED_TRACE(start.name);
    const std::string node = "/node_" + start.name;
    setTestParameters(node);
    start.set(node);
    TemporaryFolder folder;
    const std::string output = folder.file("output.txt");
    ChildProcess program({programPath("terrain_node"), "__name:=" + node.substr(1)}, output);
    ASSERT_TRUE(waitFor([&] { return !program.running(); })) << "it runs all the same";
    EXPECT_EQ(program.exitCode(), 1);
    const std::string text = textOf(output);
    expectReport(text, start);
    // One report, not one more after another start.
    const std::size_t fatal = text.find("FATAL");
    EXPECT_NE(fatal, std::string::npos) << text;
    EXPECT_EQ(text.find("FATAL", fatal + 1), std::string::npos) << text;
    ros::param::del(node);
  }
}

TEST(BadParameters, TheNodeletIsNotLoadedAndTheManagerGoesOn) {
  const Manager manager("/manager");
  for (const BadStart& start : badStarts()) {
    SCOPED_TRACE(start.name);
    const std::string nodelet = "/nodelet_" + start.name;
    setTestParameters(nodelet);
    start.set(nodelet);
    LogListener log;
    // The manager's log has to be connected before it has anything to say.
    ASSERT_TRUE(log.hears("/manager"));
    EXPECT_FALSE(manager.load(nodelet));
    EXPECT_TRUE(waitFor([&] { return log.count(start.report.back()) > 0; }));
    expectReport(log.find(start.report.back()), start);
    ros::param::del(nodelet);
  }
  LoadedTerrain good("/good");
  ASSERT_TRUE(good.ready());
  good->sendMount();
  EXPECT_EQ(good->labelScans(Drive(), 0, 2, 0.25), 2);
}

TEST(BadParameters, GoodOnesLoadUnderTheNameThatFailed) {
  const Manager manager("/manager");
  ros::param::set("/again/terrain/model", 5);
  EXPECT_FALSE(manager.load("/again/terrain"));
  LoadedTerrain good("/again");
  ASSERT_TRUE(good.ready());
  good->sendMount();
  EXPECT_EQ(good->labelScans(Drive(), 0, 2, 0.25), 2);
}

TEST(BadParameters, TheShippedParametersAreTheDefaults) {
  // What config/terrain.yaml says is what a node without parameters does.
  const TerrainNodeConfig file =
      readConfigFile<TerrainNodeConfig>(std::string(LADAR_SOURCE_DIR) + "/config/terrain.yaml");
  TerrainNodeConfig from_file = file;
  TerrainNodeConfig defaults;
  const ParamMap given =
      loadParamFile(std::string(LADAR_SOURCE_DIR) + "/config/terrain.yaml");
  const ParamTable file_table = from_file.table();
  const ParamTable default_table = defaults.table();
  ASSERT_EQ(file_table.specs().size(), default_table.specs().size());
  EXPECT_EQ(given.size(), default_table.specs().size()) << "every parameter is in the file";
  for (std::size_t i = 0; i < file_table.specs().size(); ++i) {
    const ParamSpec& spec = file_table.specs()[i];
    EXPECT_EQ(given.count(spec.name), 1U) << spec.name;
    std::visit(
        [&](auto* value) {
          using Target = decltype(value);
          EXPECT_EQ(*value, *std::get<Target>(default_table.specs()[i].target)) << spec.name;
        },
        spec.target);
  }
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "bad_parameters_test");
}
