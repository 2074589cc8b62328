// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/mixture_learner.h"

// Failures are reported by exceptions, not by the library's own messages.
#define ARMA_WARN_LEVEL 0
#include <algorithm>
#include <armadillo>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace ladar_perception {
namespace {

using Columns = std::vector<Eigen::Index>;

constexpr std::size_t kFolds = 4;
// Candidates are compared on no more than this: the choice does not need what the final fit uses.
constexpr std::size_t kMostSamplesToCompare = 4000;
constexpr int kKMeansIterations = 20;
constexpr int kEmIterations = 40;
// Of the variance of a feature, lest a component collapses while it is learned.
constexpr double kLeastVariance = 1e-6;
constexpr double kLeastWeight = 1e-4;

Eigen::MatrixXd select(const Eigen::MatrixXd& values, const Columns& columns) {
  Eigen::MatrixXd chosen(values.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    chosen.col(static_cast<Eigen::Index>(i)) = values.col(columns[i]);
  }
  return chosen;
}

/// Features brought to mean 0 and variance 1: EM starts from distances.
struct Scaling {
  explicit Scaling(const Eigen::MatrixXd& values) {
    mean = values.rowwise().mean();
    deviation = (values.colwise() - mean).array().square().rowwise().mean().sqrt();
    for (double& d : deviation) d = d > 0.0 ? d : 1.0;
  }
  Eigen::VectorXd mean;
  Eigen::VectorXd deviation;
};

std::vector<GaussianComponent> fit(const Eigen::MatrixXd& values, const Eigen::VectorXd& floor,
                                   int components, uint64_t seed) {
  const Scaling scaling(values);
  const Eigen::MatrixXd scaled =
      (values.colwise() - scaling.mean).array().colwise() / scaling.deviation.array();
  const arma::mat data(scaled.data(), static_cast<arma::uword>(scaled.rows()),
                       static_cast<arma::uword>(scaled.cols()));
  const arma::vec scaled_floor(
      Eigen::VectorXd(floor.array() / scaling.deviation.array().square()).data(),
      static_cast<arma::uword>(floor.size()));
  arma::arma_rng::set_seed(seed);
  arma::gmm_full mixture;
  bool learned = mixture.learn(data, static_cast<arma::uword>(components), arma::maha_dist,
                               arma::static_spread, kKMeansIterations, 1, kLeastVariance, false);
  // The floor goes onto the variances after every step: components then share the samples as they
  // will when they are used.
  for (int i = 1; learned && i < kEmIterations; ++i) {
    arma::cube covariances = mixture.fcovs;
    for (arma::uword c = 0; c < covariances.n_slices; ++c) {
      covariances.slice(c).diag() += scaled_floor;
    }
    mixture.set_fcovs(covariances);
    learned = mixture.learn(data, mixture.n_gaus(), arma::maha_dist, arma::keep_existing, 0, 1,
                            kLeastVariance, false);
  }
  if (!learned) {
    throw std::runtime_error("expectation maximisation failed with " + std::to_string(components) +
                             " components on " + std::to_string(values.cols()) + " samples");
  }
  const Eigen::Index n = values.rows();
  const Eigen::MatrixXd scale = scaling.deviation.asDiagonal();
  std::vector<GaussianComponent> result;
  double weights = 0.0;
  for (arma::uword c = 0; c < mixture.n_gaus(); ++c) {
    if (!(mixture.hefts(c) > kLeastWeight)) continue;
    const Eigen::VectorXd mean = Eigen::Map<const Eigen::VectorXd>(mixture.means.colptr(c), n);
    const Eigen::MatrixXd covariance =
        Eigen::Map<const Eigen::MatrixXd>(mixture.fcovs.slice_memptr(c), n, n);
    GaussianComponent component;
    component.weight = mixture.hefts(c);
    component.mean = scaling.mean + scale * mean;
    component.covariance = scale * (0.5 * (covariance + covariance.transpose())) * scale;
    component.covariance.diagonal() += floor;
    weights += component.weight;
    result.push_back(std::move(component));
  }
  for (GaussianComponent& component : result) component.weight /= weights;
  return result;
}

double meanLogLikelihood(const std::vector<GaussianComponent>& components,
                         const Eigen::MatrixXd& values) {
  const std::vector<double> all = logLikelihoods(GaussianMixture(components), values);
  return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
}

double parameterCount(int components, Eigen::Index features) {
  const auto d = static_cast<double>(features);
  return components * (1.0 + d + d * (d + 1.0) / 2.0) - 1.0;
}

/// A fold for each place, such that folds have about as many samples each: the largest places
/// first, each to the smallest fold.
std::vector<std::size_t> dealPlaces(const Samples& samples) {
  const std::size_t places = samples.places.empty() ? 0 : samples.places.back() + 1;
  std::vector<std::size_t> sizes(places, 0);
  for (const std::size_t place : samples.places) ++sizes[place];
  std::vector<std::size_t> order(places);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sizes[a] > sizes[b]; });
  std::array<std::size_t, kFolds> filled{};
  std::vector<std::size_t> fold_of_place(places);
  for (const std::size_t place : order) {
    const auto fold = std::min_element(filled.begin(), filled.end()) - filled.begin();
    fold_of_place[place] = static_cast<std::size_t>(fold);
    filled[static_cast<std::size_t>(fold)] += sizes[place];
  }
  return fold_of_place;
}

/// Columns of the samples by fold; empty if places are too few or too uneven to leave some out.
std::vector<Columns> foldsOf(const Samples& samples) {
  const std::vector<std::size_t> fold_of_place = dealPlaces(samples);
  std::vector<Columns> folds(kFolds);
  for (std::size_t i = 0; i < samples.places.size(); ++i) {
    folds[fold_of_place[samples.places[i]]].push_back(static_cast<Eigen::Index>(i));
  }
  for (const Columns& fold : folds) {
    if (2 * fold.size() * kFolds < samples.size()) return {};
  }
  return folds;
}

/// Evenly spread samples, at most kMostSamplesToCompare: they are sorted by place.
Samples thinned(const Samples& samples) {
  if (samples.size() <= kMostSamplesToCompare) return samples;
  Columns columns;
  Samples few;
  for (std::size_t i = 0; i < kMostSamplesToCompare; ++i) {
    columns.push_back(static_cast<Eigen::Index>(i * samples.size() / kMostSamplesToCompare));
    few.places.push_back(samples.places[static_cast<std::size_t>(columns.back())]);
  }
  few.values = select(samples.values, columns);
  return few;
}

bool isFeasible(int components, std::size_t samples, Eigen::Index features) {
  const std::size_t needed =
      std::max(kLeastSamplesPerComponent, static_cast<std::size_t>(features) + 1);
  return components == 1 || samples >= static_cast<std::size_t>(components) * needed;
}

std::vector<int> feasibleCandidates(const Samples& samples, const MixtureOptions& options) {
  std::vector<int> feasible;
  // A fold leaves the others to learn from.
  const std::size_t left = std::min(samples.size(), kMostSamplesToCompare) * (kFolds - 1) / kFolds;
  for (const int components : options.candidates) {
    if (isFeasible(components, left, samples.values.rows())) feasible.push_back(components);
  }
  if (feasible.empty()) feasible.push_back(options.candidates.front());
  return feasible;
}

void scoreHeldOut(const Samples& samples, const std::vector<Columns>& folds,
                  const Eigen::VectorXd& floor, uint64_t seed, const std::function<void()>& advance,
                  MixtureScore* score) {
  std::vector<double> means;
  for (std::size_t left_out = 0; left_out < folds.size(); ++left_out) {
    Columns learned;
    for (std::size_t fold = 0; fold < folds.size(); ++fold) {
      if (fold != left_out) learned.insert(learned.end(), folds[fold].begin(), folds[fold].end());
    }
    const auto mixture = fit(select(samples.values, learned), floor, score->components, seed);
    means.push_back(meanLogLikelihood(mixture, select(samples.values, folds[left_out])));
    if (advance) advance();
  }
  const auto n = static_cast<double>(means.size());
  score->held_out = std::accumulate(means.begin(), means.end(), 0.0) / n;
  double squares = 0.0;
  for (const double mean : means) squares += (mean - score->held_out) * (mean - score->held_out);
  score->held_out_error = std::sqrt(squares / (n - 1.0) / n);
}

int bestByBic(const std::vector<MixtureScore>& scores) {
  return std::min_element(
             scores.begin(), scores.end(),
             [](const MixtureScore& a, const MixtureScore& b) { return a.bic < b.bic; })
      ->components;
}

int bestByHeldOut(const std::vector<MixtureScore>& scores) {
  const auto best = std::max_element(
      scores.begin(), scores.end(),
      [](const MixtureScore& a, const MixtureScore& b) { return a.held_out < b.held_out; });
  for (const MixtureScore& score : scores) {
    if (score.held_out >= best->held_out - best->held_out_error) return score.components;
  }
  return best->components;
}

}  // namespace

std::vector<double> logLikelihoods(const GaussianMixture& mixture, const Eigen::MatrixXd& values) {
  std::vector<double> result;
  result.reserve(static_cast<std::size_t>(values.cols()));
  FeatureBlock block(static_cast<int>(values.rows()));
  std::array<float, FeatureBlock::kSize> log_likelihood{};
  for (Eigen::Index first = 0; first < values.cols(); first += FeatureBlock::kSize) {
    const Eigen::Index count = std::min<Eigen::Index>(FeatureBlock::kSize, values.cols() - first);
    for (Eigen::Index f = 0; f < values.rows(); ++f) {
      float* row = block.row(static_cast<int>(f));
      for (Eigen::Index i = 0; i < count; ++i) row[i] = static_cast<float>(values(f, first + i));
    }
    mixture.logLikelihood(block, log_likelihood.data());
    for (Eigen::Index i = 0; i < count; ++i) {
      result.push_back(static_cast<double>(log_likelihood[static_cast<std::size_t>(i)]));
    }
  }
  return result;
}

std::size_t fitCount(const Samples& samples, const MixtureOptions& options) {
  const std::size_t candidates = feasibleCandidates(samples, options).size();
  if (options.candidates.size() == 1 || samples.size() < kLeastSamples) return 1;
  const bool folds =
      options.choice == ComponentChoice::kHeldOut && !foldsOf(thinned(samples)).empty();
  return candidates * (1 + (folds ? kFolds : 0)) + 1;
}

LearnedMixture learnMixture(const Samples& samples, const Eigen::VectorXd& floor,
                            const MixtureOptions& options, const std::function<void()>& advance) {
  assert(!options.candidates.empty() && floor.size() == samples.values.rows());
  if (samples.size() < kLeastSamples) {
    throw std::runtime_error(std::to_string(samples.size()) + " samples, expected at least " +
                             std::to_string(kLeastSamples));
  }
  LearnedMixture learned;
  int components = options.candidates.front();
  if (options.candidates.size() == 1) {
    if (!isFeasible(components, samples.size(), samples.values.rows())) {
      throw std::runtime_error(std::to_string(samples.size()) + " samples are too few for " +
                               std::to_string(components) + " components");
    }
  } else {
    const Samples few = thinned(samples);
    const std::vector<Columns> folds =
        options.choice == ComponentChoice::kHeldOut ? foldsOf(few) : std::vector<Columns>();
    learned.choice = folds.empty() ? ComponentChoice::kBic : ComponentChoice::kHeldOut;
    for (const int candidate : feasibleCandidates(samples, options)) {
      MixtureScore score;
      score.components = candidate;
      score.log_likelihood =
          meanLogLikelihood(fit(few.values, floor, candidate, options.seed), few.values);
      if (advance) advance();
      const auto n = static_cast<double>(few.size());
      score.bic = parameterCount(candidate, few.values.rows()) * std::log(n) -
                  2.0 * n * score.log_likelihood;
      score.held_out = score.held_out_error = std::numeric_limits<double>::quiet_NaN();
      if (!folds.empty()) scoreHeldOut(few, folds, floor, options.seed, advance, &score);
      learned.scores.push_back(score);
    }
    components = folds.empty() ? bestByBic(learned.scores) : bestByHeldOut(learned.scores);
  }
  learned.components = fit(samples.values, floor, components, options.seed);
  if (advance) advance();
  return learned;
}

}  // namespace ladar_perception
