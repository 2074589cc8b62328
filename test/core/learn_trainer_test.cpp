// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <nlohmann/json.hpp>

#include "hand_model.h"
#include "io_test_files.h"
#include "ladar_perception/learn/trainer.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "terrain_scenes.h"

namespace ladar_perception {
namespace {

const std::vector<std::string> kNames = {"ground", "leaves", "wire"};
const std::vector<uint32_t> kColors = {0x102030, 0x405060, 0x708090};
const std::vector<Feature> kFeatures = {
    {Quantity::kCbrtScatter}, {Quantity::kCbrtSurface}, {Quantity::kCbrtLinear}};

/// What a pipeline with these features sees of the mixed scene.
SampleCollector collect(const ClassifierModel& frame, bool with_wire = true) {
  SampleCollector collector(3, frame.features.size(), 400, 1);
  TerrainConfig config;
  config.min_range_m = 0.0;
  for (int seed = 1; seed <= 2; ++seed) {
    collector.beginInput();
    TerrainPipeline pipeline(config, frame);
    pipeline.keepFeatures(true);
    const test::MixedScene scene(seed);
    test::processAt(&pipeline, scene.points, Eigen::Vector3d::Zero());
    std::vector<double> truth(scene.points.size(), 1.0);
    std::fill(truth.begin() + 20000, truth.begin() + 21000, with_wire ? 3.0 : 0.0);
    std::fill(truth.begin() + 21000, truth.end(), 2.0);
    collector.add(pipeline, truth);
  }
  return collector;
}

TrainerOptions fewComponents() {
  TrainerOptions options;
  options.mixture.candidates = {1, 2};
  return options;
}

Training trainOnScene(const TrainerOptions& options = fewComponents()) {
  const ClassifierModel frame = modelFrame(kNames, kColors, kFeatures, {});
  return trainClassifier(collect(frame), frame, options);
}

TEST(LearnTrainer, TheModelLabelsTheSceneItLearnedFrom) {
  const Training training = trainOnScene();
  const ClassifierModel& model = training.model;
  // What is written can be read.
  const ClassifierModel read = parseClassifierModel(formatClassifierModel(model), "model.yaml");
  ASSERT_EQ(read.classes.size(), 3u);
  EXPECT_EQ(read.classes[1].name, "leaves");
  EXPECT_EQ(read.classes[1].rgb, 0x405060u);
  TerrainPipeline pipeline({}, read);
  const test::MixedScene scene(5);
  test::processAt(&pipeline, scene.points, Eigen::Vector3d::Zero());
  const auto share = [&](std::size_t begin, std::size_t end, uint8_t label) {
    std::size_t right = 0;
    for (std::size_t i = begin; i < end; ++i) right += pipeline.pointLabels()[i].label == label;
    return static_cast<double>(right) / static_cast<double>(end - begin);
  };
  EXPECT_GT(share(0, 20000, 1), 0.95);
  EXPECT_GT(share(20000, 21000, 3), 0.95);
  EXPECT_GT(share(21000, 25000, 2), 0.9);
}

TEST(LearnTrainer, RecordsWhatItLearnedFrom) {
  const ClassifierModel model = trainOnScene().model;
  EXPECT_EQ(model.provenance.at("points of wire"), "2000");
  EXPECT_EQ(model.provenance.at("samples of ground"), "400");
  EXPECT_EQ(model.provenance.at("seed"), "1");
  EXPECT_EQ(model.provenance.at("priors"), "equal");
  EXPECT_GT(std::stod(model.provenance.at("deviation of cbrt_linear")), 0.01);
}

TEST(LearnTrainer, PriorsAreEqualOrShares) {
  for (const ModelClass& one : trainOnScene().model.classes) EXPECT_EQ(one.prior, 1.0);
  TrainerOptions options = fewComponents();
  options.priors = Priors::kTraining;
  const Training training = trainOnScene(options);
  EXPECT_NEAR(training.model.classes[0].prior, 0.8, 1e-9);
  EXPECT_NEAR(training.model.classes[1].prior, 0.16, 1e-9);
  EXPECT_NEAR(training.model.classes[2].prior, 0.04, 1e-9);
}

TEST(LearnTrainer, NextToNothingLearnedFromIsUnknown) {
  const Training training = trainOnScene();
  std::vector<GaussianMixture> mixtures;
  for (const ModelClass& one : training.model.classes) mixtures.emplace_back(one.mixture);
  for (const ClassTraining& one : training.classes) {
    std::size_t unknown = 0;
    for (Eigen::Index i = 0; i < one.samples.values.cols(); ++i) {
      double best = -1e30;
      for (const GaussianMixture& mixture : mixtures) {
        best = std::max(best, logLikelihoods(mixture, one.samples.values.col(i))[0]);
      }
      unknown += best < training.model.unknown_log_likelihood ? 1 : 0;
    }
    EXPECT_LE(unknown, one.samples.size() / 1000 + 1);
  }
  // Metres where there are decimetres.
  const Eigen::VectorXd absurd = Eigen::VectorXd::Constant(3, 5.0);
  for (const GaussianMixture& mixture : mixtures) {
    EXPECT_LT(logLikelihoods(mixture, absurd)[0], training.model.unknown_log_likelihood);
  }
}

TEST(LearnTrainer, VariancesHaveATenthOfTheFeaturesOnTop) {
  TrainerOptions options;
  options.mixture.candidates = {1};
  const Training training = trainOnScene(options);
  for (std::size_t c = 0; c < 3; ++c) {
    const Eigen::MatrixXd& values = training.classes[c].samples.values;
    const Eigen::MatrixXd centred = values.colwise() - values.rowwise().mean();
    for (int f = 0; f < 3; ++f) {
      const double own = centred.row(f).squaredNorm() / static_cast<double>(values.cols());
      const double floor = 0.1 * training.deviation[f] * training.deviation[f];
      EXPECT_NEAR(training.model.classes[c].mixture[0].covariance(f, f), own + floor, 0.02 * floor);
    }
  }
}

TEST(LearnTrainer, NamesTheClassWithTooFewSamples) {
  const ClassifierModel frame = modelFrame(kNames, kColors, kFeatures, {});
  expectError([&] { trainClassifier(collect(frame, false), frame, {}); },
              {"'wire'", "0 samples", "0 labelled points", "at least 50"});
}

TEST(LearnTrainer, AConstantFeatureSaysNothing) {
  // The map is one flat plane: the normal points up everywhere.
  const std::vector<Feature> features = {{Quantity::kScatter}, {Quantity::kCbrtLinear}};
  const ClassifierModel frame = modelFrame({"a", "b"}, {1, 2}, features, {});
  SampleCollector collector(2, 2, 300, 1);
  TerrainPipeline pipeline({}, frame);
  pipeline.keepFeatures(true);
  std::vector<Eigen::Vector3d> points;
  std::vector<double> truth;
  for (int i = 0; i < 6000; ++i) {
    const bool dense = i % 2 == 0;
    points.push_back({(dense ? 2.0 : -8.0) + 0.1 * (i % 60), -3.0 + 0.1 * (i / 100), 0.05});
    truth.push_back(dense ? 1.0 : 2.0);
  }
  test::processAt(&pipeline, points, Eigen::Vector3d::Zero());
  collector.add(pipeline, truth);
  const Training training = trainClassifier(collector, frame, fewComponents());
  ASSERT_EQ(training.constant_features, (std::vector<std::string>{"scatter"}));
  // Whatever it is elsewhere, the likelihoods of the classes shift alike and little.
  const GaussianMixture a(training.model.classes[0].mixture);
  const Eigen::MatrixXd values = (Eigen::MatrixXd(2, 2) << 0.0, 0.5, 0.3, 0.3).finished();
  const std::vector<double> likelihoods = logLikelihoods(a, values);
  EXPECT_NEAR(likelihoods[0], likelihoods[1], 0.2);
}

TEST(LearnTrainer, TheReportHasWhatThePicturesNeed) {
  const Training training = trainOnScene();
  const auto report = nlohmann::json::parse(trainingReport(training, "m.yaml", {"a.bag"}));
  EXPECT_EQ(report["kind"], "training");
  EXPECT_EQ(report["inputs"][0], "a.bag");
  ASSERT_EQ(report["classes"].size(), 3u);
  const auto& wire = report["classes"][2];
  EXPECT_EQ(wire["name"], "wire");
  EXPECT_EQ(wire["color"], "#708090");
  EXPECT_EQ(wire["points"], 2000);
  EXPECT_EQ(wire["scores"].size(), 2u);
  EXPECT_EQ(wire["mixture"].size(), training.model.classes[2].mixture.size());
  EXPECT_EQ(wire["mixture"][0]["covariance"].size(), 3u);
  ASSERT_EQ(report["features"].size(), 3u);
  EXPECT_EQ(report["features"][1]["name"], "cbrt_surface");
  std::size_t in_histogram = 0;
  for (const auto& count : report["features"][1]["histogram"]["counts"][2]) {
    in_histogram += count.get<std::size_t>();
  }
  EXPECT_GE(in_histogram, training.classes[2].samples.size() * 98 / 100);
}

}  // namespace
}  // namespace ladar_perception
