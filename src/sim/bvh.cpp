// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/bvh.h"

#include <numeric>

namespace ladar_perception::sim {
namespace {

constexpr int kBins = 12;

struct Bin {
  Bounds bounds;
  uint32_t count = 0;
};

float halfArea(const Bounds& bounds) {
  const Eigen::Vector3f size = (bounds.high - bounds.low).cwiseMax(0.0F);
  return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

float centreOf(const Bounds& bounds, int axis) {
  return 0.5F * (bounds.low[axis] + bounds.high[axis]);
}

/// Cost of cutting before each bin: area times count, left and right.
std::array<float, kBins> cutCosts(const std::array<Bin, kBins>& bins) {
  std::array<float, kBins> costs{};
  Bin left;
  for (int cut = 1; cut < kBins; ++cut) {
    left.bounds.add(bins[cut - 1].bounds);
    left.count += bins[cut - 1].count;
    costs[cut] = left.count > 0 ? halfArea(left.bounds) * static_cast<float>(left.count) : 0.0F;
  }
  Bin right;
  for (int cut = kBins - 1; cut > 0; --cut) {
    right.bounds.add(bins[cut].bounds);
    right.count += bins[cut].count;
    if (right.count > 0) costs[cut] += halfArea(right.bounds) * static_cast<float>(right.count);
  }
  return costs;
}

}  // namespace

Bvh::Bvh(const std::vector<Bounds>& items) : order_(items.size()) {
  if (items.empty()) return;
  std::iota(order_.begin(), order_.end(), 0U);
  nodes_.reserve(items.size());
  nodes_.emplace_back();
  build(0, 0, static_cast<uint32_t>(items.size()), 0, items);
}

Bounds Bvh::bounds() const {
  Bounds bounds;
  if (nodes_.empty()) return bounds;
  const Node& root = nodes_.front();
  bounds.low = {root.low[0], root.low[1], root.low[2]};
  bounds.high = {root.high[0], root.high[1], root.high[2]};
  return bounds;
}

void Bvh::build(uint32_t node, uint32_t begin, uint32_t end, uint32_t depth,
                const std::vector<Bounds>& items) {
  Bounds bounds;
  for (uint32_t i = begin; i < end; ++i) bounds.add(items[order_[i]]);
  const Eigen::Vector3f& low = bounds.low;
  const Eigen::Vector3f& high = bounds.high;
  nodes_[node].low = {low.x() - kMargin, low.y() - kMargin, low.z() - kMargin, 0.0F};
  nodes_[node].high = {high.x() + kMargin, high.y() + kMargin, high.z() + kMargin,
                       std::numeric_limits<float>::infinity()};
  uint32_t middle = begin;
  if (end - begin > kLeafSize && depth < kMaxDepth) {
    middle = partition(begin, end, bestSplit(begin, end, items), items);
  }
  if (middle == begin || middle == end) {
    nodes_[node].first = begin;
    nodes_[node].count = end - begin;
    return;
  }
  const auto children = static_cast<uint32_t>(nodes_.size());
  nodes_[node].first = children;
  nodes_.resize(nodes_.size() + 2);
  build(children, begin, middle, depth + 1, items);
  build(children + 1, middle, end, depth + 1, items);
}

Bvh::Split Bvh::bestSplit(uint32_t begin, uint32_t end, const std::vector<Bounds>& items) const {
  Bounds centres;
  for (uint32_t i = begin; i < end; ++i) {
    centres.add(0.5F * (items[order_[i]].low + items[order_[i]].high));
  }
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = centres.low[axis];
    const float width = (centres.high[axis] - low) / kBins;
    if (!(width > 0.0F)) continue;
    std::array<Bin, kBins> bins;
    for (uint32_t i = begin; i < end; ++i) {
      const Bounds& item = items[order_[i]];
      const auto bin = static_cast<int>((centreOf(item, axis) - low) / width);
      bins[std::clamp(bin, 0, kBins - 1)].bounds.add(item);
      ++bins[std::clamp(bin, 0, kBins - 1)].count;
    }
    const std::array<float, kBins> costs = cutCosts(bins);
    for (int cut = 1; cut < kBins; ++cut) {
      if (costs[cut] < best.cost) best = {axis, low + width * static_cast<float>(cut), costs[cut]};
    }
  }
  return best;
}

uint32_t Bvh::partition(uint32_t begin, uint32_t end, const Split& split,
                        const std::vector<Bounds>& items) {
  if (split.axis < 0) return begin;  // all centres coincide
  const auto first = order_.begin() + begin;
  const auto last = order_.begin() + end;
  const auto middle = std::partition(first, last, [&](uint32_t item) {
    return centreOf(items[item], split.axis) < split.position;
  });
  if (middle != first && middle != last) return static_cast<uint32_t>(middle - order_.begin());
  const auto median = first + (end - begin) / 2;
  std::nth_element(first, median, last, [&](uint32_t a, uint32_t b) {
    return centreOf(items[a], split.axis) < centreOf(items[b], split.axis);
  });
  return begin + (end - begin) / 2;
}

}  // namespace ladar_perception::sim
