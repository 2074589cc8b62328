// SPDX-License-Identifier: BSD-3-Clause
#include "surface_index.h"

#include <cmath>
#include <nanoflann.hpp>

namespace ladar_perception {
namespace {

constexpr std::size_t kLeafSize = 10;

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, TreePoints>,
                                                 TreePoints, 3, uint32_t>;

/// The one nearest point within a radius, as nanoflann wants its results taken.
struct NearestWithin {
  float best_squared;
  uint32_t index = 0;
  bool found = false;

  bool full() const { return true; }
  float worstDist() const { return best_squared; }
  bool addPoint(float squared, uint32_t at) {
    if (squared < best_squared) {
      best_squared = squared;
      index = at;
      found = true;
    }
    return true;  // go on
  }
};

}  // namespace

struct SurfaceIndex::Bin {
  TreePoints data;
  std::vector<uint32_t> originals;
  std::unique_ptr<Tree> tree;
};

int SurfaceIndex::binOf(const Eigen::Vector3f& normal) {
  const Eigen::Vector3f size = normal.cwiseAbs();
  int axis = 0;
  const float greatest = size.maxCoeff(&axis);
  constexpr float kInvSqrt3 = 0.57735027F;
  if (greatest >= size.sum() * kInvSqrt3) return 2 * axis + (normal[axis] < 0.0F ? 1 : 0);
  return 6 + (normal.x() < 0.0F ? 1 : 0) + (normal.y() < 0.0F ? 2 : 0) +
         (normal.z() < 0.0F ? 4 : 0);
}

SurfaceIndex::SurfaceIndex(const std::vector<Eigen::Vector3f>& positions,
                           const std::vector<Eigen::Vector3f>& normals, bool by_normal)
    : by_normal_(by_normal) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    std::unique_ptr<Bin>& bin = bins_[by_normal ? binOf(normals[i]) : 0];
    if (!bin) bin = std::make_unique<Bin>();
    bin->data.points.push_back(positions[i]);
    bin->originals.push_back(static_cast<uint32_t>(i));
  }
  for (std::unique_ptr<Bin>& bin : bins_) {
    if (!bin) continue;
    bin->tree =
        std::make_unique<Tree>(3, bin->data, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  }
}

SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

int SurfaceIndex::nearest(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                          float radius_squared) const {
  const std::unique_ptr<Bin>& bin = bins_[by_normal_ ? binOf(normal) : 0];
  if (!bin) return kNone;
  NearestWithin result{radius_squared};
  bin->tree->findNeighbors(result, position.data(), nanoflann::SearchParams());
  return result.found ? static_cast<int>(bin->originals[result.index]) : kNone;
}

void SurfaceIndex::nearest(const Eigen::Vector3f& position, std::size_t count,
                           std::vector<uint32_t>* found,
                           std::vector<float>* squared_distances) const {
  found->resize(count);
  squared_distances->resize(count);
  if (!bins_[0]) {
    found->clear();
    squared_distances->clear();
    return;
  }
  nanoflann::KNNResultSet<float, uint32_t> result(count);
  result.init(found->data(), squared_distances->data());
  bins_[0]->tree->findNeighbors(result, position.data(), nanoflann::SearchParams());
  found->resize(result.size());
  squared_distances->resize(result.size());
}

}  // namespace ladar_perception
