// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "basin_study.h"
#include "ladar_perception/util/proportions.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;

template <typename Get>
double medianOf(const std::vector<Outcome>& outcomes, bool successes_only, Get get) {
  std::vector<double> values;
  for (const Outcome& outcome : outcomes) {
    if (outcome.success || !successes_only) values.push_back(get(outcome));
  }
  if (values.empty()) return -1.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Outcomes of the starts of a family.
std::vector<Outcome> ofFamily(const BasinReport& report, const MethodOutcomes& method,
                              const std::string& family) {
  std::vector<Outcome> some;
  for (std::size_t i = 0; i < report.starts.size(); ++i) {
    if (report.starts[i].family == family) some.push_back(method.outcomes[i]);
  }
  return some;
}

std::vector<bool> successesOf(const std::vector<Outcome>& outcomes) {
  std::vector<bool> successes;
  for (const Outcome& outcome : outcomes) successes.push_back(outcome.success);
  return successes;
}

/// The starts that shares are of: the random ones, or all where there are none.
std::vector<Outcome> judged(const BasinReport& report, const MethodOutcomes& method) {
  std::vector<Outcome> random = ofFamily(report, method, "random");
  return random.empty() ? method.outcomes : random;
}

struct Share {
  std::size_t successes = 0;
  std::size_t starts = 0;
  double value() const {
    return starts == 0 ? 0.0 : static_cast<double>(successes) / static_cast<double>(starts);
  }
};

Share shareOf(const std::vector<Outcome>& outcomes) {
  const auto isSuccess = [](const Outcome& o) { return o.success; };
  return {static_cast<std::size_t>(std::count_if(outcomes.begin(), outcomes.end(), isSuccess)),
          outcomes.size()};
}

Json rowsOf(const Eigen::Isometry3d& T) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back(Json::array());
    for (int col = 0; col < 4; ++col) rows.back().push_back(T(row, col));
  }
  return rows;
}

Json orNull(double value) { return value < 0.0 ? Json(nullptr) : Json(value); }

Json curvesJson(const BasinReport& report, const MethodOutcomes& method) {
  Json curves = Json::object();
  for (const char* family : {"x", "y", "yaw"}) {
    Json curve = {{"amount", Json::array()},  {"success", Json::array()},
                  {"error_m", Json::array()}, {"residual_m", Json::array()},
                  {"overlap", Json::array()}, {"ms", Json::array()}};
    for (std::size_t i = 0; i < report.starts.size(); ++i) {
      if (report.starts[i].family != family) continue;
      const Outcome& outcome = method.outcomes[i];
      curve["amount"].push_back(report.starts[i].amount);
      curve["success"].push_back(outcome.success);
      curve["error_m"].push_back(outcome.error_m);
      curve["residual_m"].push_back(outcome.residual_m);
      curve["overlap"].push_back(outcome.overlap);
      curve["ms"].push_back(outcome.ms);
    }
    if (!curve["amount"].empty()) curves[family] = curve;
  }
  return curves;
}

Json startsJson(const BasinReport& report, const MethodOutcomes& method) {
  Json starts = Json::array();
  for (std::size_t i = 0; i < report.starts.size(); ++i) {
    if (report.starts[i].family != "random") continue;
    const Outcome& outcome = method.outcomes[i];
    starts.push_back({{"success", outcome.success},
                      {"fixed_point", outcome.fixed_point},
                      {"error_m", outcome.error_m},
                      {"error_deg", outcome.error_deg},
                      {"residual_m", outcome.residual_m},
                      {"overlap", outcome.overlap},
                      {"ms", outcome.ms},
                      {"verdict", verdictName(outcome.verdict)}});
  }
  return starts;
}

Json methodJson(const BasinReport& report, const MethodOutcomes& method) {
  const std::vector<Outcome> outcomes = judged(report, method);
  const Share share = shareOf(outcomes);
  const Interval interval = wilsonInterval(share.successes, share.starts);
  const auto isFixedPoint = [](const Outcome& o) { return o.fixed_point; };
  const auto fixed = std::count_if(outcomes.begin(), outcomes.end(), isFixedPoint);
  return {
      {"success", share.value()},
      {"starts", share.starts},
      {"interval", {interval.low, interval.high}},
      {"median_ms", orNull(medianOf(outcomes, false, [](const Outcome& o) { return o.ms; }))},
      {"final_error_m",
       orNull(medianOf(outcomes, true, [](const Outcome& o) { return o.error_m; }))},
      {"final_error_deg",
       orNull(medianOf(outcomes, true, [](const Outcome& o) { return o.error_deg; }))},
      {"final_residual_m",
       orNull(medianOf(outcomes, true, [](const Outcome& o) { return o.residual_m; }))},
      {"fixed_point_success",
       outcomes.empty() ? 0.0 : static_cast<double>(fixed) / static_cast<double>(outcomes.size())},
      {"points", {method.points_a, method.points_b}},
      {"sampling_ms", method.sampling_ms},
      {"prepare_ms", method.prepare_ms},
      {"from_truth",
       {{"error_m", method.from_truth.error_m},
        {"error_deg", method.from_truth.error_deg},
        {"verdict", verdictName(method.from_truth.verdict)},
        {"T_a_b", rowsOf(method.T_a_b_from_truth)}}},
      {"curves", curvesJson(report, method)},
      {"random", startsJson(report, method)}};
}

Json comparisonsJson(const BasinReport& report) {
  Json comparisons = Json::array();
  for (std::size_t i = 0; i < report.methods.size(); ++i) {
    for (std::size_t j = i + 1; j < report.methods.size(); ++j) {
      const PairedComparison pair = mcnemar(successesOf(judged(report, report.methods[i])),
                                            successesOf(judged(report, report.methods[j])));
      comparisons.push_back({{"a", report.methods[i].method},
                             {"b", report.methods[j].method},
                             {"only_a", pair.only_a},
                             {"only_b", pair.only_b},
                             {"p_value", pair.p_value}});
    }
  }
  return comparisons;
}

}  // namespace

std::string basinJson(const BasinReport& report) {
  Json json = {{"cloud_a", report.cloud_a},
               {"cloud_b", report.cloud_b},
               {"solver", report.solver},
               {"count", report.count},
               {"truth_from", report.truth},
               {"T_a_b_truth", rowsOf(report.T_a_b_truth)},
               {"success_m", kSuccess_m},
               {"success_deg", kSuccess_deg},
               {"max_translation_m", report.options.max_translation_m},
               {"max_rotation_deg", report.options.max_rotation_deg},
               {"seed", report.options.seed},
               {"methods", Json::object()},
               {"comparisons", comparisonsJson(report)}};
  for (const MethodOutcomes& method : report.methods) {
    json["methods"][method.method] = methodJson(report, method);
  }
  return json.dump(1) + "\n";
}

std::string describeMethod(const BasinReport& report, const MethodOutcomes& method) {
  const std::vector<Outcome> outcomes = judged(report, method);
  const Share share = shareOf(outcomes);
  const Interval interval = wilsonInterval(share.successes, share.starts);
  const double error_m = medianOf(outcomes, true, [](const Outcome& o) { return o.error_m; });
  char line[256];
  std::snprintf(line, sizeof(line),
                "%-16s %7zu %7zu points  success %5.1f %% [%.1f, %.1f] of %zu  median %.1f ms",
                method.method.c_str(), method.points_a, method.points_b, 100.0 * share.value(),
                100.0 * interval.low, 100.0 * interval.high, share.starts,
                medianOf(outcomes, false, [](const Outcome& o) { return o.ms; }));
  std::string text = line;
  std::snprintf(line, sizeof(line), "  error %.1f mm", 1e3 * error_m);
  return text + (error_m < 0.0 ? "  error -" : line);
}

}  // namespace ladar_perception
