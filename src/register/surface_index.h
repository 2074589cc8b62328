// SPDX-License-Identifier: BSD-3-Clause
// Nearest surface points that look the same way.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace ladar_perception {

/// Points of a tree, beside each other in memory; the interface is nanoflann's.
struct TreePoints {
  std::vector<Eigen::Vector3f> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;  // nanoflann computes it
  }
};

/// A k-d tree for each of 14 directions of normals, those of the faces and the corners of a cube,
/// or one tree for all points. Immutable.
class SurfaceIndex {
 public:
  static constexpr int kNone = -1;

  /// Normals must be unit vectors, positions finite and not much farther than 1 km from the origin.
  SurfaceIndex(const std::vector<Eigen::Vector3f>& positions,
               const std::vector<Eigen::Vector3f>& normals, bool by_normal);
  ~SurfaceIndex();
  SurfaceIndex(SurfaceIndex&&) noexcept;
  SurfaceIndex& operator=(SurfaceIndex&&) noexcept;

  /// What a search found, for the next one of the same point, which has moved a little since.
  struct Memory {
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    float others_m = 0.0F;  ///< all points but `nearest` were at least this far from `position`
    int nearest = kNone;
    int second = kNone;
    int bin = kNone;  ///< the tree that was searched; kNone: nothing is known
  };

  /// The nearest point in the tree of `normal`, or kNone if none is within the radius. All points
  /// are there whose normals differ by up to 17 degrees, none by more than 90. The result does not
  /// depend on `memory`, but the time does: where the point has moved less than the nearest one
  /// leads the second, nothing is searched.
  int nearest(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float radius_squared,
              Memory* memory) const;
  /// The `count` nearest points of all, nearest first, for an index of one tree.
  void nearest(const Eigen::Vector3f& position, std::size_t count, std::vector<uint32_t>* found,
               std::vector<float>* squared_distances) const;

 private:
  struct Bin;
  static constexpr int kBins = 14;
  static int binOf(const Eigen::Vector3f& normal);
  void insert(int bin, const Eigen::Vector3f& position, std::size_t original);
  bool isMember(int point, int bin) const;
  float squaredDistance(int point, const Eigen::Vector3f& position) const;
  /// Whether `memory` tells the nearest point within the radius; that point or kNone in `found`.
  bool recall(const Eigen::Vector3f& position, int bin, float radius_squared, const Memory& memory,
              int* found) const;
  /// A radius within which there are two points, or the given one.
  float bound(const Eigen::Vector3f& position, int bin, float radius_squared,
              const Memory& memory) const;

  bool by_normal_;
  std::vector<Eigen::Vector3f> positions_;
  std::vector<uint16_t> members_;  ///< bit b: the point is in bin b
  std::array<std::unique_ptr<Bin>, kBins> bins_;
};

}  // namespace ladar_perception
