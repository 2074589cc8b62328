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

  /// The nearest point in the tree of `normal`, or kNone if none is within the radius. All points
  /// are there whose normals differ by up to 17 degrees, none by more than 90. `hint`: a point that
  /// may be near, or kNone; the result does not depend on it, but the time does.
  int nearest(const Eigen::Vector3f& position, const Eigen::Vector3f& normal, float radius_squared,
              int hint) const;
  /// The `count` nearest points of all, nearest first, for an index of one tree.
  void nearest(const Eigen::Vector3f& position, std::size_t count, std::vector<uint32_t>* found,
               std::vector<float>* squared_distances) const;

 private:
  struct Bin;
  static constexpr int kBins = 14;
  static int binOf(const Eigen::Vector3f& normal);
  void insert(int bin, const Eigen::Vector3f& position, std::size_t original);

  bool by_normal_;
  std::vector<Eigen::Vector3f> positions_;
  std::vector<uint16_t> members_;  ///< bit b: the point is in bin b
  std::array<std::unique_ptr<Bin>, kBins> bins_;
};

}  // namespace ladar_perception
