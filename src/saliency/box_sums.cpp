// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/box_sums.h"

#include <algorithm>

#include "ladar_perception/map/bit_mask.h"

namespace ladar_perception {
namespace {

// An odd number of cache lines between columns of the plane spreads them over all cache sets;
// with a power of two the same heights of neighbouring columns evict each other.
int planeStride(const VoxelMap& map) { return map.shape().nz | 1; }

/// First slab of a thread's share, balanced by occupied voxels.
int slabOfShare(const VoxelOrder& order, int share, int shares) {
  const std::size_t target = order.rows * share / shares;
  const auto it = std::lower_bound(order.row_begin.begin(), order.row_begin.end(), target);
  return static_cast<int>(it - order.row_begin.begin());
}

}  // namespace

void VoxelOrder::update(const VoxelMap& map) {
  const MapShape& shape = map.shape();
  first_row.resize(map.columnCount());
  row_begin.resize(shape.ny + 1);
  uint32_t row = 0;
  for (int y = 0; y < shape.ny; ++y) {
    row_begin[y] = row;
    for (int x = 0; x < shape.nx; ++x) {
      const int column = map.columnAt(x, y);
      first_row[column] = row;
      row += map.recordCount(column);
    }
  }
  row_begin[shape.ny] = row;
  rows = row;
}

void VoxelOrder::listVoxels(const VoxelMap& map, std::vector<VoxelIndex>* voxels) const {
  voxels->resize(rows);
  std::size_t row = 0;
  const VoxelIndex& min = map.minCorner();
  for (int y = 0; y < map.shape().ny; ++y) {
    for (int x = 0; x < map.shape().nx; ++x) {
      bit_mask::forEachSet(map.mask(map.columnAt(x, y)), map.maskWords(), [&](int z) {
        (*voxels)[row++] = {min.x + x, min.y + y, min.z + z};
      });
    }
  }
}

void SlidingBoxSums::compute(const VoxelMap& map, const VoxelOrder& order, ThreadPool* pool,
                             std::vector<Moments>* sums) {
  sums->resize(order.rows);
  windows_.resize(pool->size());
  const int ny = map.shape().ny;
  pool->run([&](int share) {
    const int shares = pool->size();
    const int y_begin = share == 0 ? 0 : slabOfShare(order, share, shares);
    const int y_end = share + 1 == shares ? ny : slabOfShare(order, share + 1, shares);
    computeSlabs(map, order, std::min(y_begin, ny), std::min(y_end, ny), &windows_[share],
                 sums->data());
  });
}

std::size_t SlidingBoxSums::memoryBytes() const {
  std::size_t bytes = 0;
  for (const Window& window : windows_) {
    bytes += (window.plane.capacity() + window.line.capacity()) * sizeof(Moments) +
             window.plane_masks.capacity() * sizeof(uint64_t);
  }
  return bytes;
}

void SlidingBoxSums::computeSlabs(const VoxelMap& map, const VoxelOrder& order, int y_begin,
                                  int y_end, Window* window, Moments* sums) const {
  if (y_begin >= y_end) return;
  const MapShape& shape = map.shape();
  window->plane.assign(static_cast<std::size_t>(shape.nx) * planeStride(map), Moments());
  window->plane_masks.assign(static_cast<std::size_t>(shape.nx) * map.maskWords(), 0);
  window->line.assign(shape.nz + 2 * radius_, Moments());
  for (int y = y_begin - radius_; y < y_begin + radius_; ++y) addSlab(map, y, false, window);
  Moments* out = sums + order.row_begin[y_begin];
  for (int y = y_begin; y < y_end; ++y) {
    addSlab(map, y + radius_, false, window);
    if (y > y_begin) addSlab(map, y - radius_ - 1, true, window);
    updatePlaneMasks(map, y, window);
    slideAlongX(map, y, window, &out);
  }
}

void SlidingBoxSums::addSlab(const VoxelMap& map, int y, bool subtract, Window* window) const {
  if (y < 0 || y >= map.shape().ny) return;
  for (int x = 0; x < map.shape().nx; ++x) {
    const int column = map.columnAt(x, y);
    if (map.recordCount(column) == 0) continue;
    const Moments* record = map.records(column);
    Moments* plane = window->plane.data() + static_cast<std::size_t>(x) * planeStride(map);
    bit_mask::forEachSet(map.mask(column), map.maskWords(), [&](int z) {
      if (subtract) {
        plane[z] -= *record++;
      } else {
        plane[z] += *record++;
      }
    });
  }
}

void SlidingBoxSums::updatePlaneMasks(const VoxelMap& map, int y, Window* window) const {
  const int words = map.maskWords();
  std::fill(window->plane_masks.begin(), window->plane_masks.end(), 0);
  const int y_first = std::max(y - radius_, 0);
  const int y_last = std::min(y + radius_, map.shape().ny - 1);
  for (int yy = y_first; yy <= y_last; ++yy) {
    uint64_t* out = window->plane_masks.data();
    for (int x = 0; x < map.shape().nx; ++x) {
      const uint64_t* mask = map.mask(map.columnAt(x, yy));
      for (int word = 0; word < words; ++word) *out++ |= mask[word];
    }
  }
}

void SlidingBoxSums::slideAlongX(const VoxelMap& map, int y, Window* window, Moments** out) const {
  std::fill(window->line.begin(), window->line.end(), Moments());
  for (int x = -radius_; x < radius_; ++x) addColumn(map, x, false, window);
  for (int x = 0; x < map.shape().nx; ++x) {
    addColumn(map, x + radius_, false, window);
    addColumn(map, x - radius_ - 1, true, window);
    const int column = map.columnAt(x, y);
    if (map.recordCount(column) == 0) continue;
    // line[z] .. line[z + 2 r] are heights z - r .. z + r.
    const Moments* line = window->line.data();
    const int k = 2 * radius_ + 1;
    Moments sum;
    int sum_z = -2 * k;
    bit_mask::forEachSet(map.mask(column), map.maskWords(), [&](int z) {
      if (2 * (z - sum_z) < k) {
        for (; sum_z < z; ++sum_z) {
          sum += line[sum_z + k];
          sum -= line[sum_z];
        }
      } else {
        sum = line[z];
        for (int i = 1; i < k; ++i) sum += line[z + i];
        sum_z = z;
      }
      *(*out)++ = sum;
    });
  }
}

void SlidingBoxSums::addColumn(const VoxelMap& map, int x, bool subtract, Window* window) const {
  if (x < 0 || x >= map.shape().nx) return;
  const Moments* plane = window->plane.data() + static_cast<std::size_t>(x) * planeStride(map);
  Moments* line = window->line.data() + radius_;
  const uint64_t* mask = window->plane_masks.data() + static_cast<std::size_t>(x) * map.maskWords();
  bit_mask::forEachSet(mask, map.maskWords(), [&](int z) {
    if (subtract) {
      line[z] -= plane[z];
    } else {
      line[z] += plane[z];
    }
  });
}

}  // namespace ladar_perception
