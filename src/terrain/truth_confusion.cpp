// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/terrain/truth_confusion.h"

#include <cassert>

namespace ladar_perception {

TruthConfusion::TruthConfusion(std::size_t classes)
    : classes_(classes), counts_(classes * (classes + 1), 0) {}

void TruthConfusion::add(const std::vector<double>& truth, const std::vector<PointLabel>& labels,
                         const std::vector<CellId>& cells) {
  assert(truth.size() == labels.size() && truth.size() == cells.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!(truth[i] >= 1.0 && truth[i] <= static_cast<double>(classes_))) continue;
    if (cells[i] == kNoCell) {
      ++outside_;
      continue;
    }
    const auto row = static_cast<std::size_t>(truth[i]) - 1;
    ++counts_[row * (classes_ + 1) + labels[i].label];
    ++points_;
  }
}

uint64_t TruthConfusion::truthCount(std::size_t truth) const {
  uint64_t sum = 0;
  for (std::size_t label = 0; label <= classes_; ++label) sum += count(truth, label);
  return sum;
}

double TruthConfusion::recall(std::size_t truth) const {
  const uint64_t all = truthCount(truth);
  return all > 0 ? static_cast<double>(count(truth, truth)) / static_cast<double>(all) : 0.0;
}

double TruthConfusion::meanRecall() const {
  double sum = 0.0;
  int present = 0;
  for (std::size_t truth = 1; truth <= classes_; ++truth) {
    if (truthCount(truth) == 0) continue;
    sum += recall(truth);
    ++present;
  }
  return present > 0 ? sum / present : 0.0;
}

}  // namespace ladar_perception
