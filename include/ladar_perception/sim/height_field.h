// SPDX-License-Identifier: BSD-3-Clause
// Ground: heights on a square grid, bilinear between its nodes, with a material per cell.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "ladar_perception/sim/primitive.h"

namespace ladar_perception::sim {

/// Smooth noise in about -1..1 with features of about one unit; the same bits for the same seed.
double valueNoise(double x, double y, uint64_t seed);

/// Square height field centred on the origin.
class HeightField {
 public:
  static constexpr double kCellM = 0.25;

  using HeightFunction = std::function<double(double x_m, double y_m)>;
  using MaterialFunction = std::function<Material(double x_m, double y_m)>;

  /// No ground at all: height() is 0, rays fall through.
  HeightField() = default;
  /// Covers at least -half_size_m..half_size_m in x and y.
  HeightField(double half_size_m, const HeightFunction& height_m, const MaterialFunction& material);

  double halfSize() const { return half_size_m_; }
  /// Height of the ground; outside the field, that of the nearest point of its rim.
  double height(double x_m, double y_m) const;
  Eigen::Vector3d normal(double x_m, double y_m) const;
  Material material(double x_m, double y_m) const;

  /// Smallest t in (0, t_limit] at which a ray from above meets the ground, or kMiss.
  double intersect(const Ray& ray, double t_limit) const;

  /// The point of the ground nearest to `p`, if there is one nearer than `limit_m`: within 0.1 mm
  /// of the nearest. Returns its distance, or kMiss with `*nearest` as it was.
  double nearest(const Eigen::Vector3d& p, double limit_m, Eigen::Vector3d* nearest) const;

 private:
  // Blocks of cells with the highest node of each: most rays pass above most blocks.
  static constexpr int kBlockCells = 16;

  struct Patch {
    double h00, dx, dy, dxy;  // height at the low corner, its slopes per cell, its twist
  };

  Patch patch(int ix, int iy) const;
  double node(int ix, int iy) const {
    return heights_m_[static_cast<std::size_t>(iy) * (cells_ + 1) + ix];
  }
  double blockTop(int bx, int by) const {
    return block_tops_m_[static_cast<std::size_t>(by) * blocks_ + bx];
  }
  Eigen::Vector3d nearestInCell(const Eigen::Vector3d& p, int ix, int iy) const;
  double intersectBlock(const Ray& ray, int bx, int by, double t_in, double t_out) const;
  double intersectCell(const Ray& ray, int ix, int iy, double t_in, double t_out) const;

  double half_size_m_ = 0.0;
  int cells_ = 0;   // along a side; a multiple of kBlockCells
  int blocks_ = 0;  // along a side
  std::vector<float> heights_m_;
  std::vector<float> block_tops_m_;
  std::vector<Material> materials_;
};

}  // namespace ladar_perception::sim
