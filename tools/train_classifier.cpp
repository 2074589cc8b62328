// SPDX-License-Identifier: BSD-3-Clause
// Learns a classifier's mixtures from labelled clouds and bags.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

#include "command_line.h"
#include "labelled_source.h"
#include "ladar_perception/learn/calibrator.h"
#include "ladar_perception/learn/sample_collector.h"
#include "ladar_perception/learn/trainer.h"
#include "report_folder.h"

namespace ladar_perception {
namespace {

struct Options {
  LabelledSourceOptions source;
  std::string output;
  std::string report;
  std::vector<std::string> configs = {""};
  std::vector<std::string> features = {"standard"};
  std::vector<std::string> passes;
  std::string components = "auto";
  std::string choose_by = "held_out";
  std::string priors = "equal";
  std::size_t samples = 20000;
  uint64_t seed = 1;
  bool no_pictures = false;
};

constexpr int kMostComponents = 64;

void addOptions(CLI::App* app, Options* o) {
  o->source.addTo(app);
  app->add_option("--out", o->output, "model file to write")->required();
  app->add_option("--report", o->report, "folder to write report.json and pictures to");
  app->add_option("--config", o->configs,
                  "parameters, as config/terrain.yaml: voxels, supports and the map of streams and "
                  "bags; of several, separated by commas, every input goes through each")
      ->delimiter(',')
      ->allow_extra_args(false);
  app->add_option("--features", o->features,
                  "names of features and of sets of them, separated by commas")
      ->delimiter(',')
      ->allow_extra_args(false);
  app->add_option("--passes", o->passes,
                  "how clouds go through the pipeline: whole (in one scan), stream (as scans of a "
                  "vehicle that drives through it); if not given, whole,stream for Oakland tiles "
                  "and whole for others; bags are played as recorded")
      ->delimiter(',')
      ->allow_extra_args(false);
  app->add_option("--components", o->components, "Gaussians per class, or auto")
      ->check([](const std::string& text) {
        int value = 0;
        const bool fits = text == "auto" || (CLI::detail::lexical_cast(text, value) && value >= 1 &&
                                             value <= kMostComponents);
        return fits ? std::string() : "'" + text + "', expected auto or 1 to 64";
      })
      ->capture_default_str();
  app->add_option("--choose-by", o->choose_by,
                  "what auto goes by: held_out (likelihood of places left out) or bic")
      ->check(CLI::IsMember({"held_out", "bic"}))
      ->capture_default_str();
  app->add_option("--samples", o->samples, "voxels per class, at most")
      ->check(CLI::Range(100, 10000000))
      ->capture_default_str();
  app->add_option("--priors", o->priors,
                  "equal, or the classes' shares of the points that are trained on")
      ->check(CLI::IsMember({"equal", "training"}))
      ->capture_default_str();
  app->add_option("--seed", o->seed, "of sampling and of the start of EM")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->add_flag("--no-pictures", o->no_pictures, "report.json alone");
}

std::vector<Feature> featuresOf(const Options& options) {
  try {
    return parseFeatures(options.features);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(std::string("--features: ") + error.what());
  }
}

std::vector<Pass> parsePasses(const std::vector<std::string>& names) {
  std::vector<Pass> passes;
  for (const std::string& name : names) passes.push_back(passFromName(name));
  return passes;
}

TrainerOptions trainerOptions(const Options& options) {
  TrainerOptions trainer;
  if (options.components != "auto") trainer.mixture.candidates = {std::stoi(options.components)};
  trainer.mixture.choice =
      options.choose_by == "bic" ? ComponentChoice::kBic : ComponentChoice::kHeldOut;
  trainer.mixture.seed = options.seed;
  trainer.priors = options.priors == "training" ? Priors::kTraining : Priors::kEqual;
  return trainer;
}

uint64_t pointsOf(const SampleCollector& collector) {
  uint64_t points = 0;
  for (std::size_t c = 0; c < collector.classes(); ++c) points += collector.counts(c).points;
  return points;
}

/// A model is calibrated on places it was not learned from: in each of these folds by one learned
/// from the other.
constexpr std::size_t kFolds = 2;
constexpr double kStripe_m = 20.0;

/// Truth of the points of a fold, 0 for the others. A file is in one fold, but a single one is cut
/// into stripes.
std::vector<double> truthOfFold(const TerrainPipeline& pipeline, const std::vector<double>& truth,
                                std::size_t fold, std::size_t file, std::size_t files) {
  if (files > 1) return file % kFolds == fold ? truth : std::vector<double>(truth.size(), 0.0);
  const std::vector<VoxelIndex> voxels = voxelsBySlot(pipeline.map());
  std::vector<double> masked(truth.size(), 0.0);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const CellId cell = pipeline.pointCells()[i];
    if (cell == kNoCell) continue;
    const double x_m = voxels[pipeline.map().slotOf(cell)].x * pipeline.config().voxel_size_m;
    const auto stripe = static_cast<int64_t>(std::floor(x_m / kStripe_m));
    if (static_cast<std::size_t>(stripe & 1) == fold) masked[i] = truth[i];
  }
  return masked;
}

std::size_t fileCount(const LabelledSource& source) {
  std::size_t files = 0;
  for (const LabelledInput& input : source.inputs()) files += input.files.size();
  return files;
}

/// What is learned from: everything, and each fold alone.
struct Collected {
  Collected(const ClassifierModel& frame, const Options& options)
      : all(frame.classes.size(), frame.features.size(), options.samples, options.seed),
        folds(kFolds, all) {}
  SampleCollector all;
  std::vector<SampleCollector> folds;
};

/// A pass over a file with one of the configurations.
struct Run {
  Pass pass;
  const TerrainNodeConfig* config;
};

/// Every pass, with every configuration that makes a difference to it.
std::vector<Run> runsOf(const LabelledFile& file, const Options& options,
                        const std::vector<TerrainNodeConfig>& configs) {
  std::vector<Run> runs;
  for (const Pass pass : passesOf(file, parsePasses(options.passes))) {
    for (const TerrainNodeConfig& config : configs) {
      if (pass != Pass::kWhole || &config == &configs.front()) runs.push_back({pass, &config});
    }
  }
  return runs;
}

void collect(const LabelledSource& source, const Options& options,
             const std::vector<TerrainNodeConfig>& configs, const ClassifierModel& frame,
             Collected* collected) {
  const std::size_t files = fileCount(source);
  std::size_t number = 0;
  for (const LabelledInput& input : source.inputs()) {
    const uint64_t before = pointsOf(collected->all);
    collected->all.beginInput();
    for (SampleCollector& fold : collected->folds) fold.beginInput();
    for (const LabelledFile& file : input.files) {
      collected->all.beginFile();
      for (SampleCollector& fold : collected->folds) fold.beginFile();
      for (const Run& run : runsOf(file, options, configs)) {
        source.forEachLabelledScan(
            file, run.pass, *run.config, frame,
            [&](const TerrainPipeline& pipeline, const std::vector<double>& truth) {
              collected->all.add(pipeline, truth);
              for (std::size_t f = 0; f < kFolds; ++f) {
                collected->folds[f].add(pipeline, truthOfFold(pipeline, truth, f, number, files));
              }
            });
      }
      ++number;
    }
    if (pointsOf(collected->all) == before) {
      throw std::runtime_error(input.name + ": not one point has a label of a class");
    }
  }
}

/// Calibrates the model on what models of the same kind, each learned from the other fold, say of
/// every fold. Returns why it could not be done, or "".
std::string calibrate(const LabelledSource& source, const Options& options,
                      std::vector<TerrainNodeConfig> configs, const Collected& collected,
                      const TrainerOptions& trainer, ClassifierModel* model) {
  for (TerrainNodeConfig& config : configs) config.pipeline.smooth_labels = true;
  const std::size_t files = fileCount(source);
  Calibrator calibrator(model->classes.size());
  for (std::size_t f = 0; f < kFolds; ++f) {
    ClassifierModel other;
    try {
      other = trainLike(*model, collected.folds[1 - f], trainer);
    } catch (const std::runtime_error& error) {
      return std::string("half of the places is not enough to learn from: ") + error.what();
    }
    std::size_t number = 0;
    for (const LabelledInput& input : source.inputs()) {
      for (const LabelledFile& file : input.files) {
        for (const Run& run : runsOf(file, options, configs)) {
          if (files > 1 && number % kFolds != f) continue;
          source.forEachLabelledScan(
              file, run.pass, *run.config, other,
              [&](const TerrainPipeline& pipeline, const std::vector<double>& truth) {
                calibrator.add(pipeline, truthOfFold(pipeline, truth, f, number, files));
              });
        }
        ++number;
      }
    }
  }
  calibrator.calibrate(options.priors == "equal", model);
  return "";
}

std::string baseName(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

void addProvenance(const Options& options, ClassifierModel* model) {
  std::string inputs;
  for (const std::string& input : options.source.inputs) {
    inputs += (inputs.empty() ? "" : " ") + baseName(input);
  }
  model->provenance["inputs"] = inputs;
  model->provenance["program"] = "train_classifier";
  model->provenance["samples per class, at most"] = std::to_string(options.samples);
  if (options.passes.empty()) return;
  std::string passes;
  for (const std::string& pass : options.passes) passes += (passes.empty() ? "" : " ") + pass;
  model->provenance["passes"] = passes;
}

void printTraining(const Training& training) {
  for (std::size_t c = 0; c < training.classes.size(); ++c) {
    const ClassTraining& one = training.classes[c];
    std::printf("%s: %zu samples from %zu places, of %llu points; %zu components\n",
                training.model.classes[c].name.c_str(), one.samples.size(), one.counts.places,
                static_cast<unsigned long long>(one.counts.points), one.mixture.components.size());
  }
  for (const std::string& feature : training.constant_features) {
    std::fprintf(stderr, "warning: feature '%s' is the same in all samples: it tells nothing\n",
                 feature.c_str());
  }
}

void train(const Options& options) {
  std::vector<TerrainNodeConfig> configs;
  for (const std::string& path : options.configs) {
    configs.push_back(readConfigFile<TerrainNodeConfig>(path));
  }
  const std::vector<Feature> features = featuresOf(options);
  const LabelledSource source(options.source);
  std::unique_ptr<ReportFolder> report;
  if (!options.report.empty()) report = std::make_unique<ReportFolder>(options.report);
  checkWritable(options.output);  // which may lie in the report's folder

  const std::vector<std::string> names =
      source.mapping() ? source.mapping()->names : terrainClassNames();
  const std::vector<uint32_t> colors =
      source.mapping() ? source.mapping()->colors : classColors(names, {});
  ClassifierModel frame = modelFrame(names, colors, features, configs.front().pipeline);
  for (std::size_t i = 1; i < configs.size(); ++i) {
    const TerrainConfig& other = configs[i].pipeline;
    const std::string misfit = modelMisfit(frame, other.voxel_size_m, other.support_radius_voxels,
                                           other.support_kernel);
    if (misfit.empty()) continue;
    throw std::runtime_error(options.configs[i] + ": does not go with " + options.configs[0] +
                             ": " + misfit);
  }
  Collected collected(frame, options);
  collect(source, options, configs, frame, &collected);
  addProvenance(options, &frame);
  const TrainerOptions trainer = trainerOptions(options);
  Training training = trainClassifier(collected.all, frame, trainer);
  const std::string uncalibrated =
      calibrate(source, options, configs, collected, trainer, &training.model);
  if (!uncalibrated.empty()) {
    std::fprintf(stderr, "warning: the model is not calibrated: %s\n", uncalibrated.c_str());
  }
  saveClassifierModel(training.model, options.output);
  printTraining(training);
  std::printf("%s written\n", options.output.c_str());
  if (!report) return;
  report->writeReport(trainingReport(training, options.output, options.source.inputs));
  const std::string problem = options.no_pictures ? "" : report->drawPictures();
  if (!problem.empty()) std::fprintf(stderr, "warning: no pictures: %s\n", problem.c_str());
  std::printf("report in %s\n", report->path().c_str());
}

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  ladar_perception::Options options;
  CLI::App app(
      "Learns a model of two to sixteen classes from labelled clouds and from bags whose clouds "
      "have a field 'truth' (1 surface, 2 scatter, 3 linear, else ignored) or labels that "
      "--classes "
      "maps. Features are computed scan by scan, by the code that runs on the vehicle.");
  ladar_perception::addOptions(&app, &options);
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  try {
    ladar_perception::train(options);
  } catch (const std::exception& error) {
    std::cerr << "train_classifier: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
