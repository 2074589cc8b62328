// SPDX-License-Identifier: BSD-3-Clause
// How good a sampling of a surface is. Distances are straight lines in space, so that samplings by
// any method, of any surface, are judged alike; where the surface bends by less than the spacing
// these are the distances along it within a few per cent.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace ladar_perception {

/// What a list of numbers looks like. All zero for an empty list.
struct Summary {
  uint64_t count = 0;
  double mean = 0.0;
  double rms = 0.0;
  double median = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// Percentile p is the smallest value that at least p per cent of the values do not exceed.
Summary summarize(std::vector<double> values);

/// Distance of every point of `from` to the nearest point of `to`, m; infinite if `to` is empty.
/// All points must be finite.
std::vector<double> nearestDistances(const std::vector<Eigen::Vector3d>& from,
                                     const std::vector<Eigen::Vector3d>& to);

/// Distance of every point to the nearest other one, m; 0 between duplicates, infinite for a single
/// point. All points must be finite.
std::vector<double> neighbourDistances(const std::vector<Eigen::Vector3d>& points);

/// How even the spacing of samples is. The distance from a sample to its nearest neighbour is
/// defined at the rim of an open surface as well as inside, and on the rim an even sampling has the
/// same: nothing is left out there. A hexagonal lattice has a cov of 0; points at random (Poisson)
/// have sqrt(4 / pi - 1) = 0.523.
struct SpacingStatistics {
  uint64_t samples = 0;
  double mean_m = 0.0;         ///< of the distances to the nearest neighbour: "the spacing"
  double cov = 0.0;            ///< their standard deviation over their mean
  double min_over_mean = 0.0;  ///< the smallest of them over their mean
  /// Samples without another within twice the median distance. Each is alone on a small island of
  /// the surface, a leaf or a mixed pixel: where the next island lies says nothing about the
  /// sampling.
  uint64_t isolated = 0;
  /// The three above without the isolated ones.
  double connected_mean_m = 0.0;
  double connected_cov = 0.0;
  double connected_min_over_mean = 0.0;
};

/// All zero for fewer than two samples. Of a sampling whose density is not meant to be even, only
/// parts where it is can be judged.
SpacingStatistics spacingOf(const std::vector<Eigen::Vector3d>& samples);
/// The same from distances to the nearest neighbours, for instance of the samples of one part only.
SpacingStatistics spacingFrom(const std::vector<double>& neighbour_distances_m);

/// How far places of the surface are from the nearest sample. `reference` stands for the surface:
/// the points of the raw cloud, or a lattice on the true surface. At the rim of an open surface,
/// places count like any other: a sampling that does not reach the rim covers it badly. The limit
/// of all samplings is the hexagonal lattice, max 1 / sqrt(3) = 0.577 of its spacing, p99 0.55; a
/// maximal set of points that keep a distance reaches max <= 1.
struct CoveringStatistics {
  Summary distance_m;
  double p99_over_spacing = 0.0;  ///< 0 if the spacing is
  double max_over_spacing = 0.0;
};

CoveringStatistics coveringOf(const std::vector<Eigen::Vector3d>& samples,
                              const std::vector<Eigen::Vector3d>& reference, double spacing_m);

/// A control volume.
struct OrientedBox {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_size_m = Eigen::Vector3d::Constant(0.5);
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: its axes, unit length

  /// Its sides belong to it. False for points that are not finite.
  bool contains(const Eigen::Vector3d& p) const {
    const Eigen::Array3d local = (axes.transpose() * (p - centre_m)).array().abs();
    return (local <= half_size_m.array()).all();
  }
};

/// How many points lie in each box; boxes may overlap.
std::vector<uint64_t> countInBoxes(const std::vector<Eigen::Vector3d>& points,
                                   const std::vector<OrientedBox>& boxes);

/// A flat piece of a surface.
struct Rectangle {
  Eigen::Vector3d corner_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d edge_u_m = Eigen::Vector3d::UnitX();
  Eigen::Vector3d edge_v_m = Eigen::Vector3d::UnitY();  ///< at right angles to edge_u_m

  Eigen::Vector3d normal() const { return edge_u_m.cross(edge_v_m).normalized(); }
  double area() const { return edge_u_m.norm() * edge_v_m.norm(); }
};

/// The part of a rectangle that a cloud covers, as a picture of square cells: what the ladar did
/// not see has no samples, and must not count as thinly sampled.
class FaceRegion {
 public:
  /// No cell is in the region. `cell_m` is about the size of a cell; cells fill the rectangle.
  FaceRegion(const Rectangle& rectangle, double cell_m);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double cellArea() const { return rectangle_.area() / static_cast<double>(cells_.size()); }
  Eigen::Vector3d centreOf(int column, int row) const;
  bool at(int column, int row) const { return cells_[indexOf(column, row)] != 0; }
  void set(int column, int row, bool in) { cells_[indexOf(column, row)] = in ? 1 : 0; }
  /// Takes cells in that lie within `reach_m`, along both edges, of the foot of a point nearer to
  /// the rectangle's plane than `off_plane_m`; points beside the rectangle count, too.
  void coverBy(const std::vector<Eigen::Vector3d>& points, double reach_m, double off_plane_m);
  /// Takes cells out that are nearer than `margin_m`, along both edges, to a cell that is not in or
  /// to the rectangle's rim: at a rim the number of samples depends on how they start there.
  void shrink(double margin_m);

  double area() const;  ///< of the cells that are in, m^2
  /// Whether the foot of a point nearer to the plane than `off_plane_m` lies in a cell that is in.
  bool contains(const Eigen::Vector3d& p, double off_plane_m) const;

 private:
  std::size_t indexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * columns_ + column;
  }
  /// In cells, from the corner; z is the distance from the plane in m.
  Eigen::Vector3d toCells(const Eigen::Vector3d& p) const;

  Rectangle rectangle_;
  int columns_;
  int rows_;
  std::vector<uint8_t> cells_;
};

/// Samples per area of one face, made of the regions of several rectangles or of one.
struct FaceDensity {
  uint64_t samples = 0;
  double area_m2 = 0.0;
  double relative = 0.0;  ///< to the density of all faces together; 0 without area

  double perSquareMetre() const {
    return area_m2 > 0.0 ? static_cast<double>(samples) / area_m2 : 0.0;
  }
};

/// Density of every face, `relative` to the sum of all their samples over the sum of their areas.
std::vector<FaceDensity> faceDensities(const std::vector<std::vector<FaceRegion>>& faces,
                                       const std::vector<Eigen::Vector3d>& samples,
                                       double off_plane_m);

}  // namespace ladar_perception
