// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/sampling_quality.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nanoflann.hpp>

namespace ladar_perception {
namespace {

using Points = std::vector<Eigen::Vector3d>;

struct PointSource {
  const Points& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[index][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointSource>,
                                                 PointSource, 3, uint32_t>;

/// Distance to the `rank`-th nearest point, the nearest being the first.
std::vector<double> distancesTo(const Points& to, const Points& from, std::size_t rank) {
  std::vector<double> distances(from.size(), std::numeric_limits<double>::infinity());
  if (to.size() < rank) return distances;
  const PointSource source{to};
  Tree tree(3, source, nanoflann::KDTreeSingleIndexAdaptorParams(12));
  tree.buildIndex();
  std::vector<uint32_t> indices(rank);
  std::vector<double> squared(rank);
  for (std::size_t i = 0; i < from.size(); ++i) {
    tree.knnSearch(from[i].data(), rank, indices.data(), squared.data());
    distances[i] = std::sqrt(squared[rank - 1]);
  }
  return distances;
}

double percentile(const std::vector<double>& sorted, double percent) {
  const double rank = std::ceil(0.01 * percent * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

struct Spread {
  double mean = 0.0;
  double cov = 0.0;
  double min_over_mean = 0.0;
};

Spread spreadOf(const std::vector<double>& values) {
  Spread spread;
  if (values.empty()) return spread;
  const auto count = static_cast<double>(values.size());
  for (const double value : values) spread.mean += value / count;
  if (spread.mean == 0.0) return spread;
  double variance = 0.0;
  for (const double value : values) variance += (value - spread.mean) * (value - spread.mean);
  spread.cov = std::sqrt(variance / count) / spread.mean;
  spread.min_over_mean = *std::min_element(values.begin(), values.end()) / spread.mean;
  return spread;
}

}  // namespace

Summary summarize(std::vector<double> values) {
  Summary summary;
  if (values.empty()) return summary;
  std::sort(values.begin(), values.end());
  summary.count = values.size();
  const auto count = static_cast<double>(values.size());
  double squares = 0.0;
  for (const double value : values) {
    summary.mean += value / count;
    squares += value * value / count;
  }
  summary.rms = std::sqrt(squares);
  summary.median = percentile(values, 50.0);
  summary.p95 = percentile(values, 95.0);
  summary.p99 = percentile(values, 99.0);
  summary.max = values.back();
  return summary;
}

std::vector<double> nearestDistances(const Points& from, const Points& to) {
  return distancesTo(to, from, 1);
}

std::vector<double> neighbourDistances(const Points& points) {
  return distancesTo(points, points, 2);  // the nearest is the point itself
}

SpacingStatistics spacingOf(const Points& samples) {
  return samples.size() < 2 ? SpacingStatistics() : spacingFrom(neighbourDistances(samples));
}

SpacingStatistics spacingFrom(const std::vector<double>& neighbour_distances_m) {
  SpacingStatistics statistics;
  statistics.samples = neighbour_distances_m.size();
  if (neighbour_distances_m.empty()) return statistics;
  const Spread all = spreadOf(neighbour_distances_m);
  const double limit = 2.0 * summarize(neighbour_distances_m).median;
  std::vector<double> connected;
  std::copy_if(neighbour_distances_m.begin(), neighbour_distances_m.end(),
               std::back_inserter(connected), [&](double d) { return d <= limit; });
  const Spread near = spreadOf(connected);
  statistics.mean_m = all.mean;
  statistics.cov = all.cov;
  statistics.min_over_mean = all.min_over_mean;
  statistics.isolated = neighbour_distances_m.size() - connected.size();
  statistics.connected_mean_m = near.mean;
  statistics.connected_cov = near.cov;
  statistics.connected_min_over_mean = near.min_over_mean;
  return statistics;
}

CoveringStatistics coveringOf(const Points& samples, const Points& reference, double spacing_m) {
  CoveringStatistics covering;
  covering.distance_m = summarize(nearestDistances(reference, samples));
  if (spacing_m > 0.0) {
    covering.p99_over_spacing = covering.distance_m.p99 / spacing_m;
    covering.max_over_spacing = covering.distance_m.max / spacing_m;
  }
  return covering;
}

std::vector<uint64_t> countInBoxes(const Points& points, const std::vector<OrientedBox>& boxes) {
  std::vector<uint64_t> counts(boxes.size(), 0);
  for (const Eigen::Vector3d& p : points) {
    for (std::size_t i = 0; i < boxes.size(); ++i) counts[i] += boxes[i].contains(p) ? 1 : 0;
  }
  return counts;
}

FaceRegion::FaceRegion(const Rectangle& rectangle, double cell_m)
    : rectangle_(rectangle),
      columns_(std::max(1, static_cast<int>(std::lround(rectangle.edge_u_m.norm() / cell_m)))),
      rows_(std::max(1, static_cast<int>(std::lround(rectangle.edge_v_m.norm() / cell_m)))),
      cells_(static_cast<std::size_t>(columns_) * rows_, 0) {}

Eigen::Vector3d FaceRegion::centreOf(int column, int row) const {
  return rectangle_.corner_m + (column + 0.5) / columns_ * rectangle_.edge_u_m +
         (row + 0.5) / rows_ * rectangle_.edge_v_m;
}

Eigen::Vector3d FaceRegion::toCells(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d offset = p - rectangle_.corner_m;
  const Eigen::Vector3d& u = rectangle_.edge_u_m;
  const Eigen::Vector3d& v = rectangle_.edge_v_m;
  return {columns_ * offset.dot(u) / u.squaredNorm(), rows_ * offset.dot(v) / v.squaredNorm(),
          offset.dot(rectangle_.normal())};
}

void FaceRegion::coverBy(const Points& points, double reach_m, double off_plane_m) {
  const double reach_u = reach_m * columns_ / rectangle_.edge_u_m.norm();
  const double reach_v = reach_m * rows_ / rectangle_.edge_v_m.norm();
  // First and last index whose centre lies within the reach; none if the first exceeds the last.
  const auto first = [](double at, double reach) {
    return static_cast<int>(std::max(std::ceil(at - reach - 0.5), 0.0));
  };
  const auto last = [](double at, double reach, int count) {
    return static_cast<int>(std::min(std::floor(at + reach - 0.5), count - 1.0));
  };
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d at = toCells(p);
    if (!(std::abs(at.z()) <= off_plane_m)) continue;
    if (!(std::abs(at.x()) < 1e9 && std::abs(at.y()) < 1e9)) continue;
    for (int row = first(at.y(), reach_v); row <= last(at.y(), reach_v, rows_); ++row) {
      for (int column = first(at.x(), reach_u); column <= last(at.x(), reach_u, columns_);
           ++column) {
        set(column, row, true);
      }
    }
  }
}

void FaceRegion::shrink(double margin_m) {
  const int wide = static_cast<int>(std::ceil(margin_m * columns_ / rectangle_.edge_u_m.norm()));
  const int high = static_cast<int>(std::ceil(margin_m * rows_ / rectangle_.edge_v_m.norm()));
  const std::vector<uint8_t> before = cells_;
  // Cells that are in along a whole window; windows that leave the rectangle hold some that are
  // not.
  const auto erode = [](const std::vector<uint8_t>& in, int margin, int length, std::size_t stride,
                        std::size_t begin, std::vector<uint8_t>* out) {
    int run = 0;
    for (int i = 0; i < length; ++i) {
      run = in[begin + i * stride] != 0 ? run + 1 : 0;
      if (i >= margin) (*out)[begin + (i - margin) * stride] = run > 2 * margin ? 1 : 0;
    }
    for (int i = std::max(length - margin, 0); i < length; ++i) (*out)[begin + i * stride] = 0;
  };
  std::vector<uint8_t> along(cells_.size(), 0);
  for (int row = 0; row < rows_; ++row) {
    erode(before, wide, columns_, 1, indexOf(0, row), &along);
  }
  for (int column = 0; column < columns_; ++column) {
    erode(along, high, rows_, columns_, column, &cells_);
  }
}

double FaceRegion::area() const {
  return cellArea() * static_cast<double>(std::count(cells_.begin(), cells_.end(), 1));
}

bool FaceRegion::contains(const Eigen::Vector3d& p, double off_plane_m) const {
  const Eigen::Vector3d at = toCells(p);
  if (!(std::abs(at.z()) <= off_plane_m)) return false;
  if (!(at.x() >= 0.0 && at.x() < columns_ && at.y() >= 0.0 && at.y() < rows_)) return false;
  return this->at(static_cast<int>(at.x()), static_cast<int>(at.y()));
}

std::vector<FaceDensity> faceDensities(const std::vector<std::vector<FaceRegion>>& faces,
                                       const Points& samples, double off_plane_m) {
  std::vector<FaceDensity> densities(faces.size());
  FaceDensity all;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    FaceDensity& face = densities[i];
    for (const FaceRegion& region : faces[i]) face.area_m2 += region.area();
    if (face.area_m2 == 0.0) continue;
    for (const Eigen::Vector3d& p : samples) {
      // Rectangles of one face may overlap by a rim; a sample counts once.
      face.samples += std::any_of(faces[i].begin(), faces[i].end(), [&](const FaceRegion& region) {
        return region.contains(p, off_plane_m);
      });
    }
    all.samples += face.samples;
    all.area_m2 += face.area_m2;
  }
  for (FaceDensity& face : densities) {
    if (all.samples > 0) face.relative = face.perSquareMetre() / all.perSquareMetre();
  }
  return densities;
}

}  // namespace ladar_perception
