// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/sample_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ladar_perception {
namespace {

constexpr std::size_t kBucket = 16;
constexpr float kChosen = -1.0F;

/// Distances of places to the chosen ones, in buckets with a box and the greatest of each.
class Buckets {
 public:
  explicit Buckets(const std::vector<WeightedPlace>& places) : size_(places.size()) {
    const std::size_t padded = (size_ + kBucket - 1) / kBucket * kBucket;
    for (auto& axis : axes_) axis.assign(padded, 0.0F);
    slowness_.assign(padded, 0.0F);
    distances_.assign(padded, kChosen);
    const std::size_t buckets = padded / kBucket;
    while (leaves_ < buckets) leaves_ *= 2;
    boxes_.resize(2 * leaves_);
    tree_.assign(2 * leaves_, kChosen);
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        axes_[axis][i] = places[i].position[static_cast<int>(axis)];
      }
      slowness_[i] = places[i].slowness;
      distances_[i] = std::numeric_limits<float>::max();
      boxes_[leaves_ + i / kBucket].include(places[i]);
    }
    for (std::size_t b = 0; b < buckets; ++b) tree_[leaves_ + b] = distances_[b * kBucket];
    for (std::size_t node = leaves_ - 1; node > 0; --node) {
      boxes_[node] = boxes_[2 * node];
      boxes_[node].include(boxes_[2 * node + 1]);
      update(node);
    }
  }

  float greatest() const { return tree_[1]; }

  std::size_t farthest() const {
    std::size_t node = 1;
    while (node < leaves_) node = 2 * node + (tree_[2 * node + 1] > tree_[2 * node] ? 1 : 0);
    const std::size_t first = (node - leaves_) * kBucket;
    const auto begin = distances_.begin() + static_cast<std::ptrdiff_t>(first);
    return first + static_cast<std::size_t>(std::max_element(begin, begin + kBucket) - begin);
  }

  void choose(std::size_t place) {
    distances_[place] = kChosen;
    refresh(place / kBucket);
  }

  void approach(const WeightedPlace& chosen) { approach(1, chosen); }

 private:
  struct Box {
    Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector3f high = Eigen::Vector3f::Constant(std::numeric_limits<float>::lowest());
    float slowness = std::numeric_limits<float>::max();

    void include(const WeightedPlace& place) {
      low = low.cwiseMin(place.position);
      high = high.cwiseMax(place.position);
      slowness = std::min(slowness, place.slowness);
    }
    void include(const Box& other) {
      low = low.cwiseMin(other.low);
      high = high.cwiseMax(other.high);
      slowness = std::min(slowness, other.slowness);
    }
    float distanceTo(const WeightedPlace& place) const {
      const Eigen::Vector3f d =
          (low - place.position).cwiseMax(place.position - high).cwiseMax(0.0F);
      return d.norm() * 0.5F * (slowness + place.slowness);
    }
  };

  void update(std::size_t node) { tree_[node] = std::max(tree_[2 * node], tree_[2 * node + 1]); }

  void refresh(std::size_t bucket) {
    const auto begin = distances_.begin() + static_cast<std::ptrdiff_t>(bucket * kBucket);
    std::size_t node = leaves_ + bucket;
    tree_[node] = *std::max_element(begin, begin + kBucket);
    for (node /= 2; node > 0; node /= 2) update(node);
  }

  void approach(std::size_t node, const WeightedPlace& chosen) {
    if (tree_[node] < 0.0F || boxes_[node].distanceTo(chosen) >= tree_[node]) return;
    if (node >= leaves_) {
      measure(node - leaves_, chosen);
      return;
    }
    approach(2 * node, chosen);
    approach(2 * node + 1, chosen);
    update(node);
  }

  void measure(std::size_t bucket, const WeightedPlace& chosen) {
    const std::size_t first = bucket * kBucket;
    float greatest = kChosen;
    for (std::size_t i = first; i < first + kBucket; ++i) {
      const float dx = axes_[0][i] - chosen.position.x();
      const float dy = axes_[1][i] - chosen.position.y();
      const float dz = axes_[2][i] - chosen.position.z();
      const float distance =
          std::sqrt(dx * dx + dy * dy + dz * dz) * 0.5F * (slowness_[i] + chosen.slowness);
      distances_[i] = std::min(distances_[i], distance);
      greatest = std::max(greatest, distances_[i]);
    }
    tree_[leaves_ + bucket] = greatest;
  }

  std::size_t size_;
  std::array<std::vector<float>, 3> axes_;
  std::vector<float> slowness_;
  std::vector<float> distances_;  // kChosen for chosen places
  std::size_t leaves_ = 1;
  std::vector<float> tree_;  // greatest distances, the root at 1, buckets from leaves_ on
  std::vector<Box> boxes_;   // of the nodes of the tree
};

}  // namespace

PlaceOrder orderFarthestFirst(const std::vector<WeightedPlace>& places,
                              const std::vector<WeightedPlace>& witnesses,
                              const std::vector<WeightedPlace>& before) {
  PlaceOrder result;
  Buckets open(places);
  Buckets watched(witnesses);
  const auto cover = [&](const WeightedPlace& place) {
    open.approach(place);
    watched.approach(place);
    return std::max({open.greatest(), watched.greatest(), 0.0F});
  };
  for (const WeightedPlace& place : before) result.covering_before.push_back(cover(place));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::size_t next = i == 0 && before.empty() ? places.size() / 2 : open.farthest();
    open.choose(next);
    result.order.push_back(static_cast<uint32_t>(next));
    result.covering.push_back(cover(places[next]));
  }
  return result;
}

}  // namespace ladar_perception
