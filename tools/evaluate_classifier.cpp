// SPDX-License-Identifier: BSD-3-Clause
// Judges a classifier on labelled clouds and bags.
#include <cstdio>
#include <iostream>
#include <memory>

#include "command_line.h"
#include "labelled_source.h"
#include "ladar_perception/learn/evaluation_report.h"
#include "ladar_perception/learn/picture_samples.h"
#include "package_path.h"
#include "report_folder.h"

namespace ladar_perception {
namespace {

struct Options {
  LabelledSourceOptions source;
  std::string model;
  std::string report;
  std::string config;
  std::string pass = "whole";
  int threads = 0;
  bool no_pictures = false;
};

// Of the points that are drawn; what is counted has none.
constexpr uint64_t kPictureSeed = 1;

void addOptions(CLI::App* app, Options* o) {
  o->source.addTo(app);
  app->add_option("--model", o->model, "model to judge")->required();
  app->add_option("--report", o->report, "folder to write report.json and pictures to");
  app->add_option("--config", o->config,
                  "parameters, as config/terrain.yaml; voxels and supports are the model's");
  app->add_option(
         "--pass", o->pass,
         "how clouds go through the pipeline: whole (in one scan) or stream (as scans of a "
         "vehicle that drives through it, with the map of --config); bags are played as "
         "recorded")
      ->check(CLI::IsMember({"whole", "stream"}))
      ->capture_default_str();
  app->add_option("--threads", o->threads, "in place of the configuration's")
      ->check(CLI::Range(1, 64));
  app->add_flag("--no-pictures", o->no_pictures, "report.json alone");
}

EvaluatedInput evaluate(const LabelledSource& source, const LabelledInput& input, Pass pass,
                        const TerrainNodeConfig& config, const ClassifierModel& model,
                        PictureSamples* pictures) {
  EvaluatedInput evaluated{input.name, "", LabelScores(model.classes.size())};
  if (pictures != nullptr) pictures->beginCloud(input.name);
  bool first = true;
  for (const LabelledFile& file : input.files) {
    const Pass used = passesOf(file, {pass}).front();
    evaluated.pass = passName(used);
    source.forEachLabelledScan(
        file, used, config, model,
        [&](const TerrainPipeline& pipeline, const std::vector<double>& truth) {
          evaluated.scores.add(truth, pipeline.pointLabels(), pipeline.pointCells());
          // Single scans have a place of their own each: drawn over each other they show nothing.
          if (pictures != nullptr && first) pictures->add(pipeline, truth);
        });
    first = false;
  }
  if (evaluated.scores.points() == 0) {
    throw std::runtime_error(input.name + ": not one point has a label of a class of the model");
  }
  return evaluated;
}

void run(const Options& options) {
  TerrainNodeConfig config = readConfigFile<TerrainNodeConfig>(options.config);
  const ClassifierModel model = loadClassifierModel(resolvePackagePath(options.model));
  config.pipeline = configFor(model, config.pipeline);
  if (options.threads > 0) config.pipeline.threads = options.threads;
  const LabelledSource source(options.source);
  std::unique_ptr<ReportFolder> report;
  std::unique_ptr<PictureSamples> pictures;
  if (!options.report.empty()) {
    report = std::make_unique<ReportFolder>(options.report);
    if (!options.no_pictures) pictures = std::make_unique<PictureSamples>(model, kPictureSeed);
  }
  std::vector<EvaluatedInput> evaluated;
  for (const LabelledInput& input : source.inputs()) {
    evaluated.push_back(
        evaluate(source, input, passFromName(options.pass), config, model, pictures.get()));
  }
  for (const EvaluatedInput& input : evaluated) {
    std::printf("%s (%s): mean recall %.3f, mean F1 %.3f, %llu points\n", input.name.c_str(),
                input.pass.c_str(), *input.scores.meanRecall(), *input.scores.meanF1(),
                static_cast<unsigned long long>(input.scores.points()));
  }
  std::fputs(evaluationTable(model, totalOf(evaluated, model.classes.size())).c_str(), stdout);
  if (!report) return;
  report->writeReport(evaluationReport(model, options.model, evaluated));
  if (pictures) {
    pictures->write(report->path());
    const std::string problem = report->drawPictures();
    if (!problem.empty()) std::fprintf(stderr, "warning: no pictures: %s\n", problem.c_str());
  }
  std::printf("report in %s\n", report->path().c_str());
}

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  ladar_perception::Options options;
  CLI::App app(
      "Judges a model on labelled clouds and bags: confusion, recall, precision, F1 and "
      "calibration "
      "by report.json, a table and pictures. Every labelled point counts; unknown ones are wrong.");
  ladar_perception::addOptions(&app, &options);
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  try {
    ladar_perception::run(options);
  } catch (const std::exception& error) {
    std::cerr << "evaluate_classifier: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
