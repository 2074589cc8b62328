// SPDX-License-Identifier: BSD-3-Clause
// The scrolling map as a plain ordered dictionary, and helpers to compare and to draw maps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "ladar_perception/map/bit_mask.h"
#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception {

inline void PrintTo(const VoxelIndex& v, std::ostream* out) {
  *out << "voxel (" << v.x << ", " << v.y << ", " << v.z << ")";
}

}  // namespace ladar_perception

namespace ladar_perception::test {

/// "20x20x64", to name tests by.
inline std::string shapeName(const MapShape& shape) {
  return std::to_string(shape.nx) + "x" + std::to_string(shape.ny) + "x" + std::to_string(shape.nz);
}

/// A voxel with its moments.
struct VoxelRecord {
  VoxelIndex voxel;
  Moments moments;

  bool operator==(const VoxelRecord& other) const {
    return voxel == other.voxel && moments == other.moments;
  }
};

inline void PrintTo(const VoxelRecord& record, std::ostream* out) {
  ladar_perception::PrintTo(record.voxel, out);
  *out << " with " << record.moments.count() << " points";
}

class MapOracle {
 public:
  MapOracle(const MapShape& shape, uint32_t max_points) : shape_(shape), max_points_(max_points) {}

  VoxelMap::InsertResult insert(const FixedPoint& q) {
    // Floor division, written the long way.
    const Key key = {floorDivide(q.y), floorDivide(q.x), floorDivide(q.z)};
    if (!inside(key)) return VoxelMap::InsertResult::kOutside;
    Moments& record = voxels_[key];
    if (record.count() >= max_points_) return VoxelMap::InsertResult::kSaturated;
    record.add(q);
    return VoxelMap::InsertResult::kInserted;
  }
  void scrollTo(const VoxelIndex& min_corner) {
    min_ = {min_corner.y, min_corner.x, min_corner.z};
    for (auto it = voxels_.begin(); it != voxels_.end();) {
      it = inside(it->first) ? std::next(it) : voxels_.erase(it);
    }
  }
  void clear() { voxels_.clear(); }
  const Moments* find(const VoxelIndex& v) const {
    const auto it = voxels_.find({v.y, v.x, v.z});
    return it == voxels_.end() ? nullptr : &it->second;
  }
  /// Sum over the cube of 2 r + 1 voxels a side, by as many look-ups.
  Moments boxSum(const VoxelIndex& center, int r) const {
    Moments sum;
    for (int dy = -r; dy <= r; ++dy) {
      for (int dx = -r; dx <= r; ++dx) {
        for (int dz = -r; dz <= r; ++dz) {
          const Moments* record = find({center.x + dx, center.y + dy, center.z + dz});
          if (record != nullptr) sum += *record;
        }
      }
    }
    return sum;
  }
  std::size_t occupied() const { return voxels_.size(); }
  /// In the map's documented order: by y, then x, then z.
  std::vector<VoxelRecord> list() const {
    std::vector<VoxelRecord> records;
    for (const auto& [key, moments] : voxels_) {
      records.push_back({{static_cast<int32_t>(key[1]), static_cast<int32_t>(key[0]),
                          static_cast<int32_t>(key[2])},
                         moments});
    }
    return records;
  }

 private:
  using Key = std::array<int64_t, 3>;  // y, x, z

  static int64_t floorDivide(int64_t q) {
    return q >= 0 ? q / kStepsPerVoxel : -((-q + kStepsPerVoxel - 1) / kStepsPerVoxel);
  }
  bool inside(const Key& key) const {
    const int64_t size[3] = {shape_.ny, shape_.nx, shape_.nz};
    for (int i = 0; i < 3; ++i) {
      if (key[i] < min_[i] || key[i] >= min_[i] + size[i]) return false;
    }
    return true;
  }

  MapShape shape_;
  uint32_t max_points_;
  Key min_ = {0, 0, 0};
  std::map<Key, Moments> voxels_;
};

/// Every record of the map in its order of iteration: columns by local y, then x, then z.
inline std::vector<VoxelRecord> listRecords(const VoxelMap& map) {
  std::vector<VoxelRecord> records;
  const VoxelIndex& min = map.minCorner();
  for (int y = 0; y < map.shape().ny; ++y) {
    for (int x = 0; x < map.shape().nx; ++x) {
      const int column = map.columnAt(x, y);
      const Moments* record = map.records(column);
      bit_mask::forEachSet(map.mask(column), map.maskWords(), [&](int z) {
        records.push_back({{min.x + x, min.y + y, min.z + z}, *record++});
      });
    }
  }
  return records;
}

/// A point in a voxel, at a place within it.
inline FixedPoint pointIn(const VoxelIndex& voxel, int sx = 128, int sy = 128, int sz = 128) {
  return {voxel.x * kStepsPerVoxel + sx, voxel.y * kStepsPerVoxel + sy,
          voxel.z * kStepsPerVoxel + sz};
}

/// Occupied voxels of the layer at world height z: '#' occupied, '.' empty, +y up, +x right.
inline std::string drawLayer(const VoxelMap& map, int z) {
  std::string picture;
  const VoxelIndex& min = map.minCorner();
  for (int y = map.shape().ny - 1; y >= 0; --y) {
    for (int x = 0; x < map.shape().nx; ++x) {
      picture += map.find({min.x + x, min.y + y, z}) != nullptr ? '#' : '.';
    }
    picture += '\n';
  }
  return picture;
}

}  // namespace ladar_perception::test
