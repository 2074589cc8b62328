// SPDX-License-Identifier: BSD-3-Clause
#include "dense_grid.h"
#include "ladar_perception/saliency/box_sum_strategy.h"
#include "last_visited.h"

namespace ladar_perception {

void DenseGrid::load(const VoxelMap& map) {
  shape_ = map.shape();
  slot_bound_ = map.slotBound();
  column_stride_ = static_cast<std::size_t>(shape_.nz) | 1;
  row_stride_ = (shape_.nx * column_stride_) | 1;
  records_.assign(shape_.ny * row_stride_, Moments());
  slots_.assign(static_cast<std::size_t>(shape_.nx) * shape_.ny * shape_.nz, kEmpty);
  const VoxelIndex& min = map.minCorner();
  map.forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
    const auto x = static_cast<std::size_t>(voxel.x - min.x);
    const auto y = static_cast<std::size_t>(voxel.y - min.y);
    const auto z = static_cast<std::size_t>(voxel.z - min.z);
    records_[y * row_stride_ + x * column_stride_ + z] = map.record(slot);
    slots_[(y * shape_.nx + x) * shape_.nz + z] = static_cast<uint32_t>(slot);
  });
}

namespace {

/// Calls `visit(x, y, z, slot)` for every occupied voxel of the grid, in scan order.
template <typename Visitor>
LADAR_INLINE void scanOccupied(const DenseGrid& grid, Visitor&& visit) {
  const MapShape shape = grid.shape();
  for (int y = 0; y < shape.ny; ++y) {
    for (int x = 0; x < shape.nx; ++x) {
      const uint32_t* slots = grid.slots(x, y);
      for (int z = 0; z < shape.nz; ++z) {
        if (slots[z] != DenseGrid::kEmpty) visit(x, y, z, slots[z]);
      }
    }
  }
}

class DenseBruteForce : public BoxSumStrategy {
 public:
  void load(const VoxelMap& map) override { grid_.load(map); }

  void compute(int support_radius_voxels, ThreadPool* /*pool*/,
               std::vector<Moments>* sums) override {
    sums->resize(grid_.slotBound());
    const int r = support_radius_voxels;
    dispatch([&]() LADAR_INLINE_LAMBDA {
      scanOccupied(grid_, [&](int x, int y, int z, uint32_t slot) LADAR_INLINE_LAMBDA {
        (*sums)[slot] = grid_.sum(grid_.boxAround(x, y, z, r));
      });
    });
  }

  std::size_t memoryBytes() const override { return grid_.memoryBytes(); }

 private:
  DenseGrid grid_;
};

class NaiveScan : public BoxSumStrategy {
 public:
  void load(const VoxelMap& map) override { grid_.load(map); }

  void compute(int support_radius_voxels, ThreadPool* /*pool*/,
               std::vector<Moments>* sums) override {
    sums->resize(grid_.slotBound());
    const MapShape shape = grid_.shape();
    const int r = support_radius_voxels;
    dispatch([&]() LADAR_INLINE_LAMBDA {
      for (int y = 0; y < shape.ny; ++y) {
        line_.assign(shape.nz, Moments());
        for (int x = 0; x < std::min(r, shape.nx); ++x) enterSlice(x, y, r);
        for (int x = 0; x < shape.nx; ++x) {
          if (x + r < shape.nx) enterSlice(x + r, y, r);
          if (x - r - 1 >= 0) leaveSlice(x - r - 1, y, r);
          keepOccupied(grid_.slots(x, y), sums->data());
        }
      }
    });
  }

  std::size_t memoryBytes() const override {
    return grid_.memoryBytes() + line_.capacity() * sizeof(Moments);
  }

 private:
  // All heights slide together: one after the other, each would read the k rows of the grid from
  // far memory again.
  LADAR_INLINE void enterSlice(int x, int y, int r) {
    for (int z = 0; z < grid_.shape().nz; ++z) line_[z] += grid_.sum(slice(x, y, z, r));
  }
  LADAR_INLINE void leaveSlice(int x, int y, int r) {
    for (int z = 0; z < grid_.shape().nz; ++z) line_[z] -= grid_.sum(slice(x, y, z, r));
  }
  LADAR_INLINE VoxelBox slice(int x, int y, int z, int r) const {
    VoxelBox box = grid_.boxAround(x, y, z, r);
    box.begin[0] = x;
    box.end[0] = x + 1;
    return box;
  }
  LADAR_INLINE void keepOccupied(const uint32_t* slots, Moments* sums) const {
    for (int z = 0; z < grid_.shape().nz; ++z) {
      if (slots[z] != DenseGrid::kEmpty) sums[slots[z]] = line_[z];
    }
  }

  DenseGrid grid_;
  std::vector<Moments> line_;  // by z: sums around the voxels of the column being visited
};

class PaperReuse : public BoxSumStrategy {
 public:
  explicit PaperReuse(ScanAxis axis) : last_visited_(axis) {}

  void load(const VoxelMap& map) override { grid_.load(map); }

  void compute(int support_radius_voxels, ThreadPool* /*pool*/,
               std::vector<Moments>* sums) override {
    sums->resize(grid_.slotBound());
    last_visited_.reset(grid_.shape());
    const int r = support_radius_voxels;
    dispatch([&]() LADAR_INLINE_LAMBDA {
      scanOccupied(grid_, [&](int x, int y, int z, uint32_t slot) LADAR_INLINE_LAMBDA {
        const VoxelBox box = grid_.boxAround(x, y, z, r);
        const Predecessor from = last_visited_.visit(x, y, z, slot);
        if (2 * from.distance >= 2 * r + 1) {
          (*sums)[slot] = grid_.sum(box);
        } else if (from.axis == 0) {
          (*sums)[slot] = slide<0>((*sums)[from.slot], box, x - from.distance, r);
        } else if (from.axis == 1) {
          (*sums)[slot] = slide<1>((*sums)[from.slot], box, y - from.distance, r);
        } else {
          (*sums)[slot] = slide<2>((*sums)[from.slot], box, z - from.distance, r);
        }
      });
    });
  }

  std::size_t memoryBytes() const override {
    return grid_.memoryBytes() + last_visited_.memoryBytes();
  }

 private:
  /// The sum of the predecessor, which is at `from` on its axis, without the slices behind `box`
  /// and with the foremost ones of it.
  template <int kAxis>
  LADAR_INLINE Moments slide(const Moments& previous, const VoxelBox& box, int from, int r) const {
    const int size[3] = {grid_.shape().nx, grid_.shape().ny, grid_.shape().nz};
    VoxelBox leaving = box;
    leaving.begin[kAxis] = std::max(from - r, 0);
    leaving.end[kAxis] = box.begin[kAxis];
    VoxelBox entering = box;
    entering.begin[kAxis] = std::min(from + r + 1, size[kAxis]);
    Moments sum = previous;
    sum -= grid_.sum(leaving);
    sum += grid_.sum(entering);
    return sum;
  }

  DenseGrid grid_;
  LastVisited last_visited_;
};

}  // namespace

std::unique_ptr<BoxSumStrategy> makeDenseBruteForce() {
  return std::make_unique<DenseBruteForce>();
}
std::unique_ptr<BoxSumStrategy> makeNaiveScan() { return std::make_unique<NaiveScan>(); }
std::unique_ptr<BoxSumStrategy> makePaperReuse(ScanAxis axis) {
  return std::make_unique<PaperReuse>(axis);
}

}  // namespace ladar_perception
