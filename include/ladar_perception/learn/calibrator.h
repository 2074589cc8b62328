// SPDX-License-Identifier: BSD-3-Clause
// Finds the calibration of a classifier from places that its mixtures were not learned from.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/terrain/terrain_pipeline.h"

namespace ladar_perception {

/// Gathers what a model says of labelled places it has not seen, and fits the exponents and offsets
/// of its calibration to them: multinomial logistic regression on the logarithms of posteriors, by
/// Newton's method. With equal priors every class weighs the same, else every point.
class Calibrator {
 public:
  explicit Calibrator(std::size_t classes) : classes_(classes) {}

  /// The points of one scan with truth (0 is ignored). The pipeline must keep features and smooth
  /// labels. All models whose scans are added have the same smoothing but for its exponents and
  /// offsets, and the same classes and priors.
  void add(const TerrainPipeline& pipeline, const std::vector<double>& truth);
  /// Voxels that were seen and can be used, as far as they are kept.
  std::size_t size() const { return entries_.size(); }

  /// Sets the model's calibration but for temperature and radii of smoothing, which stay what they
  /// are. Exponents are not negative. Without entries of two classes or more nothing is changed.
  void calibrate(bool class_balanced, ClassifierModel* model) const;

 private:
  /// A voxel in one scan.
  struct Entry {
    uint64_t key = 0;
    std::vector<float> terms;       // by exponent, then class
    std::vector<uint32_t> points;   // by true class
  };

  std::size_t classes_;
  uint64_t offered_ = 0;
  uint64_t key_limit_ = UINT64_MAX;  // entries have lower keys
  std::vector<Entry> entries_;
  std::vector<std::vector<uint32_t>> points_;  // by slot, empty between calls
};

}  // namespace ladar_perception
