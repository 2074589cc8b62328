// SPDX-License-Identifier: BSD-3-Clause
// Several supports at once, and supports whose weight falls with the distance.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/saliency/box_sums.h"

namespace ladar_perception {

/// A box with the weight of every point in it.
struct WeightedBox {
  SupportBox box;
  uint32_t weight = 1;
};

/// Boxes around one voxel, the widest first. A point at distance d (infinity norm, voxels) weighs
/// the sum of the weights of the boxes that reach it, so any weights that do not grow with the
/// distance are a stack of boxes, and cost as many box sums as they have steps. Weights are whole
/// numbers, so that weighted sums are exact, too.
using BoxStack = std::vector<WeightedBox>;

/// The stack for `weights[d]` at distance d = 0 .. r, which must be positive and not grow with d;
/// they are rounded to `levels` steps up to weights[0], but never down to 0.
BoxStack makeBoxStack(const std::vector<double>& weights, int levels);
/// exp(-d^2 / (2 sigma^2)) with sigma = r / 2, in four levels: 4 4 2 1 1 for r = 4.
BoxStack gaussianBoxStack(int radius);
/// Weight of a point at distance d.
uint32_t weightAt(const BoxStack& stack, int distance);
/// Points a voxel may hold so that weighted sums stay exact (see maxPointsPerVoxel of a radius).
uint32_t maxPointsPerVoxel(const BoxStack& stack);

/// Sums over the boxes of a stack, weighted.
template <typename Sum>
LADAR_INLINE Sum weightedSum(const BoxStack& stack, const Sum* sums) {
  Sum result;
  for (std::size_t i = 0; i < stack.size(); ++i) {
    Sum sum = sums[i];
    sum *= stack[i].weight;
    result += sum;
  }
  return result;
}

/// Sliding sums over several boxes around every voxel, in one pass over the map.
template <typename Sum>
class BoxStackSums {
 public:
  explicit BoxStackSums(const std::vector<SupportBox>& boxes)
      : windows_(boxes.begin(), boxes.end()) {}

  std::size_t memoryBytes() const {
    std::size_t bytes = sums_.capacity() * sizeof(Sum) + voxels_.capacity() * sizeof(Voxel);
    for (const auto& window : windows_) bytes += window.memoryBytes();
    return bytes;
  }

  /// As SlidingBoxSums::compute, but calls `output.accept(slot, x, y, z, sums)` for every voxel
  /// with one sum per box, in the order given.
  template <typename Map, typename Output>
  void compute(const Map& map, const ColumnSet& columns, int y_begin, int y_end, Output&& output) {
    dispatchWide([&](auto width) LADAR_INLINE_LAMBDA {
      for (auto& window : windows_) window.begin(map, columns, y_begin);
      for (int y = y_begin; y < y_end; ++y) {
        for (std::size_t i = 0; i < windows_.size(); ++i) {
          RowOutput row{this, i};
          windows_[i].computeRow(map, columns, y, width, row);
          row_size_ = row.size;
        }
        for (std::size_t i = 0; i < row_size_; ++i) {
          const Voxel& voxel = voxels_[i];
          output.accept(voxel.slot, voxel.x, y, voxel.z, sums_.data() + i * windows_.size());
        }
      }
      for (auto& window : windows_) window.end(map, y_end);
    });
  }

 private:
  struct Voxel {
    std::size_t slot;
    int x;
    int z;
  };
  /// The voxels of a row come in the same order from every window.
  struct RowOutput {
    BoxStackSums* stack;
    std::size_t window;
    std::size_t size = 0;

    LADAR_INLINE Sum& place(std::size_t slot, int x, int /*y*/, int z) {
      if (size == stack->voxels_.size()) {
        stack->voxels_.resize(2 * size + 64);
        stack->sums_.resize(stack->voxels_.size() * stack->windows_.size());
      }
      stack->voxels_[size] = {slot, x, z};
      return stack->sums_[size++ * stack->windows_.size() + window];
    }
  };

  std::vector<SlidingBoxSums<Sum>> windows_;
  std::vector<Voxel> voxels_;  // of the present row; row_size_ of them
  std::vector<Sum> sums_;      // by voxel of the row, then by window
  std::size_t row_size_ = 0;
};

}  // namespace ladar_perception
