// SPDX-License-Identifier: BSD-3-Clause
// How labels and their confidences compare with the truth.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "ladar_perception/cloud/labeled_cloud.h"
#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {

/// Points whose confidences lie in one bin.
struct ReliabilityBin {
  double confidence = 0.0;  ///< mean
  double accuracy = 0.0;    ///< share that is right
  double share = 0.0;       ///< of all points that are labelled
};

/// How far confidences are from the shares of right labels. Points without a label have no
/// confidence, so they are not in it.
struct Reliability {
  double ece = 0.0;  ///< expected calibration error: mean |confidence - accuracy| by share
  std::vector<ReliabilityBin> bins;  ///< of those with points, by rising confidence
};

/// Counts of one or several scans. Every point with truth counts, unknown ones as wrong, and those
/// that are in no voxel are unknown.
class LabelScores {
 public:
  static constexpr std::size_t kBins = 20;  ///< of confidence, equally wide from 0 to 1

  explicit LabelScores(std::size_t classes);

  /// One point of true class `truth` (1-based).
  void add(std::size_t truth, const PointLabel& label, bool in_map);
  /// The points of one scan, in message order; truths other than 1 to `classes` are ignored.
  void add(const std::vector<double>& truth, const std::vector<PointLabel>& labels,
           const std::vector<CellId>& cells);
  LabelScores& operator+=(const LabelScores& other);

  std::size_t classes() const { return classes_; }
  uint64_t points() const;
  /// Of the points, those in no voxel: outside the map, or dropped for another reason.
  uint64_t pointsOutsideMap() const;
  /// Points of a true class (1-based) with a label (0 is unknown).
  uint64_t count(std::size_t truth, std::size_t label) const;
  uint64_t truthCount(std::size_t truth) const;

  // Nothing where there is no point to tell it from.
  std::optional<double> recall(std::size_t truth) const;
  std::optional<double> precision(std::size_t label) const;
  /// 2 TP / (2 TP + FP + FN), of classes with points.
  std::optional<double> f1(std::size_t truth) const;
  // Over the classes with points.
  std::optional<double> meanRecall() const;
  std::optional<double> meanF1() const;
  /// Mean recall with points in no voxel left out.
  std::optional<double> meanRecallInMap() const;
  std::optional<double> overallAccuracy() const;
  std::optional<double> unknownShare() const;
  /// With every point weighing the same, or with every true class weighing the same.
  Reliability reliability(bool class_balanced) const;

 private:
  struct Bin {
    uint64_t points = 0;
    uint64_t right = 0;
    double confidence = 0.0;  // sum
  };

  uint64_t labelCount(std::size_t label) const;

  std::size_t classes_;
  std::vector<uint64_t> counts_;              // by truth, then label
  std::vector<uint64_t> outside_;             // by truth
  std::vector<std::array<Bin, kBins>> bins_;  // by truth
};

}  // namespace ladar_perception
