// SPDX-License-Identifier: BSD-3-Clause
// Tree of boxes that finds the few things a ray may meet.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "ladar_perception/sim/primitive.h"

namespace ladar_perception::sim {

/// Binary bounding volume hierarchy over numbered boxes (surface area heuristic, binned).
class Bvh {
 public:
  Bvh() = default;
  explicit Bvh(const std::vector<Bounds>& items);

  bool empty() const { return nodes_.empty(); }
  /// Box of everything; empty if there is nothing.
  Bounds bounds() const;

  /// Calls `visit(item)` for at least every item whose box the ray meets at t <= `t_limit`, nearer
  /// boxes first. `visit` may lower `t_limit`, which it holds by reference.
  template <typename Visit>
  void traverse(const Ray& ray, const double& t_limit, Visit&& visit) const;
  /// Calls `visit(item)` for at least every item whose box is no farther from `p` than `limit_m`,
  /// which `visit` may lower, too.
  template <typename Visit>
  void visitNear(const Eigen::Vector3d& p, const double& limit_m, Visit&& visit) const;

 private:
  // Boxes and slabs have a fourth lane that always holds the interval [0, infinity): four lanes
  // fill a vector register, and the lane clips the interval to the ray's front for free.
  struct Node {
    Eigen::Array4f low;  // grown by kMargin, so that single precision never loses a hit
    Eigen::Array4f high;
    uint32_t first = 0;  // leaf: first entry of order_; else: left child, the right one follows
    uint32_t count = 0;  // entries of a leaf, 0 for an inner node
  };
  struct Slab {
    Eigen::Array4f origin;
    Eigen::Array4f inverse_direction;
  };
  struct Pending {
    uint32_t node;
    float t_in;
  };
  struct Split {
    int axis = -1;
    float position = 0.0F;
    float cost = std::numeric_limits<float>::infinity();
  };

  static constexpr float kMargin = 1e-3F;
  static constexpr uint32_t kLeafSize = 4;
  static constexpr std::size_t kStackSize = 96;
  static constexpr uint32_t kMaxDepth = 90;

  void build(uint32_t node, uint32_t begin, uint32_t end, uint32_t depth,
             const std::vector<Bounds>& items);
  Split bestSplit(uint32_t begin, uint32_t end, const std::vector<Bounds>& items) const;
  uint32_t partition(uint32_t begin, uint32_t end, const Split& split,
                     const std::vector<Bounds>& items);

  /// Where the ray enters the box, or infinity if it passes or enters beyond `t_limit`.
  static float entry(const Node& node, const Slab& slab, float t_limit) {
    const Eigen::Array4f t1 = (node.low - slab.origin) * slab.inverse_direction;
    const Eigen::Array4f t2 = (node.high - slab.origin) * slab.inverse_direction;
    const float t_in = t1.min(t2).maxCoeff();
    const float t_out = std::min(t1.max(t2).minCoeff(), t_limit);
    return t_in <= t_out ? t_in : std::numeric_limits<float>::infinity();
  }

  /// Distance from the node's box, 0 inside.
  static double distanceTo(const Node& node, const Eigen::Vector3d& p) {
    const Eigen::Vector3d low = node.low.head<3>().matrix().cast<double>();
    const Eigen::Vector3d high = node.high.head<3>().matrix().cast<double>();
    return (low - p).cwiseMax(p - high).cwiseMax(0.0).norm();
  }

  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
};

template <typename Visit>
void Bvh::visitNear(const Eigen::Vector3d& p, const double& limit_m, Visit&& visit) const {
  if (nodes_.empty()) return;
  std::vector<std::pair<double, uint32_t>> stack = {{distanceTo(nodes_[0], p), 0}};
  while (!stack.empty()) {
    const auto [distance_m, index] = stack.back();
    stack.pop_back();
    if (distance_m > limit_m) continue;
    const Node& node = nodes_[index];
    for (uint32_t i = 0; i < node.count; ++i) visit(order_[node.first + i]);
    if (node.count > 0) continue;
    const double left = distanceTo(nodes_[node.first], p);
    const double right = distanceTo(nodes_[node.first + 1], p);
    const uint32_t far = left <= right ? 1 : 0;
    stack.emplace_back(std::max(left, right), node.first + far);
    stack.emplace_back(std::min(left, right), node.first + 1 - far);
  }
}

template <typename Visit>
void Bvh::traverse(const Ray& ray, const double& t_limit, Visit&& visit) const {
  if (nodes_.empty()) return;
  constexpr float kPassed = std::numeric_limits<float>::infinity();
  Slab slab;
  slab.origin = {static_cast<float>(ray.origin.x()), static_cast<float>(ray.origin.y()),
                 static_cast<float>(ray.origin.z()), 0.0F};
  slab.inverse_direction[3] = 1.0F;
  for (int i = 0; i < 3; ++i) {
    // A zero would give 0 * infinity = NaN on a box's face; 1e-20 moves nothing.
    const auto rate = static_cast<float>(ray.direction[i]);
    slab.inverse_direction[i] = 1.0F / (std::abs(rate) > 1e-20F ? rate : 1e-20F);
  }
  // Rounded up, and by more than the rounding of the slab arithmetic.
  const auto limit = [&t_limit] { return static_cast<float>(t_limit) * 1.0001F + kMargin; };
  std::array<Pending, kStackSize> stack;  // not initialised: most rays use little of it
  std::size_t depth = 0;
  const float root_entry = entry(nodes_[0], slab, limit());
  if (root_entry != kPassed) stack[depth++] = {0, root_entry};
  while (depth > 0) {
    const auto [index, node_entry] = stack[--depth];
    if (node_entry > limit()) continue;
    const Node& node = nodes_[index];
    if (node.count > 0) {
      for (uint32_t i = 0; i < node.count; ++i) visit(order_[node.first + i]);
      continue;
    }
    const float left = entry(nodes_[node.first], slab, limit());
    const float right = entry(nodes_[node.first + 1], slab, limit());
    const bool left_first = left <= right;
    const float far = left_first ? right : left;
    const float near = left_first ? left : right;
    if (far != kPassed) stack[depth++] = {node.first + (left_first ? 1 : 0), far};
    if (near != kPassed) stack[depth++] = {node.first + (left_first ? 0 : 1), near};
  }
}

}  // namespace ladar_perception::sim
