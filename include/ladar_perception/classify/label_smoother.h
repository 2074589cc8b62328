// SPDX-License-Identifier: BSD-3-Clause
// Labels from the posteriors of a voxel and its neighbours.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/map/column_set.h"
#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Averages the posteriors of a map's voxels over a cube around each, by sliding sums: what stands
/// together mostly is of one class. Unknown voxels stay unknown and give nothing to others. The
/// posteriors are kept as whole 65,535ths, so results are the same bits whatever is computed anew.
class LabelSmoother {
 public:
  /// For the classes of `classifier` (which must outlive the smoother), at its model's calibration.
  static std::unique_ptr<LabelSmoother> make(const Classifier& classifier,
                                             const Calibration& calibration, int threads);
  virtual ~LabelSmoother() = default;

  int radius() const { return calibration_.smoothing_radius_voxels; }
  float temperature() const { return static_cast<float>(calibration_.smoothing_temperature); }

  /// Makes room for posteriors of slots below `slots`.
  virtual void resize(std::size_t slots) = 0;
  /// Keeps the posteriors of the first `count` voxels of a block, of which these are the slots.
  virtual void keep(const PosteriorBlock& block, const uint32_t* slots, int count) = 0;
  /// Labels of the occupied voxels of `columns`, by slot of the map.
  virtual void label(const VoxelMap& map, const ColumnSet& columns, ThreadPool* pool,
                     std::vector<Classification>* labels) = 0;
  virtual std::size_t memoryBytes() const = 0;

 protected:
  LabelSmoother(const Classifier& classifier, const Calibration& calibration)
      : classifier_(classifier), calibration_(calibration) {}

  const Classifier& classifier_;
  Calibration calibration_;
};

}  // namespace ladar_perception
