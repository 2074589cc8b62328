// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/label_scores.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace ladar_perception {
namespace {

std::optional<double> ratio(uint64_t part, uint64_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

/// Of the values that are there.
template <typename ValueOf>
std::optional<double> meanOver(std::size_t classes, ValueOf valueOf) {
  double sum = 0.0;
  int present = 0;
  for (std::size_t truth = 1; truth <= classes; ++truth) {
    const std::optional<double> value = valueOf(truth);
    if (!value) continue;
    sum += *value;
    ++present;
  }
  if (present == 0) return std::nullopt;
  return sum / present;
}

}  // namespace

LabelScores::LabelScores(std::size_t classes)
    : classes_(classes),
      counts_(classes * (classes + 1), 0),
      outside_(classes, 0),
      bins_(classes) {}

void LabelScores::add(std::size_t truth, const PointLabel& label, bool in_map) {
  assert(truth >= 1 && truth <= classes_ && label.label <= classes_);
  ++counts_[(truth - 1) * (classes_ + 1) + label.label];
  if (!in_map) ++outside_[truth - 1];
  if (label.label == 0) return;
  const auto confidence = static_cast<double>(label.confidence);
  const auto at = static_cast<std::size_t>(std::max(confidence, 0.0) * double{kBins});
  Bin& bin = bins_[truth - 1][std::min(at, kBins - 1)];
  ++bin.points;
  bin.confidence += confidence;
  if (label.label == truth) ++bin.right;
}

void LabelScores::add(const std::vector<double>& truth, const std::vector<PointLabel>& labels,
                      const std::vector<CellId>& cells) {
  assert(truth.size() == labels.size() && truth.size() == cells.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!(truth[i] >= 1.0 && truth[i] <= static_cast<double>(classes_))) continue;
    add(static_cast<std::size_t>(truth[i]), labels[i], cells[i] != kNoCell);
  }
}

LabelScores& LabelScores::operator+=(const LabelScores& other) {
  assert(classes_ == other.classes_);
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  for (std::size_t truth = 0; truth < classes_; ++truth) {
    outside_[truth] += other.outside_[truth];
    for (std::size_t b = 0; b < kBins; ++b) {
      bins_[truth][b].points += other.bins_[truth][b].points;
      bins_[truth][b].right += other.bins_[truth][b].right;
      bins_[truth][b].confidence += other.bins_[truth][b].confidence;
    }
  }
  return *this;
}

uint64_t LabelScores::points() const {
  return std::accumulate(counts_.begin(), counts_.end(), uint64_t{0});
}

uint64_t LabelScores::pointsOutsideMap() const {
  return std::accumulate(outside_.begin(), outside_.end(), uint64_t{0});
}

uint64_t LabelScores::count(std::size_t truth, std::size_t label) const {
  return counts_[(truth - 1) * (classes_ + 1) + label];
}

uint64_t LabelScores::truthCount(std::size_t truth) const {
  uint64_t sum = 0;
  for (std::size_t label = 0; label <= classes_; ++label) sum += count(truth, label);
  return sum;
}

uint64_t LabelScores::labelCount(std::size_t label) const {
  uint64_t sum = 0;
  for (std::size_t truth = 1; truth <= classes_; ++truth) sum += count(truth, label);
  return sum;
}

std::optional<double> LabelScores::recall(std::size_t truth) const {
  return ratio(count(truth, truth), truthCount(truth));
}

std::optional<double> LabelScores::precision(std::size_t label) const {
  return ratio(count(label, label), labelCount(label));
}

std::optional<double> LabelScores::f1(std::size_t truth) const {
  if (truthCount(truth) == 0) return std::nullopt;
  return ratio(2 * count(truth, truth), truthCount(truth) + labelCount(truth));
}

std::optional<double> LabelScores::meanRecall() const {
  return meanOver(classes_, [&](std::size_t truth) { return recall(truth); });
}

std::optional<double> LabelScores::meanF1() const {
  return meanOver(classes_, [&](std::size_t truth) { return f1(truth); });
}

std::optional<double> LabelScores::meanRecallInMap() const {
  return meanOver(classes_, [&](std::size_t truth) {
    return ratio(count(truth, truth), truthCount(truth) - outside_[truth - 1]);
  });
}

std::optional<double> LabelScores::overallAccuracy() const {
  uint64_t right = 0;
  for (std::size_t truth = 1; truth <= classes_; ++truth) right += count(truth, truth);
  return ratio(right, points());
}

std::optional<double> LabelScores::unknownShare() const { return ratio(labelCount(0), points()); }

Reliability LabelScores::reliability(bool class_balanced) const {
  struct Sum {
    double weight = 0.0;
    double right = 0.0;
    double confidence = 0.0;
  };
  std::array<Sum, kBins> sums;
  double all = 0.0;
  for (std::size_t truth = 1; truth <= classes_; ++truth) {
    const uint64_t labelled = truthCount(truth) - count(truth, 0);
    if (labelled == 0) continue;
    const double weight = class_balanced ? 1.0 / static_cast<double>(labelled) : 1.0;
    for (std::size_t b = 0; b < kBins; ++b) {
      const Bin& bin = bins_[truth - 1][b];
      sums[b].weight += weight * static_cast<double>(bin.points);
      sums[b].right += weight * static_cast<double>(bin.right);
      sums[b].confidence += weight * bin.confidence;
    }
    all += weight * static_cast<double>(labelled);
  }
  Reliability result;
  for (const Sum& sum : sums) {
    if (sum.weight <= 0.0) continue;
    result.bins.push_back(
        {sum.confidence / sum.weight, sum.right / sum.weight, sum.weight / all});
    result.ece += std::abs(sum.confidence - sum.right) / all;
  }
  return result;
}

}  // namespace ladar_perception
