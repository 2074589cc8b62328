// SPDX-License-Identifier: BSD-3-Clause
// From samples of the classes to a model, and what there is to tell about how it was learned.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/learn/mixture_learner.h"

namespace ladar_perception {

enum class Priors {
  kEqual,     ///< maximum likelihood: best mean recall
  kTraining,  ///< the classes' shares of the training points: best F1 where the shares hold
};

struct TrainerOptions {
  MixtureOptions mixture;
  Priors priors = Priors::kEqual;
};

/// One class of a training.
struct ClassTraining {
  ClassCounts counts;
  Samples samples;
  LearnedMixture mixture;
};

struct Training {
  ClassifierModel model;
  std::vector<ClassTraining> classes;
  Eigen::VectorXd deviation;                   ///< of each feature, every class weighing the same
  std::vector<std::string> constant_features;  ///< that had one value in all samples
};

/// Learns every class's mixture from what was collected. `frame` is the model without mixtures. A
/// component's variances get 0.1 of the features' variances over all classes on top; a feature that
/// never changes gets a variance of its own that makes it say nothing. The threshold for `unknown`
/// lies below all but one in a thousand of the samples, every class counting the same. Throws
/// std::runtime_error that names the class if it has too few samples.
Training trainClassifier(const SampleCollector& collector, ClassifierModel frame,
                         const TrainerOptions& options);

/// `model` with mixtures learned from other samples, of as many components as it has: to see how a
/// model of its kind does where it was not learned. Throws as trainClassifier does.
ClassifierModel trainLike(const ClassifierModel& model, const SampleCollector& collector,
                          const TrainerOptions& options);

/// A model of these classes and features whose mixtures are placeholders: to compute features with.
ClassifierModel modelFrame(const std::vector<std::string>& names,
                           const std::vector<uint32_t>& colors,
                           const std::vector<Feature>& features, const TerrainConfig& config);

/// The report of a training as JSON text: per class counts, scores of all numbers of components,
/// mixtures, and histograms of the features (see scripts/plot_classifier_report.py).
std::string trainingReport(const Training& training, const std::string& model_path,
                           const std::vector<std::string>& inputs);

}  // namespace ladar_perception
