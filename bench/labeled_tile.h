// SPDX-License-Identifier: BSD-3-Clause
// Tiles with the truth of their points, and how labels are scored against it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/io/class_mapping.h"

namespace ladar_perception::bench {

/// A class of a point: 1 + index of the class, 0 for none.
using Labels = std::vector<uint8_t>;

struct LabeledTile {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<uint32_t> file_labels;  ///< as in the file
};

/// Reads files of the Oakland 3-D set into one cloud. Throws std::runtime_error if one is not
/// there or no such file.
LabeledTile readTiles(const std::vector<std::string>& paths);
/// The classes of the points; 0 is not scored.
Labels truthOf(const LabeledTile& tile, const ClassMapping& mapping);

/// Counts of every labelled point; a label of 0 is wrong.
class ClassScore {
 public:
  explicit ClassScore(std::size_t classes)
      : classes_(classes), counts_((classes + 1) * (classes + 1)) {}

  /// Of the same points, both in the same order.
  void add(const Labels& truth, const Labels& labels);

  std::vector<double> recall() const;
  /// Harmonic mean of recall and precision, by class.
  std::vector<double> f1() const;

 private:
  uint64_t count(std::size_t truth, std::size_t label) const {
    return counts_[truth * (classes_ + 1) + label];
  }

  std::size_t classes_;
  std::vector<uint64_t> counts_;  // by truth and label, both from 0
};

double meanOf(const std::vector<double>& values);

}  // namespace ladar_perception::bench
