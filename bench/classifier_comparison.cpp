// SPDX-License-Identifier: BSD-3-Clause
// Our pipeline and CGAL's classification on the same tiles of the Oakland 3-D set: trained on
// part3_am and part3_an, scored and timed on part2_ac and part2_ah.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "labeled_tile.h"
#include "ladar_perception/util/dispatch.h"
#include "rival_cgal.h"
#include "stopwatch.h"
#include "strategy_timer.h"
#include "whole_tile.h"

namespace ladar_perception::bench {
namespace {

using nlohmann::json;

struct Options {
  std::string tiles;
  std::string output;
  std::vector<std::string> tasks;
  int rounds = 5;
  bool quick = false;
};

/// Classes to tell apart, and our model of them.
struct Task {
  std::string name;
  ClassMapping mapping;
  ClassifierModel model;
  Labels train_truth;
  std::vector<Labels> test_truth;  // by tile
};

struct Data {
  LabeledTile train;
  std::vector<LabeledTile> test;
  std::size_t testPoints() const {
    std::size_t points = 0;
    for (const LabeledTile& tile : test) points += tile.points_m.size();
    return points;
  }
};

struct CgalSettings {
  CgalFeatureSettings features;
  CgalForestSettings forest;
  CgalRegularization regularization = CgalRegularization::kNone;
};

/// One step of the manual's example: the smallest scale from the points' spacing, five scales, 25
/// trees of depth 20, all training points, a graph cut.
CgalSettings manualSettings() { return {{}, {}, CgalRegularization::kGraphCut}; }

std::vector<CgalFeatureSettings> featureSettings(bool quick) {
  if (quick) return {{-1.0, 3}, {}};
  std::vector<CgalFeatureSettings> all;
  for (const double voxel_size_m : {-1.0, 0.05, 0.1, 0.15, 0.2}) {
    for (const std::size_t scales : {3U, 4U, 5U, 6U}) all.push_back({voxel_size_m, scales});
  }
  return all;
}

std::vector<CgalForestSettings> forestSettings(bool quick) {
  if (quick) return {{25, 20, 0}, {25, 20, 2500}};
  return {{25, 20, 0}, {25, 20, 1000}, {25, 20, 2500}, {25, 10, 2500}, {100, 20, 2500}};
}

json asJson(const ClassScore& score) {
  return {{"mean_recall", meanOf(score.recall())},
          {"mean_f1", meanOf(score.f1())},
          {"recall", score.recall()},
          {"f1", score.f1()}};
}

json asJson(const CgalSettings& settings) {
  return {{"voxel_size_m", settings.features.voxel_size_m},
          {"scales", settings.features.scales},
          {"trees", settings.forest.trees},
          {"depth", settings.forest.depth},
          {"samples_per_class", settings.forest.samples_per_class},
          {"regularization", cgalRegularizationName(settings.regularization)}};
}

std::vector<Task> readTasks(const Options& options, const Data& data) {
  std::vector<Task> tasks;
  for (std::size_t i = 0; i + 2 < options.tasks.size(); i += 3) {
    Task task{options.tasks[i],
              loadClassMapping(options.tasks[i + 1]),
              loadClassifierModel(options.tasks[i + 2]),
              {},
              {}};
    const std::size_t classes = task.mapping.names.size();
    bool same = task.model.classes.size() == classes;
    for (std::size_t c = 0; same && c < classes; ++c) {
      same = task.model.classes[c].name == task.mapping.names[c];
    }
    if (!same) {
      throw std::runtime_error(options.tasks[i + 2] + ": its classes are not those of " +
                               options.tasks[i + 1] + ", in that order");
    }
    task.train_truth = truthOf(data.train, task.mapping);
    for (const LabeledTile& tile : data.test)
      task.test_truth.push_back(truthOf(tile, task.mapping));
    tasks.push_back(std::move(task));
  }
  return tasks;
}

/// CGAL with one choice of features, on all tiles.
class CgalRun {
 public:
  CgalRun(const Data& data, const CgalFeatureSettings& settings)
      : settings_(settings), train_(data.train.points_m), test_points_(data.testPoints()) {
    train_.computeFeatures(settings);
    for (const LabeledTile& tile : data.test) test_.emplace_back(tile.points_m);
    computeTestFeatures();
  }

  /// Returns the time it takes, ns a point.
  double computeTestFeatures() {
    for (CgalCloud& cloud : test_) cloud.clear();
    const Stopwatch stopwatch;
    for (CgalCloud& cloud : test_) cloud.computeFeatures(settings_);
    return stopwatch.cpu_ns() / static_cast<double>(test_points_);
  }
  CgalForest train(const Task& task, const CgalForestSettings& settings) const {
    return {train_, task.train_truth, task.mapping.names.size(), settings};
  }
  /// Returns the time it takes, ns a point; `score` may be null.
  double classify(const Task& task, const CgalForest& forest, CgalRegularization regularization,
                  ClassScore* score) const {
    double ns = 0.0;
    for (std::size_t i = 0; i < test_.size(); ++i) {
      const CgalClassifier classifier(forest, test_[i]);
      const Stopwatch stopwatch;
      const Labels labels = classifier.classify(regularization);
      ns += stopwatch.cpu_ns();
      if (score != nullptr) score->add(task.test_truth[i], labels);
    }
    return ns / static_cast<double>(test_points_);
  }
  std::size_t features() const { return train_.features(); }

 private:
  CgalFeatureSettings settings_;
  CgalCloud train_;
  std::vector<CgalCloud> test_;
  std::size_t test_points_;
};

struct Trial {
  CgalSettings settings;
  double mean_recall = -1.0;
};

/// Scores CGAL with each choice of settings: all forests as they are, and the best of them with
/// everything that may follow. Returns the best per task, judged by the very tiles it is compared
/// on: no one who uses it could choose better.
std::vector<Trial> tryCgal(const Data& data, const std::vector<Task>& tasks, bool quick,
                           json* trials) {
  std::vector<Trial> best(tasks.size());
  for (const CgalFeatureSettings& features : featureSettings(quick)) {
    CgalRun run(data, features);
    const double feature_ns = run.computeTestFeatures();
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const auto tryOne = [&](const CgalForest& forest, const CgalSettings& settings) {
        ClassScore score(tasks[t].mapping.names.size());
        const double ns = run.classify(tasks[t], forest, settings.regularization, &score);
        trials->push_back({{"task", tasks[t].name},
                           {"settings", asJson(settings)},
                           {"features", run.features()},
                           {"feature_ns", feature_ns},
                           {"classification_ns", ns},
                           {"score", asJson(score)}});
        return Trial{settings, meanOf(score.recall())};
      };
      Trial plain;
      for (const CgalForestSettings& forest : forestSettings(quick)) {
        const Trial trial = tryOne(run.train(tasks[t], forest), {features, forest, {}});
        if (trial.mean_recall > plain.mean_recall) plain = trial;
      }
      if (plain.mean_recall > best[t].mean_recall) best[t] = plain;
      const CgalForest forest = run.train(tasks[t], plain.settings.forest);
      for (int r = 1; r < kCgalRegularizations; ++r) {
        CgalSettings settings = plain.settings;
        settings.regularization = static_cast<CgalRegularization>(r);
        const Trial trial = tryOne(forest, settings);
        if (trial.mean_recall > best[t].mean_recall) best[t] = trial;
      }
      std::printf("%s: voxel %g m, %zu scales: %.3f, the best so far %.3f\n", tasks[t].name.c_str(),
                  features.voxel_size_m, features.scales, plain.mean_recall, best[t].mean_recall);
    }
  }
  return best;
}

/// CGAL with settled settings: times of all that may follow the forest, taken again and again.
class CgalTimer {
 public:
  CgalTimer(std::string name, const Data& data, const Task& task, const CgalSettings& settings)
      : name_(std::move(name)),
        task_(task),
        settings_(settings),
        run_(data, settings.features),
        forest_(run_.train(task, settings.forest)) {}

  void takeTurn() {
    feature_ns_.push_back(run_.computeTestFeatures());
    for (int r = 0; r < kCgalRegularizations; ++r) {
      classify_ns_[r].push_back(
          run_.classify(task_, forest_, static_cast<CgalRegularization>(r), nullptr));
    }
  }
  void report(json* rows) const {
    for (int r = 0; r < kCgalRegularizations; ++r) {
      CgalSettings settings = settings_;
      settings.regularization = static_cast<CgalRegularization>(r);
      ClassScore score(task_.mapping.names.size());
      run_.classify(task_, forest_, settings.regularization, &score);
      rows->push_back({{"task", task_.name},
                       {"name", name_},
                       {"chosen", settings_.regularization == settings.regularization},
                       {"settings", asJson(settings)},
                       {"feature_ns", median(feature_ns_)},
                       {"classification_ns", median(classify_ns_[r])},
                       {"score", asJson(score)}});
    }
  }

 private:
  std::string name_;
  const Task& task_;
  CgalSettings settings_;
  CgalRun run_;
  CgalForest forest_;
  std::vector<double> feature_ns_;
  std::vector<double> classify_ns_[kCgalRegularizations];
};

class OurTimer {
 public:
  OurTimer(const Data& data, const Task& task) : task_(task), points_(data.testPoints()) {
    for (const LabeledTile& tile : data.test)
      tiles_.push_back(std::make_unique<WholeTile>(tile.points_m, task.model));
  }

  void takeTurn() {
    for (const auto& tile : tiles_) tile->clear();
    const Stopwatch stopwatch;
    for (const auto& tile : tiles_) tile->process();
    ns_.push_back(stopwatch.cpu_ns() / static_cast<double>(points_));
  }
  void report(json* rows) const {
    ClassScore score(task_.mapping.names.size());
    std::size_t voxels = 0;
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      score.add(task_.test_truth[i], tiles_[i]->labels());
      voxels += tiles_[i]->report().occupied_voxels;
    }
    rows->push_back({{"task", task_.name},
                     {"name", "ours"},
                     {"features", task_.model.features.size()},
                     {"total_ns", median(ns_)},
                     {"voxels", voxels},
                     {"score", asJson(score)}});
  }

 private:
  const Task& task_;
  std::size_t points_;
  std::vector<std::unique_ptr<WholeTile>> tiles_;
  std::vector<double> ns_;
};

/// Everybody takes turns, so that what else the machine does hits all alike.
void timeInTurns(const Data& data, const Task& task, const CgalSettings& best, int rounds,
                 json* rows) {
  OurTimer ours(data, task);
  std::vector<CgalTimer> rivals;
  rivals.emplace_back("CGAL, as in its manual", data, task, manualSettings());
  rivals.emplace_back("CGAL, best settings", data, task, best);
  for (int round = 0; round < rounds; ++round) {
    ours.takeTurn();
    for (CgalTimer& rival : rivals) rival.takeTurn();
    std::printf("%s: round %d of %d\n", task.name.c_str(), round + 1, rounds);
  }
  ours.report(rows);
  for (const CgalTimer& rival : rivals) rival.report(rows);
}

void compare(const Options& options) {
  const auto tile = [&](const char* name) {
    return options.tiles + "/oakland_" + name + ".xyz_label_conf";
  };
  // The two tiles CGAL trains on touch each other and have one frame: one cloud to it.
  const Data data = {readTiles({tile("part3_am"), tile("part3_an")}),
                     {readTiles({tile("part2_ac")}), readTiles({tile("part2_ah")})}};
  const std::vector<Task> tasks = readTasks(options, data);
  json result = {{"test_points", data.testPoints()},
                 {"rounds", options.rounds},
                 {"vector_level", vectorLevelName(vectorLevel())},
                 {"trials", json::array()},
                 {"rows", json::array()},
                 {"classes", json::object()}};
  for (const Task& task : tasks) result["classes"][task.name] = task.mapping.names;
  const std::vector<Trial> best = tryCgal(data, tasks, options.quick, &result["trials"]);
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    timeInTurns(data, tasks[t], best[t].settings, options.rounds, &result["rows"]);
  }
  std::ofstream out(options.output);
  out << result.dump(1) << "\n";
  if (!out.flush()) throw std::runtime_error(options.output + ": cannot be written");
}

}  // namespace
}  // namespace ladar_perception::bench

int main(int argc, char** argv) {
  ladar_perception::bench::Options options;
  CLI::App app("Compares the pipeline with CGAL's classification on four tiles.");
  app.add_option("--tiles", options.tiles, "folder of the tiles")->required();
  app.add_option("--out", options.output, "JSON file to write")->required();
  app.add_option("--task", options.tasks, "name, class mapping and model of it; may be repeated")
      ->required()
      ->type_size(3)
      ->expected(1, 100);
  app.add_option("--rounds", options.rounds, "turns of the clock")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_flag("--quick", options.quick, "try few settings of CGAL");
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // progress, into a pipe too
  try {
    ladar_perception::bench::compare(options);
  } catch (const std::exception& error) {
    std::cerr << "classifier_comparison: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
