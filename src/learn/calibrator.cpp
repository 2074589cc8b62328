// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/calibrator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ladar_perception {
namespace {

constexpr std::size_t kMostEntries = 120000;
constexpr int kNewtonSteps = 30;
// Pulls parameters softly towards exponents that sum to 1 and no offsets: with few places the
// likelihood alone would go far for little.
constexpr double kRidge = 1e-3;

/// A number that is as good as random, by counting (Steele, Lea and Flood 2014, "Fast splittable
/// pseudorandom number generators").
uint64_t keyOf(uint64_t count) {
  uint64_t z = count * 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

/// What is known of one voxel: its features phi(j, c) of parameter j for class c, and how much its
/// points of each true class weigh.
struct Case {
  Eigen::MatrixXd phi;
  Eigen::VectorXd weight;
};

/// Weighted mean of -log p(true class) where log p = phi' parameters, normalised, plus the ridge;
/// and its first two derivatives.
struct Loss {
  double value = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

Loss lossAt(const std::vector<Case>& cases, const Eigen::VectorXd& parameters,
            const Eigen::VectorXd& preferred) {
  const Eigen::Index n = parameters.size();
  Loss loss;
  loss.value = 0.5 * kRidge * (parameters - preferred).squaredNorm();
  loss.gradient = kRidge * (parameters - preferred);
  loss.hessian = kRidge * Eigen::MatrixXd::Identity(n, n);
  for (const Case& one : cases) {
    const Eigen::VectorXd scores = one.phi.transpose() * parameters;
    const double greatest = scores.maxCoeff();
    const Eigen::VectorXd powers = (scores.array() - greatest).exp();
    const double log_sum = greatest + std::log(powers.sum());
    const Eigen::VectorXd p = powers / powers.sum();
    const double weight = one.weight.sum();
    const Eigen::VectorXd mean = one.phi * p;
    loss.value += weight * log_sum - one.weight.dot(scores);
    loss.gradient += weight * mean - one.phi * one.weight;
    loss.hessian +=
        weight * (one.phi * p.asDiagonal() * one.phi.transpose() - mean * mean.transpose());
  }
  return loss;
}

/// Newton's method with halved steps; the loss is convex.
Eigen::VectorXd minimise(const std::vector<Case>& cases, const Eigen::VectorXd& preferred) {
  Eigen::VectorXd parameters = preferred;
  Loss loss = lossAt(cases, parameters, preferred);
  for (int i = 0; i < kNewtonSteps && loss.gradient.norm() > 1e-9; ++i) {
    const Eigen::VectorXd step = loss.hessian.ldlt().solve(loss.gradient);
    double share = 1.0;
    Loss next = lossAt(cases, parameters - step, preferred);
    while (!(next.value <= loss.value) && share > 1e-6) {
      share *= 0.5;
      next = lossAt(cases, parameters - share * step, preferred);
    }
    if (!(next.value <= loss.value)) break;
    parameters -= share * step;
    loss = next;
  }
  return parameters;
}

/// An exponent for each of `used` terms and an offset for each class; offsets have mean 0.
struct Fit {
  std::vector<double> exponents;
  std::vector<double> offsets;
};

Fit fitTerms(const std::vector<Case>& all, const std::vector<Eigen::Index>& used,
             std::size_t classes) {
  const auto terms = static_cast<Eigen::Index>(used.size());
  const auto k = static_cast<Eigen::Index>(classes);
  std::vector<Case> cases;
  for (const Case& one : all) {
    Eigen::MatrixXd phi = Eigen::MatrixXd::Zero(terms + k, k);
    for (Eigen::Index t = 0; t < terms; ++t) {
      phi.row(t) = one.phi.row(used[static_cast<std::size_t>(t)]);
    }
    phi.bottomRows(k).setIdentity();
    cases.push_back({std::move(phi), one.weight});
  }
  Eigen::VectorXd preferred = Eigen::VectorXd::Zero(terms + k);
  if (terms > 0) preferred.head(terms).setConstant(1.0 / static_cast<double>(terms));
  const Eigen::VectorXd best = minimise(cases, preferred);
  const Eigen::VectorXd offsets = best.tail(k).array() - best.tail(k).mean();
  Fit fit;
  fit.exponents.assign(best.data(), best.data() + terms);
  fit.offsets.assign(offsets.data(), offsets.data() + k);
  return fit;
}

/// The same with exponents that are not negative: of a negative one the term is left out, and if
/// none is left, offsets tell the classes' shares.
Fit fitAll(const std::vector<Case>& cases, std::size_t terms, std::size_t classes) {
  std::vector<Eigen::Index> used;
  for (std::size_t t = 0; t < terms; ++t) used.push_back(static_cast<Eigen::Index>(t));
  while (true) {
    Fit fit = fitTerms(cases, used, classes);
    const auto least = std::min_element(fit.exponents.begin(), fit.exponents.end());
    if (used.empty() || *least >= 0.0) {
      std::vector<double> exponents(terms, 0.0);
      for (std::size_t i = 0; i < used.size(); ++i) {
        exponents[static_cast<std::size_t>(used[i])] = fit.exponents[i];
      }
      fit.exponents = std::move(exponents);
      return fit;
    }
    used.erase(used.begin() + (least - fit.exponents.begin()));
  }
}

}  // namespace

void Calibrator::add(const TerrainPipeline& pipeline, const std::vector<double>& truth) {
  const VoxelMap& map = pipeline.map();
  points_.resize(std::max(points_.size(), map.slotBound()));
  std::vector<std::size_t> slots;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!(truth[i] >= 1.0 && truth[i] <= static_cast<double>(classes_))) continue;
    const CellId cell = pipeline.pointCells()[i];
    if (cell == kNoCell) continue;
    const std::size_t slot = map.slotOf(cell);
    if (pipeline.classification(slot).label == kUnknownLabel) continue;
    if (points_[slot].empty()) {
      points_[slot].assign(classes_, 0);
      slots.push_back(slot);
    }
    ++points_[slot][static_cast<std::size_t>(truth[i]) - 1];
  }
  const std::size_t terms =
      classes_ * pipeline.model().calibration.smoothing.exponents.size();
  for (const std::size_t slot : slots) {
    const uint64_t key = keyOf(++offered_);
    std::vector<uint32_t> points = std::move(points_[slot]);
    points_[slot] = {};
    if (key >= key_limit_) continue;
    const float* values = pipeline.smoothingTerms(slot);
    entries_.push_back({key, std::vector<float>(values, values + terms), std::move(points)});
  }
  if (entries_.size() < 2 * kMostEntries) return;
  // A random half goes, and as many of those to come.
  const auto middle = entries_.begin() + static_cast<std::ptrdiff_t>(kMostEntries);
  std::nth_element(entries_.begin(), middle, entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.key < b.key; });
  key_limit_ = middle->key;
  entries_.erase(middle, entries_.end());
}

void Calibrator::calibrate(bool class_balanced, ClassifierModel* model) const {
  std::vector<double> totals(classes_, 0.0);
  for (const Entry& entry : entries_) {
    for (std::size_t c = 0; c < classes_; ++c) totals[c] += entry.points[c];
  }
  double all = 0.0;
  std::size_t present = 0;
  for (const double total : totals) {
    all += total;
    present += total > 0.0 ? 1 : 0;
  }
  if (present < 2) return;
  Calibration::Smoothing& smoothing = model->calibration.smoothing;
  const std::size_t terms = smoothing.exponents.size();
  std::vector<Case> cases;
  for (const Entry& entry : entries_) {
    Case one;
    one.phi.resize(static_cast<Eigen::Index>(terms), static_cast<Eigen::Index>(classes_));
    one.weight.resize(static_cast<Eigen::Index>(classes_));
    for (std::size_t c = 0; c < classes_; ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      for (std::size_t t = 0; t < terms; ++t) {
        one.phi(static_cast<Eigen::Index>(t), column) = entry.terms[t * classes_ + c];
      }
      const double unit = class_balanced ? totals[c] * static_cast<double>(present) : all;
      one.weight[column] = entry.points[c] > 0 ? entry.points[c] / unit : 0.0;
    }
    cases.push_back(std::move(one));
  }
  const Fit smoothed = fitAll(cases, terms, classes_);
  smoothing.exponents = smoothed.exponents;
  smoothing.offsets = smoothed.offsets;

  // Alone, a posterior at the temperature of smoothing to the power of an exponent is one at
  // another temperature.
  Fit alone = fitTerms(cases, {0}, classes_);
  const double exponent = std::clamp(alone.exponents[0], 0.05, 20.0);
  // Offsets that go with a negative exponent would be wrong without it.
  if (alone.exponents[0] < exponent) alone.offsets = fitTerms(cases, {}, classes_).offsets;
  double prior_sum = 0.0;
  for (const ModelClass& model_class : model->classes) prior_sum += model_class.prior;
  for (std::size_t c = 0; c < classes_; ++c) {
    alone.offsets[c] += (exponent - 1.0) * std::log(model->classes[c].prior / prior_sum);
  }
  model->calibration.temperature = smoothing.temperature / exponent;
  model->calibration.offsets = alone.offsets;
}

}  // namespace ladar_perception
