// SPDX-License-Identifier: BSD-3-Clause
// The data of an evaluation's pictures.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "ladar_perception/terrain/terrain_pipeline.h"

namespace ladar_perception {

/// A random part, by the seed, of what an evaluation sees, enough for pictures.
class PictureSamples {
 public:
  static constexpr std::size_t kPointsPerCloud = 120000;
  static constexpr std::size_t kFeaturesPerClass = 1500;
  static constexpr std::size_t kClouds = 8;  ///< first inputs that are drawn

  PictureSamples(const ClassifierModel& model, uint64_t seed);

  void beginCloud(const std::string& name) { clouds_.push_back({name, {}, 0}); }
  /// One scan of the last cloud; the pipeline keeps features.
  void add(const TerrainPipeline& pipeline, const std::vector<double>& truth);
  /// Writes picture_data.json (the model's mixtures, samples of features by true class) and
  /// cloud_<n>.npy (float32 rows of x, y, z, truth, label) into a folder that exists. Throws
  /// std::runtime_error that names the file that cannot be written.
  void write(const std::string& folder) const;

 private:
  struct Point {
    float x, y, z, truth, label;
  };
  struct Cloud {
    std::string name;
    std::vector<Point> points;
    uint64_t offered;
  };
  struct FeatureSamples {
    std::vector<std::vector<float>> values;
    std::vector<int> labels;
    uint64_t offered = 0;
  };

  /// Where the next of a stream goes to in a uniform sample of `most`; `most` or more: nowhere.
  std::size_t reservoirSlot(uint64_t* offered, std::size_t most);
  void addFeatures(std::size_t truth, int label, const float* values);

  ClassifierModel model_;
  std::mt19937_64 random_;
  std::vector<Cloud> clouds_;
  std::vector<FeatureSamples> features_;  // by true class
};

}  // namespace ladar_perception
