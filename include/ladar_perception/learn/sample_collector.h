// SPDX-License-Identifier: BSD-3-Clause
// Samples of the classes' features, drawn evenly over inputs and space.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "ladar_perception/terrain/terrain_pipeline.h"

namespace ladar_perception {

/// Samples of one class.
struct Samples {
  Eigen::MatrixXd values;           ///< features x samples
  std::vector<std::size_t> places;  ///< per sample, the number of its place; ascending

  std::size_t size() const { return static_cast<std::size_t>(values.cols()); }
};

/// What has been offered of a class.
struct ClassCounts {
  uint64_t points = 0;       ///< with this truth
  uint64_t points_used = 0;  ///< of them, those with features
  uint64_t voxels = 0;       ///< with such points, counted anew in every scan that sees them
  std::size_t places = 0;    ///< squares of kPlace_m, by input and file
};

/// Shares of `total` for groups of these sizes: all alike, but none more than it has; what small
/// groups leave goes to the others.
std::vector<std::size_t> evenShares(const std::vector<std::size_t>& sizes, std::size_t total);

/// Takes scans with truth and keeps a bounded number of samples of each class.
///
/// A sample is a voxel, not a point, or one object close to the sensor would be most of a class.
/// For the same reason every input gets the same share of a class's samples, as far as it has so
/// many, and within it every place. Which voxels of a place are taken is random by the seed.
class SampleCollector {
 public:
  /// Edge of the squares that count as one place.
  static constexpr double kPlace_m = 10.0;

  SampleCollector(std::size_t classes, std::size_t features, std::size_t samples_per_class,
                  uint64_t seed);

  /// What follows is of another input (with its share of the samples).
  void beginInput() { ++input_; }
  /// What follows has coordinates of its own.
  void beginFile() { ++file_; }
  /// The points of one scan; the pipeline must keep features. Features that are not finite are not
  /// taken.
  void add(const TerrainPipeline& pipeline, const std::vector<double>& truth);

  std::size_t classes() const { return pools_.size(); }
  ClassCounts counts(std::size_t class_index) const;
  /// The samples of a class, the same for the same calls in the same order.
  Samples samples(std::size_t class_index) const;

 private:
  struct PlaceKey {
    int input = 0;
    int file = 0;
    int32_t x = 0;
    int32_t y = 0;
    bool operator<(const PlaceKey& other) const;
  };
  /// A voxel that may become a sample; those with the lowest keys do.
  struct Candidate {
    uint64_t key = 0;
    std::vector<float> values;
  };
  struct Place {
    std::vector<Candidate> candidates;
    uint64_t key_limit = UINT64_MAX;  // candidates have lower keys
  };
  struct Pool {
    ClassCounts counts;
    std::map<PlaceKey, Place> places;
    std::size_t kept = 0;     // candidates
    std::size_t thin_at = 0;  // candidates
  };

  bool isNewInScan(std::size_t slot, std::size_t class_index);
  void offer(Pool* pool, const PlaceKey& place, const float* values);
  static void thinOut(Pool* pool, std::size_t most);
  static std::vector<std::size_t> sharesOfPlaces(const Pool& pool, std::size_t total);

  std::size_t features_;
  std::size_t samples_per_class_;
  std::mt19937_64 random_;
  std::vector<Pool> pools_;
  int input_ = 0;
  int file_ = 0;
  std::vector<uint16_t> seen_;  // by slot, a bit per class
};

}  // namespace ladar_perception
