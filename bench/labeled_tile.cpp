// SPDX-License-Identifier: BSD-3-Clause
#include "labeled_tile.h"

#include <numeric>
#include <stdexcept>

#include "ladar_perception/io/text_reader.h"

namespace ladar_perception::bench {

LabeledTile readTiles(const std::vector<std::string>& paths) {
  LabeledTile tile;
  for (const std::string& path : paths) {
    const Scan scan = readOaklandScan(path);
    const std::vector<double> x = readColumn(scan, "x");
    const std::vector<double> y = readColumn(scan, "y");
    const std::vector<double> z = readColumn(scan, "z");
    for (std::size_t i = 0; i < x.size(); ++i) tile.points_m.emplace_back(x[i], y[i], z[i]);
    for (const double label : readColumn(scan, "label")) {
      tile.file_labels.push_back(static_cast<uint32_t>(label));
    }
  }
  return tile;
}

Labels truthOf(const LabeledTile& tile, const ClassMapping& mapping) {
  Labels truth;
  truth.reserve(tile.file_labels.size());
  for (const uint32_t label : tile.file_labels) truth.push_back(mapping.truth(label));
  return truth;
}

void ClassScore::add(const Labels& truth, const Labels& labels) {
  if (truth.size() != labels.size()) throw std::logic_error("not as many labels as points");
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] > classes_ || labels[i] > classes_) throw std::logic_error("no such class");
    if (truth[i] != 0) ++counts_[truth[i] * (classes_ + 1) + labels[i]];
  }
}

std::vector<double> ClassScore::recall() const {
  std::vector<double> recall;
  for (std::size_t c = 1; c <= classes_; ++c) {
    uint64_t total = 0;
    for (std::size_t label = 0; label <= classes_; ++label) total += count(c, label);
    recall.push_back(total == 0 ? 0.0
                                : static_cast<double>(count(c, c)) / static_cast<double>(total));
  }
  return recall;
}

std::vector<double> ClassScore::f1() const {
  std::vector<double> f1;
  for (std::size_t c = 1; c <= classes_; ++c) {
    uint64_t of_class = 0;
    uint64_t labelled = 0;
    for (std::size_t other = 0; other <= classes_; ++other) {
      of_class += count(c, other);
      labelled += count(other, c);
    }
    const auto sum = static_cast<double>(of_class + labelled);
    f1.push_back(sum == 0.0 ? 0.0 : 2.0 * static_cast<double>(count(c, c)) / sum);
  }
  return f1;
}

double meanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace ladar_perception::bench
