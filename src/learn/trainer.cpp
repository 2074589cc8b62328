// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/trainer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "json_parts.h"
#include "ladar_perception/util/progress.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kCovarianceFloor = 0.1;
// Volumes less likely than all but this share of the training samples, by this much, are unknown.
constexpr double kUnknownShare = 0.001;
constexpr double kUnknownMargin = 10.0;
constexpr int kHistogramBins = 60;

void checkSamples(const ClassTraining& training, const std::string& name) {
  if (training.samples.size() >= kLeastSamples) return;
  const ClassCounts& counts = training.counts;
  throw std::runtime_error("class '" + name + "' has " + std::to_string(training.samples.size()) +
                           " samples (voxels with features; " + std::to_string(counts.points) +
                           " labelled points, " + std::to_string(counts.points_used) +
                           " of them in such voxels), expected at least " +
                           std::to_string(kLeastSamples));
}

struct FeatureSpread {
  Eigen::VectorXd mean;
  Eigen::VectorXd variance;
};

/// Over all classes, each weighing the same however many samples it has.
FeatureSpread balancedSpread(const std::vector<ClassTraining>& classes) {
  const Eigen::Index n = classes.front().samples.values.rows();
  const auto weight = 1.0 / static_cast<double>(classes.size());
  FeatureSpread spread{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
  for (const ClassTraining& one : classes) {
    spread.mean += weight * one.samples.values.rowwise().mean();
  }
  for (const ClassTraining& one : classes) {
    const Eigen::MatrixXd centred = one.samples.values.colwise() - spread.mean;
    spread.variance += weight * Eigen::VectorXd(centred.array().square().rowwise().mean());
  }
  return spread;
}

/// What is added to variances. Of a feature that never changes, so much that whatever it will be on
/// the vehicle is the same to all classes, and not unknown.
Eigen::VectorXd covarianceFloor(const FeatureSpread& spread, const std::vector<Feature>& features,
                                std::vector<std::string>* constant_features) {
  Eigen::VectorXd floor = kCovarianceFloor * spread.variance;
  for (Eigen::Index f = 0; f < floor.size(); ++f) {
    const double magnitude = std::abs(spread.mean[f]);
    // Less is rounding.
    const double least = 1e-6 * std::max(1.0, magnitude);
    if (spread.variance[f] > least * least) continue;
    floor[f] = std::max(magnitude * magnitude, 1.0);
    constant_features->emplace_back(featureName(features[static_cast<std::size_t>(f)]));
  }
  return floor;
}

double unknownThreshold(const ClassifierModel& model, const std::vector<ClassTraining>& classes) {
  std::vector<GaussianMixture> mixtures;
  for (const ModelClass& model_class : model.classes) mixtures.emplace_back(model_class.mixture);
  double threshold = std::numeric_limits<double>::infinity();
  for (const ClassTraining& one : classes) {
    std::vector<double> best(one.samples.size(), -std::numeric_limits<double>::infinity());
    for (const GaussianMixture& mixture : mixtures) {
      const std::vector<double> likelihoods = logLikelihoods(mixture, one.samples.values);
      for (std::size_t i = 0; i < best.size(); ++i) best[i] = std::max(best[i], likelihoods[i]);
    }
    const auto index =
        static_cast<std::ptrdiff_t>(kUnknownShare * static_cast<double>(best.size()));
    std::nth_element(best.begin(), best.begin() + index, best.end());
    threshold = std::min(threshold, best[static_cast<std::size_t>(index)]);
  }
  return threshold - kUnknownMargin;
}

void setPriors(Priors priors, const std::vector<ClassTraining>& classes, ClassifierModel* model) {
  double sum = 0.0;
  for (const ClassTraining& one : classes) sum += static_cast<double>(one.counts.points);
  for (std::size_t c = 0; c < classes.size(); ++c) {
    const double share = static_cast<double>(classes[c].counts.points) / sum;
    model->classes[c].prior = priors == Priors::kTraining ? share : 1.0;
  }
}

std::string digits(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

void addProvenance(const Training& training, const TrainerOptions& options,
                   ClassifierModel* model) {
  auto& provenance = model->provenance;
  for (std::size_t c = 0; c < training.classes.size(); ++c) {
    const ClassTraining& one = training.classes[c];
    const std::string name = model->classes[c].name;
    provenance["points of " + name] = std::to_string(one.counts.points);
    provenance["samples of " + name] = std::to_string(one.samples.size());
  }
  for (std::size_t f = 0; f < model->features.size(); ++f) {
    provenance["deviation of " + featureName(model->features[f])] =
        digits(training.deviation[static_cast<Eigen::Index>(f)]);
  }
  provenance["priors"] = options.priors == Priors::kTraining ? "training" : "equal";
  provenance["seed"] = std::to_string(options.mixture.seed);
}

Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json scoresJson(const ClassTraining& one) {
  Json list = Json::array();
  for (const MixtureScore& score : one.mixture.scores) {
    list.push_back({{"components", score.components},
                    {"log_likelihood", numberOrNull(score.log_likelihood)},
                    {"bic", numberOrNull(score.bic)},
                    {"held_out", numberOrNull(score.held_out)},
                    {"held_out_error", numberOrNull(score.held_out_error)}});
  }
  return list;
}

Json classJson(const ModelClass& model_class, const ClassTraining& one) {
  Json json = {{"name", model_class.name},
               {"color", colorText(model_class.rgb)},
               {"prior", model_class.prior},
               {"points", one.counts.points},
               {"points_with_features", one.counts.points_used},
               {"voxels", one.counts.voxels},
               {"places", one.counts.places},
               {"samples", one.samples.size()},
               {"components", one.mixture.components.size()},
               {"chosen_by", one.mixture.scores.empty()                        ? "given"
                             : one.mixture.choice == ComponentChoice::kHeldOut ? "held_out"
                                                                               : "bic"},
               {"scores", scoresJson(one)}};
  json["mixture"] = mixtureJson(one.mixture.components);
  return json;
}

/// Counts of a feature in every class, over the range of nearly all samples.
Json histogramJson(const Training& training, std::size_t feature) {
  const auto f = static_cast<Eigen::Index>(feature);
  std::vector<double> all;
  for (const ClassTraining& one : training.classes) {
    for (const double value : one.samples.values.row(f)) all.push_back(value);
  }
  std::sort(all.begin(), all.end());
  const double low = all[all.size() / 1000];
  const double high = all[all.size() - 1 - all.size() / 1000];
  const double width = std::max((high - low) / kHistogramBins, 1e-9);
  Json json = {{"from", low}, {"to", low + width * kHistogramBins}, {"counts", Json::array()}};
  for (const ClassTraining& one : training.classes) {
    std::vector<std::size_t> counts(kHistogramBins, 0);
    for (const double value : one.samples.values.row(f)) {
      const double bin = std::floor((value - low) / width);
      if (bin >= 0.0 && bin < kHistogramBins) ++counts[static_cast<std::size_t>(bin)];
    }
    json["counts"].push_back(counts);
  }
  return json;
}

}  // namespace

ClassifierModel modelFrame(const std::vector<std::string>& names,
                           const std::vector<uint32_t>& colors,
                           const std::vector<Feature>& features, const TerrainConfig& config) {
  ClassifierModel model;
  model.features = features;
  model.voxel_size_m = config.voxel_size_m;
  model.support_radius_voxels = config.support_radius_voxels;
  model.support_kernel = config.support_kernel;
  const auto n = static_cast<Eigen::Index>(features.size());
  for (std::size_t c = 0; c < names.size(); ++c) {
    model.classes.push_back({names[c],
                             colors[c],
                             1.0,
                             {{1.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n, n)}}});
  }
  return model;
}

Training trainClassifier(const SampleCollector& collector, ClassifierModel frame,
                         const TrainerOptions& options) {
  Training training;
  std::size_t fits = 0;
  for (std::size_t c = 0; c < frame.classes.size(); ++c) {
    training.classes.push_back({collector.counts(c), collector.samples(c), {}});
    checkSamples(training.classes.back(), frame.classes[c].name);
    fits += fitCount(training.classes.back().samples, options.mixture);
  }
  const FeatureSpread spread = balancedSpread(training.classes);
  const Eigen::VectorXd floor =
      covarianceFloor(spread, frame.features, &training.constant_features);
  training.deviation = spread.variance.cwiseSqrt();
  Progress progress("fits of mixtures", fits);
  for (std::size_t c = 0; c < frame.classes.size(); ++c) {
    ClassTraining& one = training.classes[c];
    try {
      one.mixture = learnMixture(one.samples, floor, options.mixture, [&] { progress.advance(); });
    } catch (const std::runtime_error& error) {
      throw std::runtime_error("class '" + frame.classes[c].name + "': " + error.what());
    }
    frame.classes[c].mixture = one.mixture.components;
  }
  progress.finish();
  setPriors(options.priors, training.classes, &frame);
  frame.unknown_log_likelihood = unknownThreshold(frame, training.classes);
  addProvenance(training, options, &frame);
  training.model = std::move(frame);
  return training;
}

ClassifierModel trainLike(const ClassifierModel& model, const SampleCollector& collector,
                          const TrainerOptions& options) {
  ClassifierModel other = model;
  std::vector<ClassTraining> classes;
  for (std::size_t c = 0; c < model.classes.size(); ++c) {
    classes.push_back({collector.counts(c), collector.samples(c), {}});
    checkSamples(classes.back(), model.classes[c].name);
  }
  std::vector<std::string> constant_features;
  const Eigen::VectorXd floor =
      covarianceFloor(balancedSpread(classes), model.features, &constant_features);
  for (std::size_t c = 0; c < model.classes.size(); ++c) {
    MixtureOptions mixture = options.mixture;
    mixture.candidates = {static_cast<int>(model.classes[c].mixture.size())};
    other.classes[c].mixture = learnMixture(classes[c].samples, floor, mixture).components;
  }
  return other;
}

std::string trainingReport(const Training& training, const std::string& model_path,
                           const std::vector<std::string>& inputs) {
  Json json;
  json["kind"] = "training";
  json["model"] = model_path;
  json["inputs"] = inputs;
  json["provenance"] = training.model.provenance;
  json["unknown_log_likelihood"] = training.model.unknown_log_likelihood;
  json["constant_features"] = training.constant_features;
  json["features"] = Json::array();
  for (std::size_t f = 0; f < training.model.features.size(); ++f) {
    const Feature& feature = training.model.features[f];
    const QuantityInfo& info = quantityInfo(feature.quantity);
    json["features"].push_back({{"name", featureName(feature)},
                                {"unit", info.unit},
                                {"meaning", info.meaning},
                                {"histogram", histogramJson(training, f)}});
  }
  json["classes"] = Json::array();
  for (std::size_t c = 0; c < training.classes.size(); ++c) {
    json["classes"].push_back(classJson(training.model.classes[c], training.classes[c]));
  }
  return json.dump(1) + "\n";
}

}  // namespace ladar_perception
