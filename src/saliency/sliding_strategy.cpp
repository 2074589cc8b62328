// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/box_sum_strategy.h"
#include "ladar_perception/saliency/box_sums.h"

namespace ladar_perception {
namespace {

/// Puts sums where their voxels' records lie in the map.
struct SumsBySlot {
  Moments* sums;

  LADAR_INLINE Moments& place(std::size_t slot, int /*x*/, int /*y*/, int /*z*/) const {
    return sums[slot];
  }
};

class Sliding : public BoxSumStrategy {
 public:
  void load(const VoxelMap& map) override { map_ = &map; }

  void compute(int support_radius_voxels, ThreadPool* pool, std::vector<Moments>* sums) override {
    if (windows_.empty() || windows_[0].box().radius_xy != support_radius_voxels) windows_.clear();
    while (static_cast<int>(windows_.size()) < pool->size()) {
      windows_.emplace_back(cube(support_radius_voxels));
    }
    sums->resize(map_->slotBound());
    columns_.assignAll(map_->shape().nx, map_->shape().ny);
    const std::vector<int> rows = shareRows(*map_, columns_, pool->size());
    pool->run([&](int share) {
      windows_[share].compute(*map_, columns_, rows[share], rows[share + 1],
                              SumsBySlot{sums->data()});
    });
  }

  std::size_t memoryBytes() const override {
    std::size_t bytes = map_ == nullptr ? 0 : map_->memoryBytes();
    for (const auto& window : windows_) bytes += window.memoryBytes();
    return bytes;
  }

 private:
  const VoxelMap* map_ = nullptr;
  ColumnSet columns_;
  std::vector<SlidingBoxSums<Moments>> windows_;  // one per thread
};

}  // namespace

std::unique_ptr<BoxSumStrategy> makeSliding() { return std::make_unique<Sliding>(); }

}  // namespace ladar_perception
