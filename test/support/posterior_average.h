// SPDX-License-Identifier: BSD-3-Clause
// Averages of posteriors over cubes, without sliding sums.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/classify/label_smoother.h"
#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/block_math.h"

namespace ladar_perception::test {

/// A probability in whole 65,535ths, a half up.
inline uint16_t wholePosterior(float probability) {
  return static_cast<uint16_t>(std::floor(probability * 65535.0F + 0.5F));
}

/// Whole posteriors of the voxels of a map's window, as an integral volume per class: a sum over
/// any box is eight look-ups, and exact.
class PosteriorAverage {
 public:
  PosteriorAverage(const VoxelMap& map, int classes)
      : min_(map.minCorner()),
        shape_(map.shape()),
        classes_(classes),
        sums_((shape_.nx + std::size_t{1}) * (shape_.ny + 1) * (shape_.nz + 1) * classes, 0) {}

  void set(const VoxelIndex& voxel, const std::vector<uint16_t>& posterior) {
    uint64_t* cell = at(voxel.x - min_.x + 1, voxel.y - min_.y + 1, voxel.z - min_.z + 1);
    std::copy(posterior.begin(), posterior.end(), cell);
  }
  /// Call when all are set.
  void finish() {
    for (int x = 1; x <= shape_.nx; ++x) {
      for (int y = 1; y <= shape_.ny; ++y) {
        for (int z = 1; z <= shape_.nz; ++z) {
          uint64_t* cell = at(x, y, z);
          for (int c = 0; c < classes_; ++c) {
            cell[c] += at(x - 1, y, z)[c] + at(x, y - 1, z)[c] + at(x, y, z - 1)[c] -
                       at(x - 1, y - 1, z)[c] - at(x - 1, y, z - 1)[c] - at(x, y - 1, z - 1)[c] +
                       at(x - 1, y - 1, z - 1)[c];
          }
        }
      }
    }
  }
  /// By class, of the voxels up to `radius` away along each axis.
  std::vector<uint64_t> around(const VoxelIndex& voxel, int radius) {
    const auto low = [&](int i) { return std::max(i - radius, 0); };
    const auto high = [&](int i, int n) { return std::min(i + radius + 1, n); };
    const int x[2] = {low(voxel.x - min_.x), high(voxel.x - min_.x, shape_.nx)};
    const int y[2] = {low(voxel.y - min_.y), high(voxel.y - min_.y, shape_.ny)};
    const int z[2] = {low(voxel.z - min_.z), high(voxel.z - min_.z, shape_.nz)};
    std::vector<uint64_t> sums(classes_, 0);
    for (int corner = 0; corner < 8; ++corner) {
      const int i = corner & 1;
      const int j = corner >> 1 & 1;
      const int k = corner >> 2;
      const uint64_t* cell = at(x[i], y[j], z[k]);
      const uint64_t sign = (i + j + k) % 2 == 1 ? 1 : ~uint64_t{0};
      for (int c = 0; c < classes_; ++c) sums[c] += sign * cell[c];
    }
    return sums;
  }

 private:
  uint64_t* at(int x, int y, int z) {
    const std::size_t row = static_cast<std::size_t>(x) * (shape_.ny + 1) + y;
    return sums_.data() + (row * (shape_.nz + 1) + z) * classes_;
  }

  VoxelIndex min_;
  MapShape shape_;
  int classes_;
  std::vector<uint64_t> sums_;
};

/// What is added to the classes' logarithms; none in the list: nothing.
inline std::vector<float> classOffsets(const std::vector<double>& offsets, std::size_t classes) {
  std::vector<float> all(offsets.begin(), offsets.end());
  all.resize(classes, 0.0F);
  return all;
}

/// Logarithm of a class's share of whole posteriors, which may be none at all.
inline float logShare(const std::vector<uint64_t>& sums, std::size_t c) {
  const uint64_t total = std::accumulate(sums.begin(), sums.end(), uint64_t{0});
  const float share = static_cast<float>(sums[c]) / std::max(static_cast<float>(total), 1.0F);
  return block_math::logPositive(std::max(share, kLeastPosterior));
}

/// Class of a known voxel from whole posteriors: its own, then the sums around it, by radius.
inline Classification smoothedClass(const Classifier& classifier,
                                    const Calibration::Smoothing& smoothing,
                                    const std::vector<std::vector<uint64_t>>& sums) {
  PosteriorBlock block = {};
  block.known[0] = 1;
  const std::vector<float> offsets = classOffsets(smoothing.offsets, classifier.classes());
  for (std::size_t c = 0; c < classifier.classes(); ++c) {
    float log_product = offsets[c];
    for (std::size_t t = 0; t < sums.size(); ++t) {
      log_product += static_cast<float>(smoothing.exponents[t]) * logShare(sums[t], c);
    }
    block.probability[c][0] = log_product;
  }
  classifier.normalize(&block);
  Classification result;
  classifier.choose(block, 1, &result);
  return result;
}

}  // namespace ladar_perception::test
