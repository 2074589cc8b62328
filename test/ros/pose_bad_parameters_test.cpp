// SPDX-License-Identifier: BSD-3-Clause
// Parameters that do not fit stop the start with one report that names each of them; the manager
// and its other nodelets go on.
#include "pose_resampler_node_config.h"
#include "ros_pose_client.h"
#include "ros_process.h"

namespace ladar_perception::test {
namespace {

/// Parameters of one start, and what the report must say of them.
struct BadStart {
  std::string name;
  ParamMap parameters;
  std::vector<std::string> report;
};

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

void expectReport(const std::string& text, const BadStart& start) {
  for (const std::string& part : start.report) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in:\n" << text;
  }
}

TEST(PoseBadParameters, TheNodeEndsWithAReport) {
  for (const BadStart& start : badStarts()) {
    SCOPED_TRACE(start.name);
    const std::string node = "/node_" + start.name;
    setTestPoseParameters(node);
    setParameters(node, start.parameters);
    TemporaryFolder folder;
    const std::string output = folder.file("output.txt");
    ChildProcess program({programPath("pose_resampler_node"), "__name:=" + node.substr(1)}, output);
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

TEST(PoseBadParameters, TheNodeletIsNotLoadedAndTheManagerGoesOn) {
  const Manager manager("/manager");
  for (const BadStart& start : badStarts()) {
    SCOPED_TRACE(start.name);
    const std::string nodelet = "/nodelet_" + start.name;
    setTestPoseParameters(nodelet);
    setParameters(nodelet, start.parameters);
    LogListener log;
    // The manager's log has to be connected before it has anything to say.
    ASSERT_TRUE(log.hears("/manager"));
    EXPECT_FALSE(manager.load(nodelet, kPoseNodelet));
    EXPECT_TRUE(waitFor([&] { return log.count(start.report.back()) > 0; }));
    expectReport(log.find(start.report.back()), start);
    ros::param::del(nodelet);
  }
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
  EXPECT_TRUE(loadPolicies(readConfig<PoseResamplerNodeConfig>({{"policies", string()}}, "test")).empty());
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "pose_bad_parameters_test");
}
