// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/evaluation_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "json_parts.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json binsJson(const Reliability& reliability) {
  Json bins = Json::array();
  for (const ReliabilityBin& bin : reliability.bins) {
    bins.push_back(
        {{"confidence", bin.confidence}, {"accuracy", bin.accuracy}, {"share", bin.share}});
  }
  return bins;
}

void addScores(const ClassifierModel& model, const LabelScores& scores, Json* json) {
  Json& out = *json;
  out["points"] = scores.points();
  out["points_outside_map"] = scores.pointsOutsideMap();
  const std::size_t classes = scores.classes();
  for (const char* key : {"confusion", "unknown"}) out[key] = Json::array();
  for (const char* key : {"recall", "precision", "f1"}) out[key] = Json::object();
  for (std::size_t truth = 1; truth <= classes; ++truth) {
    Json row = Json::array();
    for (std::size_t label = 1; label <= classes; ++label)
      row.push_back(scores.count(truth, label));
    out["confusion"].push_back(row);
    out["unknown"].push_back(scores.count(truth, 0));
    const std::string& name = model.classes[truth - 1].name;
    out["recall"][name] = orNull(scores.recall(truth));
    out["precision"][name] = orNull(scores.precision(truth));
    out["f1"][name] = orNull(scores.f1(truth));
  }
  out["mean_recall"] = orNull(scores.meanRecall());
  out["mean_f1"] = orNull(scores.meanF1());
  out["overall_accuracy"] = orNull(scores.overallAccuracy());
  out["unknown_share"] = orNull(scores.unknownShare());
  out["mean_recall_in_map"] = orNull(scores.meanRecallInMap());
  const Reliability plain = scores.reliability(false);
  const Reliability balanced = scores.reliability(true);
  out["calibration"] = {{"ece", plain.ece},
                        {"class_balanced_ece", balanced.ece},
                        {"bins", binsJson(plain)},
                        {"class_balanced_bins", binsJson(balanced)}};
}

std::string percent(const std::optional<double>& share) {
  if (!share) return "      -";
  char text[16];
  std::snprintf(text, sizeof(text), "%7.3f", *share);
  return text;
}

}  // namespace

LabelScores totalOf(const std::vector<EvaluatedInput>& inputs, std::size_t classes) {
  LabelScores total(classes);
  for (const EvaluatedInput& input : inputs) total += input.scores;
  return total;
}

std::string evaluationReport(const ClassifierModel& model, const std::string& model_path,
                             const std::vector<EvaluatedInput>& inputs) {
  Json json;
  json["kind"] = "evaluation";
  json["model"] = model_path;
  json["classes"] = Json::array();
  json["colors"] = Json::array();
  for (const ModelClass& model_class : model.classes) {
    json["classes"].push_back(model_class.name);
    json["colors"].push_back(colorText(model_class.rgb));
  }
  json["inputs"] = Json::array();
  for (const EvaluatedInput& input : inputs) json["inputs"].push_back(input.name);
  addScores(model, totalOf(inputs, model.classes.size()), &json);
  json["per_input"] = Json::array();
  for (const EvaluatedInput& input : inputs) {
    Json one = {{"input", input.name}, {"pass", input.pass}};
    addScores(model, input.scores, &one);
    json["per_input"].push_back(one);
  }
  return json.dump(1) + "\n";
}

std::string evaluationTable(const ClassifierModel& model, const LabelScores& scores) {
  std::string table;
  char line[256];
  std::snprintf(line, sizeof(line), "%-16s %10s %7s %9s %7s\n", "class", "points", "recall",
                "precision", "F1");
  table += line;
  for (std::size_t truth = 1; truth <= scores.classes(); ++truth) {
    std::snprintf(line, sizeof(line), "%-16s %10llu %s   %s %s\n",
                  model.classes[truth - 1].name.c_str(),
                  static_cast<unsigned long long>(scores.truthCount(truth)),
                  percent(scores.recall(truth)).c_str(), percent(scores.precision(truth)).c_str(),
                  percent(scores.f1(truth)).c_str());
    table += line;
  }
  std::snprintf(line, sizeof(line), "%-16s %10llu %s   %7s %s\n", "mean",
                static_cast<unsigned long long>(scores.points()),
                percent(scores.meanRecall()).c_str(), "", percent(scores.meanF1()).c_str());
  table += line;
  std::snprintf(line, sizeof(line),
                "overall accuracy %s, unknown %s (outside the map %llu points), calibration error "
                "%s, class-balanced %s\n",
                percent(scores.overallAccuracy()).substr(2).c_str(),
                percent(scores.unknownShare()).substr(2).c_str(),
                static_cast<unsigned long long>(scores.pointsOutsideMap()),
                percent(scores.reliability(false).ece).substr(2).c_str(),
                percent(scores.reliability(true).ece).substr(2).c_str());
  return table + line;
}

}  // namespace ladar_perception
