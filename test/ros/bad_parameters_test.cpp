// SPDX-License-Identifier: BSD-3-Clause
// Parameters that do not fit stop the start with one report that names each of them; the manager
// and its other nodelets go on.
#include <fstream>
#include <map>

#include "ros_bad_parameters.h"
#include "ros_terrain_client.h"

namespace ladar_perception::test {
namespace {

std::string brokenModel() {
  static TemporaryFolder folder;
  static const std::string path = folder.file("broken.yaml");
  std::ofstream(path) << "format: ladar_perception/classifier/1\nvoxel_size_m: 0.1\nspeling: 1\n";
  return path;
}

std::vector<BadStart> badStarts() {
  using std::string;
  return {
      {"several",
       {{"voxel_size_m", 0.0001},    // out of range
        {"queue_size", 2.5},         // wrong type: read as an int it would be 2
        {"tf_timeout_s", string()},  // wrong type: roscpp would take the default
        {"motion_compensation", 1},
        {"map_size_x", 40.0},  // unknown
        {"threads", 0},
        {"map_frame", string("/odom")}},
       {"9 bad parameters", "voxel_size_m", "[0.01, 2]", "queue_size", "2.5", "tf_timeout_s",
        "motion_compensation", "map_size_x", "did you mean 'map_size_x_m'", "threads: 0",
        "map_frame", "slash", "max_range_m", "a list", "map_radius_m", "a map"},
       [](const string& node) {
         ros::param::set(node + "/max_range_m", std::vector<double>{1.0, 2.0});
         ros::param::set(node + "/map_radius_m", std::map<string, double>{{"x", 1.0}});
       }},
      {"contradiction",
       {{"min_range_m", 50.0}, {"max_range_m", 10.0}},
       {"1 bad parameter", "min_range_m", "max_range_m"}},
      {"misfit",
       {{"voxel_size_m", 0.2}, {"support_radius_voxels", 3}},
       {kTestModel, "does not fit", "voxel_size_m 0.1", "0.2", "support_radius_voxels 6", "3"}},
      {"missing_model",
       {{"model", string("/nowhere/model.yaml")}},
       {"/nowhere/model.yaml", "cannot be opened"}},
      {"broken_model", {{"model", brokenModel()}}, {"broken.yaml:3", "speling"}},
      {"missing_package",
       {{"model", string("package://no_such_package/model.yaml")}},
       {"no_such_package"}},
  };
}

TEST(BadParameters, TheNodeEndsWithAReport) {
  expectProgramRefuses<TerrainClient>("terrain_node", badStarts());
}

TEST(BadParameters, TheNodeletIsNotLoadedAndTheManagerGoesOn) {
  expectManagerRefuses<TerrainClient>(badStarts());
  LoadedTerrain good("/good");
  ASSERT_TRUE(good.ready());
  good->sendMount();
  EXPECT_EQ(good->labelScans(Drive(), 0, 2, 0.25), 2);
}

TEST(BadParameters, GoodOnesLoadUnderTheNameThatFailed) {
  const Manager manager("/manager");
  ros::param::set("/again/terrain/model", 5);
  EXPECT_FALSE(manager.load("/again/terrain", TerrainClient::kNodelet));
  LoadedTerrain good("/again");
  ASSERT_TRUE(good.ready());
  good->sendMount();
  EXPECT_EQ(good->labelScans(Drive(), 0, 2, 0.25), 2);
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "bad_parameters_test");
}
