// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/saliency/box_sum_strategy.h"

#include <algorithm>
#include <cassert>

#include "last_visited.h"

namespace ladar_perception {
namespace {

/// Distances X with 2 X < k, as the end of a range.
int distanceEnd(int k) {
  const int end = (k + 1) / 2;
  assert(k >= 1 && end <= ReuseStatistics::kMaxDistance);
  return end;
}

}  // namespace

double ReuseStatistics::reuseShare(int k) const {
  uint64_t count = 0;
  for (int x = 0; x < distanceEnd(k); ++x) count += histogram[x];
  return voxels == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(voxels);
}

double ReuseStatistics::meanDistance(int k) const {
  uint64_t count = 0;
  uint64_t total = 0;
  for (int x = 0; x < distanceEnd(k); ++x) {
    count += histogram[x];
    total += histogram[x] * static_cast<uint64_t>(x);
  }
  return count == 0 ? 0.0 : static_cast<double>(total) / static_cast<double>(count);
}

ReuseStatistics reuseStatistics(const VoxelMap& map, ScanAxis axis) {
  ReuseStatistics statistics;
  LastVisited last_visited(axis);
  last_visited.reset(map.shape());
  const VoxelIndex& min = map.minCorner();
  map.forEachVoxel([&](const VoxelIndex& v, std::size_t slot) {
    const Predecessor from =
        last_visited.visit(v.x - min.x, v.y - min.y, v.z - min.z, static_cast<uint32_t>(slot));
    ++statistics.histogram[std::min(from.distance, ReuseStatistics::kMaxDistance)];
    ++statistics.voxels;
  });
  return statistics;
}

std::unique_ptr<BoxSumStrategy> makeBoxSumStrategy(const std::string& name) {
  if (name == "hash_brute") return makeHashBruteForce();
  if (name == "dense_brute") return makeDenseBruteForce();
  if (name == "naive_scan") return makeNaiveScan();
  if (name == "paper_reuse") return makePaperReuse(ScanAxis::kBest);
  if (name == "paper_reuse_x") return makePaperReuse(ScanAxis::kX);
  if (name == "paper_reuse_y") return makePaperReuse(ScanAxis::kY);
  if (name == "paper_reuse_z") return makePaperReuse(ScanAxis::kZ);
  if (name == "sliding") return makeSliding();
  return nullptr;
}

const std::vector<std::string>& boxSumStrategyNames() {
  static const std::vector<std::string> kNames = {"hash_brute",    "dense_brute",   "naive_scan",
                                                  "paper_reuse",   "paper_reuse_x", "paper_reuse_y",
                                                  "paper_reuse_z", "sliding"};
  return kNames;
}

}  // namespace ladar_perception
