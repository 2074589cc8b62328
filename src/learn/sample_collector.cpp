// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/sample_collector.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <tuple>

#include "ladar_perception/learn/labelled_pass.h"

namespace ladar_perception {
namespace {

// So many times the samples that are wanted are kept until the end: how they are shared between
// inputs is known only then.
constexpr std::size_t kKeptTimes = 4;

bool allFinite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

}  // namespace

std::vector<std::size_t> evenShares(const std::vector<std::size_t>& sizes, std::size_t total) {
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sizes[a] < sizes[b]; });
  std::vector<std::size_t> shares(sizes.size());
  // From the smallest: each takes its part of what is left, or all it has.
  for (std::size_t i = 0; i < order.size(); ++i) {
    shares[order[i]] = std::min(sizes[order[i]], total / (order.size() - i));
    total -= shares[order[i]];
  }
  return shares;
}

bool SampleCollector::PlaceKey::operator<(const PlaceKey& other) const {
  return std::tie(input, file, x, y) < std::tie(other.input, other.file, other.x, other.y);
}

SampleCollector::SampleCollector(std::size_t classes, std::size_t features,
                                 std::size_t samples_per_class, uint64_t seed)
    : features_(features), samples_per_class_(samples_per_class), random_(seed), pools_(classes) {
  assert(classes <= kMaxClasses && samples_per_class > 0);
  for (Pool& pool : pools_) pool.thin_at = kKeptTimes * samples_per_class;
}

bool SampleCollector::isNewInScan(std::size_t slot, std::size_t class_index) {
  const auto bit = static_cast<uint16_t>(1U << class_index);
  if ((seen_[slot] & bit) != 0) return false;
  seen_[slot] = static_cast<uint16_t>(seen_[slot] | bit);
  return true;
}

void SampleCollector::add(const TerrainPipeline& pipeline, const std::vector<double>& truth) {
  const VoxelMap& map = pipeline.map();
  const std::vector<VoxelIndex> voxels = voxelsBySlot(map);
  const auto least = static_cast<uint32_t>(pipeline.config().min_support_points);
  const double places_per_voxel = pipeline.config().voxel_size_m / kPlace_m;
  const auto placeOf = [&](int32_t voxel) {
    return static_cast<int32_t>(std::floor((voxel + 0.5) * places_per_voxel));
  };
  seen_.assign(map.slotBound(), 0);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!(truth[i] >= 1.0 && truth[i] <= static_cast<double>(pools_.size()))) continue;
    const std::size_t class_index = static_cast<std::size_t>(truth[i]) - 1;
    Pool& pool = pools_[class_index];
    ++pool.counts.points;
    const CellId cell = pipeline.pointCells()[i];
    if (cell == kNoCell) continue;
    const std::size_t slot = map.slotOf(cell);
    const SaliencyF& saliency = pipeline.saliency(slot);
    if (!saliency.defined || saliency.points < least) continue;
    const float* values = pipeline.features(slot);
    if (!allFinite(values, features_)) continue;
    ++pool.counts.points_used;
    if (!isNewInScan(slot, class_index)) continue;
    offer(&pool, {input_, file_, placeOf(voxels[slot].x), placeOf(voxels[slot].y)}, values);
  }
}

void SampleCollector::offer(Pool* pool, const PlaceKey& key, const float* values) {
  ++pool->counts.voxels;
  Place& place = pool->places[key];
  const uint64_t random = random_();
  if (random >= place.key_limit) return;
  place.candidates.push_back({random, std::vector<float>(values, values + features_)});
  if (++pool->kept >= pool->thin_at) thinOut(pool, kKeptTimes * samples_per_class_ / 2);
}

/// Every input's share, and of it every place's, in the order of the map.
std::vector<std::size_t> SampleCollector::sharesOfPlaces(const Pool& pool, std::size_t total) {
  std::map<int, std::vector<std::size_t>> sizes_by_input;
  for (const auto& [key, place] : pool.places) {
    sizes_by_input[key.input].push_back(place.candidates.size());
  }
  std::vector<std::size_t> input_sizes;
  for (const auto& [input, sizes] : sizes_by_input) {
    input_sizes.push_back(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
  }
  const std::vector<std::size_t> input_shares = evenShares(input_sizes, total);
  std::vector<std::size_t> shares;
  auto input_share = input_shares.begin();
  for (const auto& [input, sizes] : sizes_by_input) {
    for (const std::size_t share : evenShares(sizes, *input_share)) shares.push_back(share);
    ++input_share;
  }
  return shares;
}

/// Leaves about `most` candidates, shared as samples will be. What stays of a place is what has
/// keys below a limit, now and later: still a random part of all that it had to offer.
void SampleCollector::thinOut(Pool* pool, std::size_t most) {
  const std::vector<std::size_t> shares = sharesOfPlaces(*pool, most);
  auto share = shares.begin();
  pool->kept = 0;
  for (auto& entry : pool->places) {
    Place& place = entry.second;
    const std::size_t stay = std::max<std::size_t>(*share++, 1);
    if (stay < place.candidates.size()) {
      const auto limit = place.candidates.begin() + static_cast<std::ptrdiff_t>(stay);
      std::nth_element(place.candidates.begin(), limit, place.candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.key < b.key; });
      place.key_limit = limit->key;
      place.candidates.erase(limit, place.candidates.end());
    }
    pool->kept += place.candidates.size();
  }
  // Where there are more places than samples, one of each stays all the same.
  pool->thin_at = std::max(pool->thin_at, 2 * pool->kept);
}

ClassCounts SampleCollector::counts(std::size_t class_index) const {
  ClassCounts counts = pools_[class_index].counts;
  counts.places = pools_[class_index].places.size();
  return counts;
}

Samples SampleCollector::samples(std::size_t class_index) const {
  const Pool& pool = pools_[class_index];
  const std::vector<std::size_t> shares = sharesOfPlaces(pool, samples_per_class_);
  const std::size_t total = std::accumulate(shares.begin(), shares.end(), std::size_t{0});
  Samples samples;
  samples.values.resize(static_cast<Eigen::Index>(features_), static_cast<Eigen::Index>(total));
  std::size_t number = 0;
  for (const auto& entry : pool.places) {
    std::vector<const Candidate*> candidates;
    for (const Candidate& candidate : entry.second.candidates) candidates.push_back(&candidate);
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate* a, const Candidate* b) { return a->key < b->key; });
    for (std::size_t i = 0; i < shares[number]; ++i) {
      const auto column = static_cast<Eigen::Index>(samples.places.size());
      samples.values.col(column) =
          Eigen::Map<const Eigen::VectorXf>(candidates[i]->values.data(), samples.values.rows())
              .cast<double>();
      samples.places.push_back(number);
    }
    ++number;
  }
  return samples;
}

}  // namespace ladar_perception
