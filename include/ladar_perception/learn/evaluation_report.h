// SPDX-License-Identifier: BSD-3-Clause
// What is told of an evaluation: report.json, and a table for people.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/learn/label_scores.h"

namespace ladar_perception {

/// One input's scores.
struct EvaluatedInput {
  std::string name;
  std::string pass;  ///< "whole", "stream" or "recorded"
  LabelScores scores;
};

/// The JSON text: classes; confusion, a row per true class, a column per class; unknown, a count
/// per true class; recall, precision and f1 by name (null where nothing tells them); mean_recall,
/// mean_f1, overall_accuracy, unknown_share, points, points_outside_map, mean_recall_in_map;
/// calibration {ece, class_balanced_ece, bins, class_balanced_bins}; inputs, and per_input with the
/// same for each.
std::string evaluationReport(const ClassifierModel& model, const std::string& model_path,
                             const std::vector<EvaluatedInput>& inputs);
/// Recall, precision and F1 of every class and the means, as lines of text.
std::string evaluationTable(const ClassifierModel& model, const LabelScores& scores);
/// All inputs together.
LabelScores totalOf(const std::vector<EvaluatedInput>& inputs, std::size_t classes);

}  // namespace ladar_perception
