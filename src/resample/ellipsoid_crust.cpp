// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <unordered_map>

#include "crust_links.h"
#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"
#include "ladar_perception/resample/surface_fit.h"

namespace ladar_perception {
namespace {

// Points spread evenly over a disc have a standard deviation of half its radius along either axis.
constexpr float kSemiAxisPerDeviation = 2.0F;
// Thinner ellipsoids could slip through between the centres of cells.
constexpr float kLeastSemiAxis = 0.75F;

/// What nanoflann asks of a cloud.
struct PointAdaptor {
  const std::vector<Eigen::Vector3f>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointAdaptor>,
                                                 PointAdaptor, 3>;

struct Ellipsoid {
  Eigen::Vector3f center;
  Eigen::Vector3f normal;
  Eigen::Vector3f major;
  Eigen::Vector3f semi_axes;  // along normal, middle axis and major axis
  float weight;
};

struct CellSums {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float offset = 0;  // of the planes along their normals from the cell's middle
  float trust = 0;
  float weight = 0;
};

Ellipsoid fitEllipsoid(const GridPoints& points, const std::vector<uint32_t>& near,
                       const Eigen::Vector3f& sensor) {
  PointSums sums;
  const Eigen::Vector3f& about = points.positions[near.front()];
  for (const uint32_t i : near) sums.add(points.positions[i] - about, 1.0F);
  const PlaneFit plane = fitPlane(sums);
  Ellipsoid ellipsoid;
  ellipsoid.center = about + plane.mean;
  ellipsoid.normal = plane.normal;
  if (plane.normal.dot(sensor - ellipsoid.center) < 0.0F) ellipsoid.normal = -plane.normal;
  ellipsoid.major = plane.major;
  const auto semiAxis = [](float eigenvalue) {
    return std::clamp(kSemiAxisPerDeviation * std::sqrt(std::max(eigenvalue, 0.0F)), kLeastSemiAxis,
                      kLargestEllipsoidCells);
  };
  ellipsoid.semi_axes = {semiAxis(plane.l0), semiAxis(plane.l1), semiAxis(plane.l2)};
  return ellipsoid;
}

void addCells(const Ellipsoid& e, std::unordered_map<uint64_t, CellSums>* cells) {
  const Eigen::Vector3f middle = e.normal.cross(e.major);
  const Eigen::Vector3f half =
      ((e.semi_axes[0] * e.normal).array().square() + (e.semi_axes[1] * middle).array().square() +
       (e.semi_axes[2] * e.major).array().square())
          .sqrt();
  Eigen::Vector3i low;
  Eigen::Vector3i high;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = floorToInt(e.center[axis] - half[axis]);
    high[axis] = floorToInt(e.center[axis] + half[axis]);
  }
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Eigen::Vector3f cell = Eigen::Vector3i(x, y, z).cast<float>().array() + 0.5F;
        const Eigen::Vector3f d = cell - e.center;
        const Eigen::Array3f along(d.dot(e.normal), d.dot(middle), d.dot(e.major));
        const float inside = 1.0F - (along / e.semi_axes.array()).square().sum();
        if (inside < 0.0F) continue;
        CellSums& sums = (*cells)[cellKey(cell)];
        sums.normal += inside * e.normal;
        sums.offset -= inside * along[0];
        sums.trust += inside;
        sums.weight += inside * e.weight;
      }
    }
  }
}

}  // namespace

Crust makeEllipsoidCrust(const GridPoints& points, const std::vector<float>& weights, int neighbors,
                         const Eigen::Vector3f& sensor, ThreadPool* pool) {
  const PointAdaptor adaptor{points.positions};
  Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  tree.buildIndex();
  std::vector<Ellipsoid> ellipsoids(points.size());
  parallelFor(pool, points.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::vector<uint32_t> near(static_cast<std::size_t>(neighbors));
    std::vector<float> distances2(near.size());
    for (std::size_t i = begin; i < end; ++i) {
      near.resize(distances2.size());
      near.resize(
          tree.knnSearch(points.positions[i].data(), near.size(), near.data(), distances2.data()));
      ellipsoids[i] = fitEllipsoid(points, near, sensor);
      ellipsoids[i].weight = weights.empty() ? 1.0F : weights[points.sources[i]];
    }
  });
  std::unordered_map<uint64_t, CellSums> cells;
  for (const Ellipsoid& ellipsoid : ellipsoids) addCells(ellipsoid, &cells);
  std::vector<Surfel> surfels;
  surfels.reserve(cells.size());
  for (const auto& [key, sums] : cells) {
    const float length = sums.normal.norm();
    if (length < 0.1F * sums.trust) continue;  // normals that cancel are no surface
    Surfel surfel;
    surfel.key = key;
    surfel.normal = sums.normal / length;
    surfel.position = cubeCenter(key, 0) + sums.offset / length * surfel.normal;
    surfel.slowness = std::sqrt(sums.weight / sums.trust);
    surfels.push_back(surfel);
  }
  std::sort(surfels.begin(), surfels.end(),
            [](const Surfel& a, const Surfel& b) { return a.key < b.key; });
  return linkCells(points.frame, {surfels}, pool);
}

}  // namespace ladar_perception
