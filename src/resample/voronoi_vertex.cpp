// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/voronoi_vertex.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ladar_perception {
namespace {

// Vertices up to this far from the middle of a cell are its own, in edges along the surface.
constexpr float kOwnReach = 0.75F;

struct Owner {
  uint32_t cell;
  float distance2;  // straight, from the cell's place
};

/// The samples whose fronts hold the cell and its neighbours, nearest first.
class NearOwners {
 public:
  NearOwners(const FrontField& field, uint32_t cell) : field_(field), p_(field.nodes[cell].position()) {
    add(field.arrivals[cell].owner);
    const Crust& crust = *field.crust;
    for (uint32_t k = crust.first_neighbor[cell]; k < crust.first_neighbor[cell + 1]; ++k) {
      add(field.arrivals[crust.neighbors[k]].owner);
    }
    std::sort(owners_.begin(), owners_.begin() + count_,
              [](const Owner& a, const Owner& b) { return a.distance2 < b.distance2; });
  }

  int size() const { return count_; }
  const Eigen::Vector3f& sample(int i) const {
    return field_.samples[owners_[static_cast<std::size_t>(i)].cell];
  }
  uint32_t cell(int i) const { return owners_[static_cast<std::size_t>(i)].cell; }

 private:
  void add(uint32_t owner) {
    if (owner == kNoIndex || count_ == static_cast<int>(owners_.size())) return;
    for (int i = 0; i < count_; ++i) {
      if (owners_[static_cast<std::size_t>(i)].cell == owner) return;
    }
    owners_[static_cast<std::size_t>(count_++)] = {owner,
                                                   (field_.samples[owner] - p_).squaredNorm()};
  }

  const FrontField& field_;
  Eigen::Vector3f p_;
  std::array<Owner, 12> owners_{};
  int count_ = 0;
};

/// Circumcentre of three places, in a plane through the origin with that normal; false if they are
/// in a line.
bool circumcenter(const std::array<Eigen::Vector3f, 3>& p, const Eigen::Vector3f& normal,
                  Eigen::Vector3f* center) {
  const auto onPlane = [&](const Eigen::Vector3f& q) -> Eigen::Vector3f {
    return q - q.dot(normal) * normal;
  };
  const Eigen::Vector3f a = onPlane(p[0]);
  const Eigen::Vector3f b = onPlane(p[1]) - a;
  const Eigen::Vector3f c = onPlane(p[2]) - a;
  const float area = b.cross(c).dot(normal);
  const float b2 = b.squaredNorm();
  const float c2 = c.squaredNorm();
  if (area * area < 1e-3F * b2 * c2) return false;
  *center = a + (b2 * c - c2 * b).cross(b.cross(c)) / (2.0F * area * area);
  return true;
}

}  // namespace

bool isLatest(const FrontField& field, uint32_t cell) {
  const Crust& crust = *field.crust;
  const float time = field.arrivals[cell].time;
  for (uint32_t k = crust.first_neighbor[cell]; k < crust.first_neighbor[cell + 1]; ++k) {
    const uint32_t other = crust.neighbors[k];
    const float other_time = field.arrivals[other].time;
    if (other_time > time || (other_time == time && other < cell)) return false;
  }
  return true;
}

VoronoiVertex findVertex(const FrontField& field, uint32_t cell) {
  const FrontField::Node& node = field.nodes[cell];
  VoronoiVertex vertex = {node.position(), field.arrivals[cell].time};
  const NearOwners owners(field, cell);
  if (owners.size() < 3) return vertex;
  const Eigen::Vector3f& normal = field.crust->normals[cell];
  Eigen::Vector3f offset;
  if (!circumcenter({owners.sample(0) - vertex.position, owners.sample(1) - vertex.position,
                     owners.sample(2) - vertex.position},
                    normal, &offset)) {
    return vertex;
  }
  const float reach = kOwnReach * field.crust->edge(cell) / normal.cwiseAbs().maxCoeff();
  const float length = offset.norm();
  if (length > reach) offset *= reach / length;
  const Eigen::Vector3f there = vertex.position + offset;
  float time = std::numeric_limits<float>::infinity();
  for (int i = 0; i < owners.size(); ++i) {
    time = std::min(time, (owners.sample(i) - there).norm() * 0.5F *
                              (node.slowness + field.nodes[owners.cell(i)].slowness));
  }
  if (time > vertex.time) vertex = {there, time};
  return vertex;
}

}  // namespace ladar_perception
