// SPDX-License-Identifier: BSD-3-Clause
// Every way of summing moments over the support volumes of a whole map, behind one seam: the
// strategies of Lalonde, Vandapel and Hebert 2005 and the one the package runs on. They are each
// other's oracles, and the benchmarks compare them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ladar_perception/map/voxel_map.h"
#include "ladar_perception/util/thread_pool.h"

namespace ladar_perception {

/// Sums the moments over the cube of k = 2 r + 1 voxels a side around every occupied voxel. All
/// strategies give the same bits.
class BoxSumStrategy {
 public:
  virtual ~BoxSumStrategy() = default;

  /// Lays the records out the way the strategy wants them (on a vehicle they would be inserted
  /// there in the first place, so this is no part of what a strategy costs). To be called again
  /// when the map has changed.
  virtual void load(const VoxelMap& map) = 0;
  /// One sum per occupied voxel of the loaded map, by the map's slots; `sums` has
  /// `map.slotBound()` entries, those of empty slots hold anything. Strategies of the paper run on
  /// one thread, whatever the pool.
  virtual void compute(int support_radius_voxels, ThreadPool* pool, std::vector<Moments>* sums) = 0;
  /// Bytes of the layout.
  virtual std::size_t memoryBytes() const = 0;
};

/// Axis along which a voxel's predecessor is looked for; `kBest` takes the nearest of the three.
enum class ScanAxis { kX, kY, kZ, kBest };

/// What re-use had to work with, over all occupied voxels of a map.
struct ReuseStatistics {
  static constexpr int kMaxDistance = 32;
  /// Voxels by the distance X to the nearest occupied voxel already visited: histogram[i] for
  /// X = i < kMaxDistance, the last entry for farther ones and for none at all.
  std::array<uint64_t, kMaxDistance + 1> histogram{};
  uint64_t voxels = 0;

  /// P[X < k / 2]: share of the voxels that could re-use a sum.
  double reuseShare(int k) const;
  /// d: mean distance over those voxels.
  double meanDistance(int k) const;
};

/// Brute force on a hash map, voxels in random order: k^3 look-ups each.
std::unique_ptr<BoxSumStrategy> makeHashBruteForce();
/// Brute force on a dense array: k^3 visits for each occupied voxel.
std::unique_ptr<BoxSumStrategy> makeDenseBruteForce();
/// Ordered scan of every voxel of a dense array, empty or not, sliding by one slice along x:
/// 2 k^2 visits each.
std::unique_ptr<BoxSumStrategy> makeNaiveScan();
/// Algorithm 1 of the paper on a dense array: three arrays of pointers to the occupied voxels
/// visited last along x, y and z; from the nearest, if it is nearer than k / 2, d slices are
/// subtracted and d added (2 d k^2 visits), else all k^3 voxels are summed.
std::unique_ptr<BoxSumStrategy> makePaperReuse(ScanAxis axis = ScanAxis::kBest);
/// The package's own: `SlidingBoxSums`, on the map itself.
std::unique_ptr<BoxSumStrategy> makeSliding();

/// Strategy by its name in benchmarks: hash_brute, dense_brute, naive_scan, paper_reuse,
/// paper_reuse_x, paper_reuse_y, paper_reuse_z, sliding; nullptr for any other.
std::unique_ptr<BoxSumStrategy> makeBoxSumStrategy(const std::string& name);
const std::vector<std::string>& boxSumStrategyNames();

/// The distances X that Algorithm 1 meets when it looks along `axis`.
ReuseStatistics reuseStatistics(const VoxelMap& map, ScanAxis axis);

}  // namespace ladar_perception
