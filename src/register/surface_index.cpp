// SPDX-License-Identifier: BSD-3-Clause
#include "surface_index.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

namespace ladar_perception {
namespace {

constexpr std::size_t kLeafSize = 10;

/// A normal is at most 36 degrees from the direction of its bin, members at most 53.
constexpr float kMemberCosine = 0.6F;

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

Eigen::Vector3f directionOf(int bin) {
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();
  if (bin < 6) {
    direction[bin / 2] = bin % 2 == 0 ? 1.0F : -1.0F;
    return direction;
  }
  for (int axis = 0; axis < 3; ++axis) {
    direction[axis] = ((bin - 6) >> axis) % 2 == 0 ? 1.0F : -1.0F;
  }
  return direction.normalized();
}

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

void SurfaceIndex::insert(int bin, const Eigen::Vector3f& position, std::size_t original) {
  std::unique_ptr<Bin>& members = bins_[static_cast<std::size_t>(bin)];
  if (!members) members = std::make_unique<Bin>();
  members->data.points.push_back(position);
  members->originals.push_back(static_cast<uint32_t>(original));
  members_[original] =
      static_cast<uint16_t>(members_[original] | (1U << static_cast<unsigned>(bin)));
}

SurfaceIndex::SurfaceIndex(const std::vector<Eigen::Vector3f>& positions,
                           const std::vector<Eigen::Vector3f>& normals, bool by_normal)
    : by_normal_(by_normal), positions_(positions), members_(positions.size(), 0) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!by_normal) insert(0, positions[i], i);
    for (int bin = 0; by_normal && bin < kBins; ++bin) {
      if (normals[i].dot(directionOf(bin)) > kMemberCosine) insert(bin, positions[i], i);
    }
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
                          float radius_squared, int hint) const {
  const int at = by_normal_ ? binOf(normal) : 0;
  const std::unique_ptr<Bin>& bin = bins_[static_cast<std::size_t>(at)];
  if (!bin) return kNone;
  NearestWithin result{radius_squared};
  const bool knows =
      hint != kNone &&
      ((members_[static_cast<std::size_t>(hint)] >> static_cast<unsigned>(at)) & 1U) != 0;
  if (knows) {
    // A bit farther, so that the search finds the hint itself if nothing is nearer.
    const float squared = (positions_[static_cast<std::size_t>(hint)] - position).squaredNorm();
    result.best_squared = std::min(radius_squared, squared * 1.0001F + 1e-9F);
  }
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
