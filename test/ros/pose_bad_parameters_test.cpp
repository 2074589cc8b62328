// SPDX-License-Identifier: BSD-3-Clause
// Parameters that do not fit stop the start with one report that names each of them; the manager
// and its other nodelets go on.
#include "pose_resampler_node_config.h"
#include "ros_bad_parameters.h"
#include "ros_pose_client.h"

namespace ladar_perception::test {
namespace {

std::vector<BadStart> badStarts() {
  using std::string;
  return {
      {"several",
       {{"count", 2.5},
        {"join", string("sometimes")},
        {"gather", string("all")},
        {"pose_distance", 2.0},
        {"queue_size", 0},
        {"tf_timeout_s", string()},
        {"odom_frame", string("/odom")},
        {"engine", string("magic")},
        {"policies", string("range:min=3 lable:linear=2")},
        {"max_range_m", 0.1}},
       {"10 bad parameters", "count", "2.5", "join: 'sometimes'", "gather: 'all'", "pose_distance",
        "did you mean 'pose_distance_m'", "queue_size: 0", "tf_timeout_s", "odom_frame", "slash",
        "engine: 'magic'", "policies: ", "lable", "max_range_m"}},
      {"no_end", {{"count", 0}}, {"1 bad parameter", "count", "radius_m", "time_budget_s"}},
      {"no_rule",
       {{"pose_distance_m", 0.0}, {"pose_angle_deg", 0.0}},
       {"1 bad parameter", "pose_distance_m", "pose_angle_deg", "pose_period_s"}},
      {"no_such_class",
       {{"policies", string("label:tree=3")}, {"class_names", string("rock lawn")}},
       {"1 bad parameter", "policies", "tree", "rock", "lawn"}},
      {"class_of_another_model",
       {{"policies", string("label:tree=3")}, {"model", kTestModel}},
       {"policies", "tree", "scatter"}},
      {"missing_model",
       {{"model", string("/nowhere/model.yaml")}},
       {"model: ", "/nowhere/model.yaml", "cannot be opened"}},
  };
}

TEST(PoseBadParameters, TheNodeEndsWithAReport) {
  expectProgramRefuses<PoseClient>("pose_resampler_node", badStarts());
}

TEST(PoseBadParameters, TheNodeletIsNotLoadedAndTheManagerGoesOn) {
  expectManagerRefuses<PoseClient>(badStarts());
  LoadedPoses good("/good");
  ASSERT_TRUE(good.ready());
  good->sendMount();
  good->send(Drive().vehicleTransforms(0, 1));
  EXPECT_TRUE(good->keep(Drive().scan(0, 0.25)));
}

TEST(PoseBadParameters, ClassNamesComeFromTheParameterOrTheModel) {
  using std::string;
  EXPECT_NO_THROW(readConfig<PoseResamplerNodeConfig>(
      {{"policies", string("label:lawn=3;range:min=2")}, {"class_names", string("rock lawn")}},
      "test"));
  const PoseResamplerNodeConfig config =
      readConfig<PoseResamplerNodeConfig>({{"policies", string(" label:scatter=3 ;  uniform ")},
                                           {"class_names", string("rock lawn")},
                                           {"model", kTestModel}},
                                          "test");
  EXPECT_EQ(loadPolicies(config).size(), 2U);
  EXPECT_TRUE(
      loadPolicies(readConfig<PoseResamplerNodeConfig>({{"policies", string()}}, "test")).empty());
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_bad_parameters_test");
}
