// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/voronoi_vertex.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace ladar_perception {
namespace {

// Vertices up to this far from the middle of a cell are its own, in edges along the surface.
constexpr float kOwnReach = 0.75F;

/// The samples whose fronts hold the cell and its neighbours; the three nearest are the first.
class NearOwners {
 public:
  NearOwners(const FrontField& field, uint32_t cell)
      : field_(field), p_(field.nodes[cell].position()) {
    add(field.arrivals[cell].owner);
    const Crust& crust = *field.crust;
    for (uint32_t k = crust.first_neighbor[cell]; k < crust.first_neighbor[cell + 1]; ++k) {
      add(field.arrivals[crust.neighbors[k]].owner);
    }
    if (count_ < 3) return;
    for (std::size_t i = 0; i < 3; ++i) {
      std::size_t nearest = i;
      for (std::size_t k = i + 1; k < count_; ++k) {
        if (distances2_[k] < distances2_[nearest]) nearest = k;
      }
      std::swap(owners_[i], owners_[nearest]);
      std::swap(distances2_[i], distances2_[nearest]);
    }
  }

  std::size_t size() const { return count_; }
  const FrontField::Node& sample(std::size_t i) const { return field_.samples[owners_[i]]; }

 private:
  void add(uint32_t owner) {
    if (owner == kNoIndex || count_ == owners_.size()) return;
    for (std::size_t i = 0; i < count_; ++i) {
      if (owners_[i] == owner) return;
    }
    owners_[count_] = owner;
    distances2_[count_++] = (field_.samples[owner].position() - p_).squaredNorm();
  }

  const FrontField& field_;
  Eigen::Vector3f p_;
  std::array<uint32_t, 12> owners_;
  std::array<float, 12> distances2_;  // straight, from the cell's place
  std::size_t count_ = 0;
};

/// Circumcentre of three places, in a plane through the origin with that normal; false if they are
/// in a line there, or two of them in one place.
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
  // Equal, too: of two places one above the other both sides are zero.
  if (area * area <= 1e-3F * b2 * c2) return false;
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
  if (!circumcenter({owners.sample(0).position() - vertex.position,
                     owners.sample(1).position() - vertex.position,
                     owners.sample(2).position() - vertex.position},
                    normal, &offset)) {
    return vertex;
  }
  const float reach = kOwnReach * field.crust->edge(cell) / normal.cwiseAbs().maxCoeff();
  const float length = offset.norm();
  if (length > reach) offset *= reach / length;
  const Eigen::Vector3f there = vertex.position + offset;
  float time = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < owners.size(); ++i) {
    const FrontField::Node& sample = owners.sample(i);
    time = std::min(time, std::sqrt((sample.position() - there).squaredNorm()) * 0.5F *
                              (node.slowness + sample.slowness));
  }
  if (time > vertex.time) vertex = {there, time};
  return vertex;
}

}  // namespace ladar_perception
