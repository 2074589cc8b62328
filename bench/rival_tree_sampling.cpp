// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>

#include "sampling_methods.h"

namespace ladar_perception::bench {
namespace {

/// Squared distances of points to the samples so far, in a k-d tree. A sample leaves alone all
/// nodes that have no point farther from the samples so far than their box is from it.
class DistanceTree {
 public:
  explicit DistanceTree(const Points& points) : order_(points.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    if (points.empty()) return;
    nodes_.reserve(4 * points.size() / kLeafPoints + 1);
    build(points, 0, points.size());
    for (const std::size_t i : order_) points_.push_back(points[i]);
    distances_.assign(points.size(), std::numeric_limits<double>::infinity());
  }

  void add(const Eigen::Vector3d& sample) { update(0, sample); }
  const Eigen::Vector3d& farthest() const { return points_[nodes_.front().farthest]; }

 private:
  static constexpr std::size_t kLeafPoints = 16;

  struct Node {
    Eigen::AlignedBox3d box;
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t right = 0;  // 0: a leaf; the left child is the next node
    std::size_t farthest = 0;
    double greatest = std::numeric_limits<double>::infinity();
  };

  std::size_t build(const Points& points, std::size_t begin, std::size_t end) {
    const std::size_t index = nodes_.size();
    nodes_.emplace_back();
    Node node;
    node.begin = node.farthest = begin;
    node.end = end;
    for (std::size_t i = begin; i < end; ++i) node.box.extend(points[order_[i]]);
    if (end - begin > kLeafPoints) {
      Eigen::Index axis = 0;
      node.box.sizes().maxCoeff(&axis);
      const std::size_t middle = (begin + end) / 2;
      const auto first = order_.begin();
      std::nth_element(
          first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
          first + static_cast<std::ptrdiff_t>(end),
          [&](std::size_t a, std::size_t b) { return points[a][axis] < points[b][axis]; });
      build(points, begin, middle);
      node.right = build(points, middle, end);
    }
    nodes_[index] = node;
    return index;
  }

  void update(std::size_t index, const Eigen::Vector3d& sample) {
    Node& node = nodes_[index];
    if (node.box.squaredExteriorDistance(sample) >= node.greatest) return;
    if (node.right == 0) return updateLeaf(&node, sample);
    update(index + 1, sample);
    update(node.right, sample);
    const Node& left = nodes_[index + 1];
    const Node& right = nodes_[node.right];
    const Node& farther = left.greatest >= right.greatest ? left : right;
    node.greatest = farther.greatest;
    node.farthest = farther.farthest;
  }

  void updateLeaf(Node* leaf, const Eigen::Vector3d& sample) {
    leaf->greatest = -1.0;
    for (std::size_t i = leaf->begin; i < leaf->end; ++i) {
      distances_[i] = std::min(distances_[i], (points_[i] - sample).squaredNorm());
      if (distances_[i] <= leaf->greatest) continue;
      leaf->greatest = distances_[i];
      leaf->farthest = i;
    }
  }

  std::vector<std::size_t> order_;
  Points points_;  // in the order of the leaves
  std::vector<double> distances_;
  std::vector<Node> nodes_;
};

}  // namespace

SamplingMethod treeFarthestPoints(const Points& points, std::size_t count) {
  auto samples = std::make_shared<Points>();
  const auto run = [=, &points] {
    samples->clear();
    if (points.empty()) return;
    DistanceTree tree(points);
    samples->push_back(points.front());
    while (samples->size() < std::min(count, points.size())) {
      tree.add(samples->back());
      samples->push_back(tree.farthest());
    }
  };
  return {run, [=] { return *samples; }};
}

}  // namespace ladar_perception::bench
