// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/register/surface_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "ladar_perception/saliency/eigen_symmetric3.h"
#include "surface_index.h"

namespace ladar_perception {
namespace {

constexpr std::size_t kNeighbors = 12;
/// Middle over greatest eigenvalue below which neighbours lie on a line and have no normal.
constexpr double kLine = 1e-3;
/// Of the greatest range: the shell of what is no return, and what it must stand out from.
constexpr double kShell = 0.99;
constexpr double kBelowShell = 0.9;

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3d>& positions_m) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : positions_m) sum += p;
  return sum / static_cast<double>(std::max<std::size_t>(positions_m.size(), 1));
}

/// Points with the voxels they are in, sorted by voxel, then by their order in the cloud.
class VoxelOrder {
 public:
  VoxelOrder(const std::vector<Eigen::Vector3d>& positions_m, const Eigen::Vector3d& origin_m)
      : positions_m_(positions_m), origin_m_(origin_m), keyed_(positions_m.size()) {
    double extent = 0.0;
    for (const Eigen::Vector3d& p : positions_m) {
      extent = std::max(extent, (p - origin_m).lpNorm<Eigen::Infinity>());
    }
    min_size_m_ = std::max(extent / static_cast<double>(kHalf - 1), 1e-6);
  }

  /// Keys have 21 bits an axis: voxels cannot be smaller than this.
  double minSize_m() const { return min_size_m_; }

  std::size_t sortInto(double voxel_size_m) {
    const double scale = 1.0 / std::max(voxel_size_m, min_size_m_);
    for (std::size_t i = 0; i < keyed_.size(); ++i) {
      const Eigen::Vector3d cell = (positions_m_[i] - origin_m_) * scale;
      uint64_t key = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const auto step = static_cast<int64_t>(std::floor(cell[axis])) + kHalf;
        key = (key << 21) | static_cast<uint64_t>(step);
      }
      keyed_[i] = {key, static_cast<uint32_t>(i)};
    }
    std::sort(keyed_.begin(), keyed_.end());
    std::size_t voxels = 0;
    for (std::size_t i = 0; i < keyed_.size(); ++i) {
      if (i == 0 || keyed_[i].first != keyed_[i - 1].first) ++voxels;
    }
    return voxels;
  }

  std::vector<Eigen::Vector3d> centroids() const {
    std::vector<Eigen::Vector3d> means;
    for (std::size_t begin = 0; begin < keyed_.size();) {
      std::size_t end = begin;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (; end < keyed_.size() && keyed_[end].first == keyed_[begin].first; ++end) {
        sum += positions_m_[keyed_[end].second] - origin_m_;
      }
      means.push_back(origin_m_ + sum / static_cast<double>(end - begin));
      begin = end;
    }
    return means;
  }

 private:
  static constexpr int64_t kHalf = int64_t{1} << 20;
  const std::vector<Eigen::Vector3d>& positions_m_;
  Eigen::Vector3d origin_m_;
  std::vector<std::pair<uint64_t, uint32_t>> keyed_;
  double min_size_m_ = 0.0;
};

/// Centroids of voxels of a size that gives nearly `count` of them.
std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& positions_m,
                                     const Eigen::Vector3d& origin_m, std::size_t count) {
  if (positions_m.size() <= count) return positions_m;
  VoxelOrder order(positions_m, origin_m);
  double size_m = 0.2;
  double least_m = order.minSize_m();
  double most_m = 1e3;
  for (int attempt = 0; attempt < 12; ++attempt) {
    const std::size_t voxels = order.sortInto(size_m);
    const double ratio = static_cast<double>(voxels) / static_cast<double>(count);
    if (ratio > 0.95 && ratio < 1.05) break;
    (ratio > 1.0 ? least_m : most_m) = size_m;
    // Voxels of a surface grow in number as 1 / size^2, those of sparse rings slower.
    const double next_m = size_m * std::pow(ratio, 0.6);
    size_m = next_m > least_m && next_m < most_m ? next_m : std::sqrt(least_m * most_m);
  }
  return order.centroids();
}

std::vector<Eigen::Vector3f> toLocal(const std::vector<Eigen::Vector3d>& positions_m,
                                     const Eigen::Vector3d& origin_m) {
  std::vector<Eigen::Vector3f> local(positions_m.size());
  for (std::size_t i = 0; i < local.size(); ++i) {
    local[i] = (positions_m[i] - origin_m).cast<float>();
  }
  return local;
}

SurfaceIndex treeOf(const std::vector<Eigen::Vector3f>& local) {
  return SurfaceIndex(local, {}, false);
}

/// Normal of the plane through some points, towards `to_sensor`; zero if they lie on a line.
Eigen::Vector3f planeNormal(const std::vector<Eigen::Vector3f>& points,
                            const std::vector<uint32_t>& members,
                            const Eigen::Vector3f& to_sensor) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const uint32_t i : members) mean += points[i].cast<double>();
  mean /= static_cast<double>(members.size());
  SymmetricMatrix3 scatter;
  for (const uint32_t i : members) {
    const Eigen::Vector3d d = points[i].cast<double>() - mean;
    scatter.xx += d.x() * d.x();
    scatter.xy += d.x() * d.y();
    scatter.xz += d.x() * d.z();
    scatter.yy += d.y() * d.y();
    scatter.yz += d.y() * d.z();
    scatter.zz += d.z() * d.z();
  }
  const EigenSymmetric3 eigen = eigenSymmetric3(scatter);
  if (!(eigen.l1 > kLine * eigen.l2)) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f normal = eigen.e0.cast<float>().normalized();
  return normal.dot(to_sensor) < 0.0F ? Eigen::Vector3f(-normal) : normal;
}

}  // namespace

std::vector<uint32_t> plausibleReturns(const std::vector<Eigen::Vector3d>& positions_m,
                                       const Eigen::Vector3d& sensor_m) {
  std::vector<uint32_t> kept;
  std::vector<double> ranges_m(positions_m.size());
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < positions_m.size(); ++i) {
    ranges_m[i] = (positions_m[i] - sensor_m).norm();
    if (!(ranges_m[i] >= kNearestReturn_m) || !std::isfinite(ranges_m[i])) continue;
    kept.push_back(static_cast<uint32_t>(i));
    farthest_m = std::max(farthest_m, ranges_m[i]);
  }
  const auto beyond = [&](double share) {
    return static_cast<double>(std::count_if(
        kept.begin(), kept.end(), [&](uint32_t i) { return ranges_m[i] > share * farthest_m; }));
  };
  const double shell = beyond(kShell);
  const double below = beyond(kBelowShell) - shell;
  const auto all = static_cast<double>(kept.size());
  // Less is a few far returns; more is a cloud of one surface.
  if (shell < 1e-3 * all || shell > 0.3 * all || shell < 10.0 * below) return kept;
  const auto in_shell = [&](uint32_t i) { return ranges_m[i] > kShell * farthest_m; };
  kept.erase(std::remove_if(kept.begin(), kept.end(), in_shell), kept.end());
  return kept;
}

OrientedPoints surfaceCentroids(const std::vector<Eigen::Vector3d>& positions_m,
                                const Eigen::Vector3d& sensor_m, int count) {
  const Eigen::Vector3d origin_m = meanOf(positions_m);
  OrientedPoints surface;
  surface.positions_m =
      thinned(positions_m, origin_m, static_cast<std::size_t>(std::max(count, 1)));
  const std::vector<Eigen::Vector3f> local = toLocal(surface.positions_m, origin_m);
  const SurfaceIndex tree = treeOf(local);
  const Eigen::Vector3f sensor = (sensor_m - origin_m).cast<float>();
  std::vector<uint32_t> members;
  std::vector<float> squared;
  surface.normals.reserve(local.size());
  for (const Eigen::Vector3f& p : local) {
    tree.nearest(p, kNeighbors, &members, &squared);
    surface.normals.push_back(planeNormal(local, members, sensor - p));
  }
  return surface;
}

OrientedPoints withNormalsOf(const OrientedPoints& surface,
                             const std::vector<Eigen::Vector3d>& positions_m) {
  const Eigen::Vector3d origin_m = meanOf(surface.positions_m);
  const SurfaceIndex tree = treeOf(toLocal(surface.positions_m, origin_m));
  OrientedPoints points;
  points.positions_m = positions_m;
  std::vector<uint32_t> found;
  std::vector<float> squared;
  for (const Eigen::Vector3d& p : positions_m) {
    tree.nearest((p - origin_m).cast<float>(), 1, &found, &squared);
    points.normals.push_back(found.empty() ? Eigen::Vector3f(Eigen::Vector3f::Zero())
                                           : surface.normals[found[0]]);
  }
  return points;
}

}  // namespace ladar_perception
