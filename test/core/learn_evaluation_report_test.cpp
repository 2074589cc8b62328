// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "hand_model.h"
#include "ladar_perception/learn/evaluation_report.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::json;

EvaluatedInput inputWith(const std::string& name, int right, int wrong, int unknown) {
  EvaluatedInput input{name, "whole", LabelScores(3)};
  for (int i = 0; i < right; ++i) input.scores.add(2, {2, 0.75F, 0}, true);
  for (int i = 0; i < wrong; ++i) input.scores.add(2, {3, 0.75F, 0}, true);
  for (int i = 0; i < unknown; ++i) input.scores.add(1, {0, 0.0F, 0}, false);
  return input;
}

TEST(LearnEvaluationReport, HasEveryFigureUnderItsName) {
  const std::vector<EvaluatedInput> inputs = {inputWith("a", 6, 2, 0), inputWith("b", 0, 0, 2)};
  const Json report = Json::parse(evaluationReport(test::handModel(), "m.yaml", inputs));
  EXPECT_EQ(report["kind"], "evaluation");
  EXPECT_EQ(report["model"], "m.yaml");
  EXPECT_EQ(report["classes"], (Json{"surface", "scatter", "linear"}));
  EXPECT_EQ(report["confusion"], (Json{{0, 0, 0}, {0, 6, 2}, {0, 0, 0}}));
  EXPECT_EQ(report["unknown"], (Json{2, 0, 0}));
  EXPECT_EQ(report["points"], 10);
  EXPECT_EQ(report["points_outside_map"], 2);
  EXPECT_EQ(report["recall"]["surface"], 0.0);
  EXPECT_EQ(report["recall"]["scatter"], 0.75);
  EXPECT_TRUE(report["recall"]["linear"].is_null());
  EXPECT_TRUE(report["precision"]["surface"].is_null());
  EXPECT_EQ(report["precision"]["scatter"], 1.0);
  EXPECT_EQ(report["precision"]["linear"], 0.0);
  EXPECT_NEAR(report["f1"]["scatter"].get<double>(), 12.0 / 14.0, 1e-12);
  EXPECT_EQ(report["mean_recall"], 0.375);
  EXPECT_EQ(report["mean_recall_in_map"], 0.75);
  EXPECT_NEAR(report["mean_f1"].get<double>(), 6.0 / 14.0, 1e-12);
  EXPECT_EQ(report["overall_accuracy"], 0.6);
  EXPECT_EQ(report["unknown_share"], 0.2);
  EXPECT_EQ(report["inputs"], (Json{"a", "b"}));
  EXPECT_NEAR(report["calibration"]["ece"].get<double>(), 0.0, 1e-9);
  ASSERT_EQ(report["calibration"]["bins"].size(), 1u);
  EXPECT_EQ(report["calibration"]["bins"][0]["accuracy"], 0.75);
  EXPECT_EQ(report["calibration"]["bins"][0]["share"], 1.0);
  ASSERT_EQ(report["per_input"].size(), 2u);
  EXPECT_EQ(report["per_input"][0]["input"], "a");
  EXPECT_EQ(report["per_input"][0]["pass"], "whole");
  EXPECT_EQ(report["per_input"][0]["recall"]["scatter"], 0.75);
  EXPECT_TRUE(report["per_input"][0]["recall"]["surface"].is_null());
  EXPECT_EQ(report["per_input"][1]["unknown_share"], 1.0);
}

TEST(LearnEvaluationReport, TheTableHasALineForEveryClass) {
  const std::string table = evaluationTable(test::handModel(), inputWith("a", 6, 2, 2).scores);
  for (const char* part : {"surface", "scatter", "linear", "0.750", "0.375", "unknown 0.200"}) {
    EXPECT_NE(table.find(part), std::string::npos) << part << " is not in\n" << table;
  }
}

}  // namespace
}  // namespace ladar_perception
