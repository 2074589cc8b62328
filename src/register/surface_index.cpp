// SPDX-License-Identifier: BSD-3-Clause
#include "surface_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>

namespace ladar_perception {
namespace {

constexpr std::size_t kLeafSize = 10;

/// A normal is at most 36 degrees from the direction of its bin, members at most 53.
constexpr float kMemberCosine = 0.6F;
/// Searched of the radius, so that a point that has moved is known to have none within it.
constexpr float kWider = 1.3F;
/// Of what is left of a distance: more than float arithmetic can be wrong.
constexpr float kRounding = 0.9999F;

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, TreePoints>,
                                                 TreePoints, 3, uint32_t>;

/// The two nearest points within a radius, as nanoflann wants its results taken.
struct TwoNearestWithin {
  explicit TwoNearestWithin(float radius_squared)
      : first_squared(radius_squared), second_squared(radius_squared) {}

  static constexpr uint32_t kNothing = 0xffffffffU;
  float first_squared;
  float second_squared;
  uint32_t first = kNothing;
  uint32_t second = kNothing;

  bool full() const { return true; }
  float worstDist() const { return second_squared; }
  bool addPoint(float squared, uint32_t at) {
    if (squared < first_squared) {
      second_squared = first_squared;
      second = first;
      first_squared = squared;
      first = at;
    } else if (squared < second_squared) {
      second_squared = squared;
      second = at;
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

bool SurfaceIndex::isMember(int point, int bin) const {
  return point != kNone &&
         ((members_[static_cast<std::size_t>(point)] >> static_cast<unsigned>(bin)) & 1U) != 0;
}

float SurfaceIndex::squaredDistance(int point, const Eigen::Vector3f& position) const {
  return (positions_[static_cast<std::size_t>(point)] - position).squaredNorm();
}

bool SurfaceIndex::recall(const Eigen::Vector3f& position, int bin, float radius_squared,
                          const Memory& memory, int* found) const {
  if (memory.bin != bin) return false;
  const float others_m = kRounding * (memory.others_m - (position - memory.position).norm());
  if (!(others_m > 0.0F)) return false;
  const float squared = memory.nearest == kNone ? std::numeric_limits<float>::infinity()
                                                : squaredDistance(memory.nearest, position);
  if (std::min(squared, radius_squared) >= others_m * others_m) return false;
  *found = squared < radius_squared ? memory.nearest : kNone;
  return true;
}

float SurfaceIndex::bound(const Eigen::Vector3f& position, int bin, float radius_squared,
                          const Memory& memory) const {
  if (!isMember(memory.nearest, bin) || !isMember(memory.second, bin)) return radius_squared;
  const float squared =
      std::max(squaredDistance(memory.nearest, position), squaredDistance(memory.second, position));
  // A bit farther, so that the search finds these two if nothing is nearer.
  return std::min(radius_squared, squared * 1.0001F + 1e-9F);
}

int SurfaceIndex::nearest(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                          float radius_squared, Memory* memory) const {
  const int at = by_normal_ ? binOf(normal) : 0;
  const std::unique_ptr<Bin>& bin = bins_[static_cast<std::size_t>(at)];
  if (!bin) return kNone;
  int known = kNone;
  if (recall(position, at, radius_squared, *memory, &known)) return known;
  TwoNearestWithin result(bound(position, at, kWider * kWider * radius_squared, *memory));
  bin->tree->findNeighbors(result, position.data(), nanoflann::SearchParams());
  const auto original = [&](uint32_t i) {
    return i == TwoNearestWithin::kNothing ? kNone : static_cast<int>(bin->originals[i]);
  };
  *memory = {position, std::sqrt(result.second_squared), original(result.first),
             original(result.second), at};
  return result.first_squared < radius_squared ? memory->nearest : kNone;
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
