// SPDX-License-Identifier: BSD-3-Clause
// What calibration finds, where what it has to find is known: the truths of points are drawn by the
// very rule that is calibrated.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "ladar_perception/learn/calibrator.h"
#include "ladar_perception/learn/label_scores.h"
#include "ladar_perception/learn/trainer.h"
#include "terrain_scenes.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::processAt;
using test::TestRandom;

constexpr int kClasses = 3;

/// An exponent by term (own, then radii) and an offset by class.
struct Rule {
  std::vector<double> exponents;
  std::vector<double> offsets;
};

TerrainConfig smallSupport() {
  TerrainConfig config;
  config.support_radius_voxels = 1;
  config.min_range_m = 0.0;
  return config;
}

/// Ground, walls and bushes, which clumps of points are more or less. Sharp ones: terms that hardly
/// vary would tell little of their exponents.
ClassifierModel someModel(int classes = kClasses) {
  ClassifierModel model = test::modelFor(smallSupport());
  model.features = parseFeatures({"normal_angle", "cbrt_scatter"});
  const std::vector<double> deviation = {0.35, 0.04};
  model.classes = {{"ground", 1, 0.5, {test::gaussian(1.0, {0.3, 0.05}, deviation)}},
                   {"wall", 2, 1.0, {test::gaussian(1.0, {1.3, 0.05}, deviation)}},
                   {"bush", 3, 0.75, {test::gaussian(1.0, {0.9, 0.13}, deviation)}}};
  model.classes.resize(static_cast<std::size_t>(classes));
  model.calibration.smoothing.temperature = 2.0;
  model.calibration.smoothing.radii_voxels = {1, 8};
  model.calibration.smoothing.exponents = {0.2, 0.5, 1.0};
  return model;
}

/// Points in clumps, of a kind that changes every few metres, so that what voxels say of themselves
/// and what their near and far surroundings do differs.
std::vector<Vector3d> clumps(uint64_t seed, int count = 700) {
  TestRandom random(seed);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Vector3d middle(random.real(-9.5, 9.5), random.real(-9.5, 9.5), random.real(-0.8, 1.8));
    Vector3d reach(random.real(0.02, 0.3), random.real(0.02, 0.3), random.real(0.02, 0.3));
    const auto square = static_cast<int>(std::floor(middle.x() / 3.0) + 4.0) +
                        static_cast<int>(std::floor(middle.y() / 3.0) + 4.0);
    if (square % 3 == 0) reach.z() *= 0.2;
    if (square % 3 == 1) reach.x() *= 0.2;
    for (int64_t n = random.integer(5, 80); n > 0; --n) {
      points.push_back(middle + reach.cwiseProduct(random.normal3()));
    }
  }
  return points;
}

/// For every point, a class drawn by the rule from what smoothing multiplies.
std::vector<double> drawTruth(const TerrainPipeline& pipeline, const Rule& rule,
                              TestRandom* random) {
  const std::size_t classes = rule.offsets.size();
  std::vector<double> truth(pipeline.pointCells().size(), 0.0);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const CellId cell = pipeline.pointCells()[i];
    if (cell == kNoCell) continue;
    const float* terms = pipeline.smoothingTerms(pipeline.map().slotOf(cell));
    std::vector<double> powers(rule.offsets);
    double sum = 0.0;
    for (std::size_t c = 0; c < classes; ++c) {
      for (std::size_t t = 0; t < rule.exponents.size(); ++t) {
        powers[c] += rule.exponents[t] * terms[t * classes + c];
      }
      sum += powers[c] = std::exp(powers[c]);
    }
    double left = random->real(0.0, sum);
    std::size_t c = 0;
    while (c + 1 < classes && left >= powers[c]) left -= powers[c++];
    truth[i] = static_cast<double>(c + 1);
  }
  return truth;
}

/// A calibrator that has seen places whose truths follow the rule.
Calibrator calibratorOf(const ClassifierModel& model, const Rule& rule, int scans = 4) {
  Calibrator calibrator(model.classes.size());
  TestRandom random(7);
  for (int scan = 0; scan < scans; ++scan) {
    TerrainPipeline pipeline(smallSupport(), model);
    pipeline.keepFeatures(true);
    processAt(&pipeline, clumps(10 + scan), Vector3d::Zero());
    calibrator.add(pipeline, drawTruth(pipeline, rule, &random));
  }
  return calibrator;
}

/// How many points of each class that calibrator has seen in voxels that are known.
std::vector<double> pointsByClass(const ClassifierModel& model, const Rule& rule, int scans = 4) {
  std::vector<double> points(model.classes.size(), 0.0);
  TestRandom random(7);
  for (int scan = 0; scan < scans; ++scan) {
    TerrainPipeline pipeline(smallSupport(), model);
    pipeline.keepFeatures(true);
    processAt(&pipeline, clumps(10 + scan), Vector3d::Zero());
    const std::vector<double> truth = drawTruth(pipeline, rule, &random);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const bool is_known = pipeline.pointLabels()[i].label != kUnknownLabel;
      if (is_known && truth[i] > 0.0) points[static_cast<std::size_t>(truth[i]) - 1] += 1.0;
    }
  }
  return points;
}

ClassifierModel calibrated(const Rule& rule, bool class_balanced) {
  ClassifierModel model = someModel();
  calibratorOf(model, rule).calibrate(class_balanced, &model);
  return model;
}

void expectNear(const std::vector<double>& found, const std::vector<double>& expected,
                double tolerance) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], tolerance) << i;
}

TEST(LearnCalibrator, FindsTheExponentsAndOffsetsThatTruthsWereDrawnBy) {
  for (const Rule& rule : {Rule{{0.3, 0.6, 0.9}, {0.5, -0.75, 0.25}},
                           Rule{{1.0, 0.0, 0.4}, {0.0, 0.0, 0.0}},
                           Rule{{0.0, 0.0, 1.5}, {-0.6, 0.3, 0.3}}}) {
    const Calibration::Smoothing found = calibrated(rule, false).calibration.smoothing;
    expectNear(found.exponents, rule.exponents, 0.1);
    expectNear(found.offsets, rule.offsets, 0.1);
    EXPECT_NEAR(found.offsets[0] + found.offsets[1] + found.offsets[2], 0.0, 1e-9);
    // Those stay what they are.
    EXPECT_EQ(found.temperature, 2.0);
    EXPECT_EQ(found.radii_voxels, (std::vector<int>{1, 8}));
  }
}

TEST(LearnCalibrator, FindsTheTemperatureOfPosteriorsAlone) {
  const Rule rule = {{0.5, 0.0, 0.0}, {0.4, -0.5, 0.1}};
  const ClassifierModel model = calibrated(rule, false);
  EXPECT_NEAR(model.calibration.temperature, 2.0 / 0.5, 0.3);
  // prior^0.5 likelihood^(0.5 / 2) e^offset, while a posterior has the whole prior.
  std::vector<double> expected = rule.offsets;
  std::vector<double> found = model.calibration.offsets;
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t c = 0; c < expected.size(); ++c) {
    expected[c] += (0.5 - 1.0) * std::log(model.classes[c].prior);
  }
  for (std::size_t c = 1; c < expected.size(); ++c) {
    EXPECT_NEAR(found[c] - found[0], expected[c] - expected[0], 0.1) << c;
  }
}

TEST(LearnCalibrator, BalancingTakesTheClassesSharesOutOfTheOffsets) {
  const ClassifierModel model = someModel();
  const Rule rule = {{0.3, 0.6, 0.9}, {1.5, 0.0, -1.5}};
  const Calibrator calibrator = calibratorOf(model, rule);
  ClassifierModel by_points = model;
  ClassifierModel balanced = model;
  calibrator.calibrate(false, &by_points);
  calibrator.calibrate(true, &balanced);
  const std::vector<double> share = pointsByClass(model, rule);
  ASSERT_GT(share[0], 5.0 * share[2]) << "or there is nothing to balance";
  const auto& plain = by_points.calibration.smoothing;
  const auto& even = balanced.calibration.smoothing;
  expectNear(even.exponents, plain.exponents, 0.15);
  for (std::size_t c = 1; c < kClasses; ++c) {
    const double shift =
        (even.offsets[c] - even.offsets[0]) - (plain.offsets[c] - plain.offsets[0]);
    EXPECT_NEAR(shift, std::log(share[0] / share[c]), 0.15) << c;
  }
}

TEST(LearnCalibrator, ExponentsAreNeverNegative) {
  // The more its neighbours are of a class, the less it is.
  for (const std::vector<double>& exponents :
       {std::vector<double>{1.0, -0.8, 0.5}, {-1.0, -1.0, 0.9}, {-0.5, -0.5, -0.5}}) {
    const auto found = calibrated({exponents, {0.2, 0.0, -0.2}}, false).calibration;
    for (std::size_t t = 0; t < exponents.size(); ++t) {
      EXPECT_GE(found.smoothing.exponents[t], 0.0);
      if (exponents[t] < 0.0) {
        EXPECT_EQ(found.smoothing.exponents[t], 0.0) << t;
      }
    }
    EXPECT_GT(found.temperature, 0.0);
  }
  const auto found = calibrated({{1.0, -0.8, 0.5}, {0.0, 0.0, 0.0}}, false).calibration.smoothing;
  EXPECT_GT(found.exponents[0], 0.3);
}

TEST(LearnCalibrator, WherePosteriorsMisleadOnlySharesAreLeft) {
  const Rule rule = {{-0.3, -0.3, -0.3}, {0.5, 0.0, -0.5}};
  const Calibration found = calibrated(rule, false).calibration;
  const std::vector<double> points = pointsByClass(someModel(), rule);
  expectNear(found.smoothing.exponents, {0.0, 0.0, 0.0}, 0.0);
  EXPECT_GE(found.temperature, 2.0 / 0.05);  // next to flat
  const std::vector<ModelClass> classes = someModel().classes;
  for (std::size_t c = 1; c < kClasses; ++c) {
    const double expected = std::log(points[c] / points[0]);
    const double priors = std::log(classes[c].prior / classes[0].prior);
    EXPECT_NEAR(found.smoothing.offsets[c] - found.smoothing.offsets[0], expected, 0.02) << c;
    EXPECT_NEAR(found.offsets[c] - found.offsets[0] + 0.95 * priors, expected, 0.02) << c;
  }
}

TEST(LearnCalibrator, WithoutTwoClassesNothingIsChanged) {
  const ClassifierModel model = someModel();
  const std::string before = formatClassifierModel(model);
  for (const double only : {0.0, 2.0, 4.0, -1.0}) {  // of which one is a class
    Calibrator calibrator(kClasses);
    TerrainPipeline pipeline(smallSupport(), model);
    pipeline.keepFeatures(true);
    processAt(&pipeline, clumps(1), Vector3d::Zero());
    calibrator.add(pipeline, std::vector<double>(pipeline.pointCells().size(), only));
    EXPECT_EQ(calibrator.size() > 0, only == 2.0);
    for (const bool class_balanced : {false, true}) {
      ClassifierModel changed = model;
      calibrator.calibrate(class_balanced, &changed);
      EXPECT_EQ(formatClassifierModel(changed), before) << only;
    }
  }
}

TEST(LearnCalibrator, AClassThatIsMissingDoesNoHarm) {
  for (const bool class_balanced : {false, true}) {
    const auto found = calibrated({{0.3, 0.6, 0.9}, {0.5, -1000.0, -0.5}}, class_balanced);
    const Calibration& calibration = found.calibration;
    EXPECT_GT(calibration.smoothing.offsets[0], calibration.smoothing.offsets[1] + 2.0);
    EXPECT_GT(calibration.smoothing.offsets[2], calibration.smoothing.offsets[1] + 2.0);
    // What is written can be read: nothing is infinite.
    parseClassifierModel(formatClassifierModel(found), "model.yaml");
  }
}

TEST(LearnCalibrator, TheSameCallsGiveTheSameBits) {
  const Rule rule = {{0.3, 0.6, 0.9}, {0.5, -0.75, 0.25}};
  const Calibration a = calibrated(rule, true).calibration;
  const Calibration b = calibrated(rule, true).calibration;
  EXPECT_EQ(a.smoothing.exponents, b.smoothing.exponents);
  EXPECT_EQ(a.smoothing.offsets, b.smoothing.offsets);
  EXPECT_EQ(a.temperature, b.temperature);
  EXPECT_EQ(a.offsets, b.offsets);
}

TEST(LearnCalibrator, UnknownVoxelsAreLeftOut) {
  ClassifierModel model = someModel();
  const auto sizeAt = [&](double threshold) {
    model.unknown_log_likelihood = threshold;
    return calibratorOf(model, {{0.3, 0.6, 0.9}, {0.0, 0.0, 0.0}}, 1).size();
  };
  EXPECT_GT(sizeAt(-1e30), 1000U);
  EXPECT_LT(sizeAt(0.0), sizeAt(-1e30));
  EXPECT_EQ(sizeAt(1e30), 0U);
}

TEST(LearnCalibrator, ThinningFavoursNeitherWhatCameFirstNorWhatCameLast) {
  // More voxels than are kept. Early scans have much of one class, later ones of the other, and
  // posteriors tell neither: what is left for the offsets is the share of the classes.
  ClassifierModel model = someModel(2);
  model.calibration.smoothing.radii_voxels = {1};
  model.calibration.smoothing.exponents = {0.5, 0.5};
  TestRandom random(5);
  std::vector<Vector3d> points;
  for (int i = 0; i < 60000; ++i) {
    const double x = random.real(-9.9, 9.9);
    const double y = random.real(-9.9, 9.9);
    const Vector3d middle(x, y, random.real(-0.9, 1.9));
    for (int n = 0; n < 4; ++n) points.push_back(middle + 0.02 * random.normal3());
  }
  TerrainPipeline pipeline(smallSupport(), model);
  pipeline.keepFeatures(true);
  processAt(&pipeline, points, Vector3d::Zero());
  Calibrator calibrator(2);
  std::size_t scan_size = 0;
  for (int scan = 0; scan < 10; ++scan) {
    const double share = scan < 4 ? 0.9 : 0.1;
    std::vector<double> truth;
    for (std::size_t i = 0; i < points.size(); ++i) {
      truth.push_back(random.real(0.0, 1.0) < share ? 1.0 : 2.0);
    }
    calibrator.add(pipeline, truth);
    if (scan == 0) scan_size = calibrator.size();
  }
  ASSERT_GT(scan_size, 50000U);
  EXPECT_LT(calibrator.size(), 5 * scan_size);
  EXPECT_GT(calibrator.size(), scan_size);
  calibrator.calibrate(false, &model);
  const Calibration::Smoothing& found = model.calibration.smoothing;
  expectNear(found.exponents, {0.0, 0.0}, 0.05);
  const double share = (4 * 0.9 + 6 * 0.1) / 10;
  EXPECT_NEAR(found.offsets[0] - found.offsets[1], std::log(share / (1.0 - share)), 0.05);
}

/// Clouds on a grid, flat ones and thick ones, though some of the flat are thicker than some of the
/// thick. All voxels of one say much the same, so bare posteriors of many are far too sure.
struct Blobs {
  explicit Blobs(uint64_t seed) {
    TestRandom random(seed);
    for (int i = 0; i < 64; ++i) {
      const Vector3d middle(2.4 * (i % 8) - 8.4, 2.4 * (i / 8) - 8.4, random.real(0.0, 1.0));
      const bool is_flat = random.integer(0, 1) == 0;
      const double thickness = is_flat ? random.real(0.05, 0.5) : random.real(0.3, 0.8);
      const double length = random.real(0.3, 0.8);
      for (int n = 0; n < 150; ++n) {
        const double x = random.real(-0.7, 0.7);
        const double y = random.real(-length, length);
        points.push_back(middle + Vector3d(x, y, random.real(-thickness, thickness)));
        truth.push_back(is_flat ? 1.0 : 2.0);
      }
    }
  }
  std::vector<Vector3d> points;
  std::vector<double> truth;
};

class BlobSurvey {
 public:
  explicit BlobSurvey(bool smooth) {
    config_.min_range_m = 0.0;
    config_.smooth_labels = smooth;
  }

  const TerrainConfig& config() const { return config_; }
  template <typename Take>
  void run(const ClassifierModel& model, uint64_t first_seed, int scenes, const Take& take) const {
    for (int i = 0; i < scenes; ++i) {
      const Blobs blobs(first_seed + static_cast<uint64_t>(i));
      TerrainPipeline pipeline(config_, model);
      pipeline.keepFeatures(true);
      processAt(&pipeline, blobs.points, Vector3d::Zero());
      take(pipeline, blobs.truth);
    }
  }
  SampleCollector collect(const ClassifierModel& frame, uint64_t first_seed, int scenes) const {
    SampleCollector collector(2, frame.features.size(), 2000, 1);
    run(frame, first_seed, scenes, [&](const TerrainPipeline& pipeline, const auto& truth) {
      collector.beginFile();
      collector.add(pipeline, truth);
    });
    return collector;
  }
  double calibrationError(const ClassifierModel& model, uint64_t first_seed) const {
    LabelScores scores(2);
    run(model, first_seed, 8, [&](const TerrainPipeline& pipeline, const auto& truth) {
      scores.add(truth, pipeline.pointLabels(), pipeline.pointCells());
    });
    EXPECT_GT(scores.meanRecall().value_or(0.0), 0.7) << "or there is nothing to be sure of";
    return scores.reliability(true).ece;
  }

 private:
  TerrainConfig config_;
};

TEST(LearnCalibrator, ConfidencesOfPlacesNeverSeenComeTrue) {
  const BlobSurvey smoothed(true);
  const ClassifierModel frame =
      modelFrame({"flat", "thick"}, {1, 2},
                 parseFeatures({"cbrt_scatter", "cbrt_surface", "cbrt_linear"}), smoothed.config());
  TrainerOptions options;
  options.mixture.candidates = {3};
  const Training training = trainClassifier(smoothed.collect(frame, 100, 4), frame, options);
  // One fold's places are judged by what was learned from the other's.
  Calibrator calibrator(2);
  for (const uint64_t fold : {0, 1}) {
    const SampleCollector others = smoothed.collect(frame, 100 + 2 * (1 - fold), 2);
    const ClassifierModel other = trainLike(training.model, others, options);
    ASSERT_EQ(other.classes[0].mixture.size(), 3U);
    smoothed.run(other, 100 + 2 * fold, 2, [&](const TerrainPipeline& pipeline, const auto& truth) {
      calibrator.add(pipeline, truth);
    });
  }
  ClassifierModel model = training.model;
  calibrator.calibrate(true, &model);
  for (const bool smooth : {true, false}) {
    const BlobSurvey survey(smooth);
    const double before = survey.calibrationError(training.model, 900);
    const double after = survey.calibrationError(model, 900);
    EXPECT_LT(after, 0.6 * before) << "smoothed: " << smooth;
    EXPECT_LT(after, 0.08) << "smoothed: " << smooth;
  }
}

}  // namespace
}  // namespace ladar_perception
