// SPDX-License-Identifier: BSD-3-Clause
// Labels from the posteriors of a voxel and its neighbours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/map/column_set.h"
#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Labels voxels by their own posteriors and the means of those in cubes around them, by sliding
/// sums: what stands together mostly is of one class. How much each says is the model's calibration.
/// Unknown voxels stay unknown and give nothing to others. Posteriors are kept as whole 65,535ths,
/// so results are the same bits whatever is computed anew.
class LabelSmoother {
 public:
  /// For the classes of `classifier` (which must outlive the smoother).
  static std::unique_ptr<LabelSmoother> make(const Classifier& classifier,
                                             const Calibration::Smoothing& smoothing, int threads);
  virtual ~LabelSmoother() = default;

  /// How far a voxel changes the labels of others.
  int reach() const;
  float temperature() const { return static_cast<float>(smoothing_.temperature); }

  /// Makes room for posteriors of slots below `slots`.
  virtual void resize(std::size_t slots) = 0;
  /// Keeps the posteriors of the first `count` voxels of a block, of which these are the slots.
  virtual void keep(const PosteriorBlock& block, const uint32_t* slots, int count) = 0;
  /// Labels of the occupied voxels of `columns`, by slot of the map. `terms`, if not null, gets the
  /// logarithms that the exponents are multiplied with, by slot, then own and radii, then class.
  virtual void label(const VoxelMap& map, const ColumnSet& columns, ThreadPool* pool,
                     std::vector<Classification>* labels, std::vector<float>* terms) = 0;
  virtual std::size_t memoryBytes() const = 0;

 protected:
  LabelSmoother(const Classifier& classifier, const Calibration::Smoothing& smoothing);

  const Classifier& classifier_;
  Calibration::Smoothing smoothing_;
};

/// Probabilities below this count as this: how sure the evidence of one place can be.
constexpr float kLeastPosterior = 1e-4F;

}  // namespace ladar_perception
