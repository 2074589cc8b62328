// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/height_field.h"

#include <algorithm>
#include <cmath>

#include "ladar_perception/sim/random.h"

namespace ladar_perception::sim {
namespace {

double latticeValue(int64_t ix, int64_t iy, uint64_t seed) {
  // One hash only: a world evaluates this some ten million times. The odd factors keep lattice
  // points apart before mixing.
  const uint64_t bits = mixBits(seed + static_cast<uint64_t>(ix) * 0x9e3779b97f4a7c15ULL +
                                static_cast<uint64_t>(iy) * 0xc2b2ae3d27d4eb4fULL);
  return 2.0 * unitFromBits(bits) - 1.0;
}

double fade(double u) { return u * u * u * (u * (6.0 * u - 15.0) + 10.0); }

/// Part of a ray inside a square of the plane, in the ray's t.
struct Span {
  double t_in;
  double t_out;
};

Span clipToSquare(const Ray& ray, double half_size_m, double t_limit) {
  Span span{0.0, t_limit};
  for (int i = 0; i < 2; ++i) {
    if (ray.direction[i] == 0.0) {
      if (std::abs(ray.origin[i]) > half_size_m) span.t_out = -1.0;
      continue;
    }
    const double t1 = (-half_size_m - ray.origin[i]) / ray.direction[i];
    const double t2 = (half_size_m - ray.origin[i]) / ray.direction[i];
    span.t_in = std::max(span.t_in, std::min(t1, t2));
    span.t_out = std::min(span.t_out, std::max(t1, t2));
  }
  return span;
}

/// Walks the cells of a grid with low corner (low, low) that the ray passes in the span, and
/// returns the first finite value of visit(ix, iy, t_in, t_out), or kMiss (Amanatides, Woo 1987).
/// Only cells in [first, first + count) are visited.
template <typename Visit>
double walkGrid(const Ray& ray, Span span, double low, double cell, Eigen::Array2i first, int count,
                Visit&& visit) {
  Eigen::Array2i index;
  Eigen::Array2i step;
  Eigen::Array2d t_next;
  Eigen::Array2d t_step;
  for (int i = 0; i < 2; ++i) {
    const double rate = ray.direction[i];
    const double start = (ray.origin[i] + span.t_in * rate - low) / cell;
    index[i] = std::clamp(static_cast<int>(std::floor(start)), first[i], first[i] + count - 1);
    step[i] = rate > 0.0 ? 1 : -1;
    t_step[i] = rate == 0.0 ? kMiss : cell / std::abs(rate);
    const double edge = low + cell * (index[i] + (rate > 0.0 ? 1 : 0));
    t_next[i] = rate == 0.0 ? kMiss : (edge - ray.origin[i]) / rate;
  }
  double t = span.t_in;
  while (t <= span.t_out) {
    const int axis = t_next[0] < t_next[1] ? 0 : 1;
    const double t_leave = std::min(t_next[axis], span.t_out);
    const double hit = visit(index[0], index[1], t, t_leave);
    if (hit != kMiss) return hit;
    t = t_next[axis];
    t_next[axis] += t_step[axis];
    index[axis] += step[axis];
    if (index[axis] < first[axis] || index[axis] >= first[axis] + count) break;
  }
  return kMiss;
}

}  // namespace

double valueNoise(double x, double y, uint64_t seed) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto ix = static_cast<int64_t>(fx);
  const auto iy = static_cast<int64_t>(fy);
  const double u = fade(x - fx);
  const double v = fade(y - fy);
  const double bottom = (1.0 - u) * latticeValue(ix, iy, seed) + u * latticeValue(ix + 1, iy, seed);
  const double top =
      (1.0 - u) * latticeValue(ix, iy + 1, seed) + u * latticeValue(ix + 1, iy + 1, seed);
  return (1.0 - v) * bottom + v * top;
}

HeightField::HeightField(double half_size_m, const HeightFunction& height_m,
                         const MaterialFunction& material) {
  blocks_ = std::max(1, static_cast<int>(std::ceil(2.0 * half_size_m / (kCellM * kBlockCells))));
  cells_ = blocks_ * kBlockCells;
  half_size_m_ = 0.5 * kCellM * cells_;
  const auto side = static_cast<std::size_t>(cells_) + 1;
  heights_m_.resize(side * side);
  materials_.resize(static_cast<std::size_t>(cells_) * cells_);
  block_tops_m_.assign(static_cast<std::size_t>(blocks_) * blocks_,
                       -std::numeric_limits<float>::infinity());
  for (int iy = 0; iy <= cells_; ++iy) {
    for (int ix = 0; ix <= cells_; ++ix) {
      const double x = ix * kCellM - half_size_m_;
      const double y = iy * kCellM - half_size_m_;
      heights_m_[iy * side + ix] = static_cast<float>(height_m(x, y));
      if (ix == cells_ || iy == cells_) continue;
      materials_[static_cast<std::size_t>(iy) * cells_ + ix] =
          material(x + 0.5 * kCellM, y + 0.5 * kCellM);
    }
  }
  for (int iy = 0; iy < cells_; ++iy) {
    for (int ix = 0; ix < cells_; ++ix) {
      float& top =
          block_tops_m_[static_cast<std::size_t>(iy / kBlockCells) * blocks_ + ix / kBlockCells];
      const double high =
          std::max({node(ix, iy), node(ix + 1, iy), node(ix, iy + 1), node(ix + 1, iy + 1)});
      top = std::max(top, static_cast<float>(high));
    }
  }
}

HeightField::Patch HeightField::patch(int ix, int iy) const {
  const double h00 = node(ix, iy);
  const double h10 = node(ix + 1, iy);
  const double h01 = node(ix, iy + 1);
  const double h11 = node(ix + 1, iy + 1);
  return {h00, h10 - h00, h01 - h00, h00 - h10 - h01 + h11};
}

double HeightField::height(double x_m, double y_m) const {
  if (cells_ == 0) return 0.0;
  const double gx = std::clamp((x_m + half_size_m_) / kCellM, 0.0, cells_ - 1e-9);
  const double gy = std::clamp((y_m + half_size_m_) / kCellM, 0.0, cells_ - 1e-9);
  const Patch p = patch(static_cast<int>(gx), static_cast<int>(gy));
  const double u = gx - std::floor(gx);
  const double v = gy - std::floor(gy);
  return p.h00 + p.dx * u + p.dy * v + p.dxy * u * v;
}

Eigen::Vector3d HeightField::normal(double x_m, double y_m) const {
  const double gx = std::clamp((x_m + half_size_m_) / kCellM, 0.0, cells_ - 1e-9);
  const double gy = std::clamp((y_m + half_size_m_) / kCellM, 0.0, cells_ - 1e-9);
  const Patch p = patch(static_cast<int>(gx), static_cast<int>(gy));
  const double slope_x = (p.dx + p.dxy * (gy - std::floor(gy))) / kCellM;
  const double slope_y = (p.dy + p.dxy * (gx - std::floor(gx))) / kCellM;
  return Eigen::Vector3d(-slope_x, -slope_y, 1.0).normalized();
}

Material HeightField::material(double x_m, double y_m) const {
  const auto ix = static_cast<int>((x_m + half_size_m_) / kCellM);
  const auto iy = static_cast<int>((y_m + half_size_m_) / kCellM);
  return materials_[static_cast<std::size_t>(std::clamp(iy, 0, cells_ - 1)) * cells_ +
                    std::clamp(ix, 0, cells_ - 1)];
}

double HeightField::intersect(const Ray& ray, double t_limit) const {
  if (cells_ == 0) return kMiss;
  const Span span = clipToSquare(ray, half_size_m_, t_limit);
  if (span.t_in > span.t_out) return kMiss;
  return walkGrid(ray, span, -half_size_m_, kCellM * kBlockCells, {0, 0}, blocks_,
                  [&](int bx, int by, double t_in, double t_out) {
                    const double lowest =
                        ray.origin.z() +
                        ray.direction.z() * (ray.direction.z() < 0.0 ? t_out : t_in);
                    if (lowest > blockTop(bx, by)) return kMiss;
                    return intersectBlock(ray, bx, by, t_in, t_out);
                  });
}

double HeightField::intersectBlock(const Ray& ray, int bx, int by, double t_in,
                                   double t_out) const {
  return walkGrid(ray, {t_in, t_out}, -half_size_m_, kCellM, {bx * kBlockCells, by * kBlockCells},
                  kBlockCells, [&](int ix, int iy, double t_from, double t_to) {
                    return intersectCell(ray, ix, iy, t_from, t_to);
                  });
}

double HeightField::intersectCell(const Ray& ray, int ix, int iy, double t_in, double t_out) const {
  const Patch p = patch(ix, iy);
  const double ru = ray.direction.x() / kCellM;
  const double rv = ray.direction.y() / kCellM;
  const double u = (ray.origin.x() + half_size_m_) / kCellM - ix + t_in * ru;
  const double v = (ray.origin.y() + half_size_m_) / kCellM - iy + t_in * rv;
  // Clearance above the patch, c + b s + a s^2, with s = t - t_in.
  const double c =
      ray.origin.z() + t_in * ray.direction.z() - (p.h00 + p.dx * u + p.dy * v + p.dxy * u * v);
  const double b = ray.direction.z() - p.dx * ru - p.dy * rv - p.dxy * (u * rv + v * ru);
  const double a = -p.dxy * ru * rv;
  // Neighbouring patches agree on their common edge; below it by rounding only means: hit here.
  if (c <= 0.0) return c > -1e-6 && t_in > 0.0 ? t_in : kMiss;
  const double discriminant = b * b - 4.0 * a * c;
  if (discriminant < 0.0) return kMiss;
  // The first root with falling clearance, in the form that does not cancel.
  const double denominator = -b + std::sqrt(discriminant);
  if (denominator <= 0.0) return kMiss;
  const double s = 2.0 * c / denominator;
  return s <= t_out - t_in + 1e-9 ? t_in + s : kMiss;
}

double HeightField::nearest(const Eigen::Vector3d& p, double limit_m,
                            Eigen::Vector3d* nearest) const {
  if (cells_ == 0) return kMiss;
  // The ground below or above is one candidate, so only cells nearer than it are looked at.
  const double x = std::clamp(p.x(), -half_size_m_, half_size_m_);
  const double y = std::clamp(p.y(), -half_size_m_, half_size_m_);
  Eigen::Vector3d best(x, y, height(x, y));
  double distance_m = (best - p).norm();
  const double reach_m = std::min(distance_m, limit_m);
  const auto cellOf = [&](double at) {
    return static_cast<int>(std::clamp((at + half_size_m_) / kCellM, 0.0, cells_ - 1.0));
  };
  for (int iy = cellOf(p.y() - reach_m); iy <= cellOf(p.y() + reach_m); ++iy) {
    for (int ix = cellOf(p.x() - reach_m); ix <= cellOf(p.x() + reach_m); ++ix) {
      const Eigen::Vector3d candidate = nearestInCell(p, ix, iy);
      if ((candidate - p).norm() >= distance_m) continue;
      distance_m = (candidate - p).norm();
      best = candidate;
    }
  }
  if (distance_m >= limit_m) return kMiss;
  *nearest = best;
  return distance_m;
}

Eigen::Vector3d HeightField::nearestInCell(const Eigen::Vector3d& p, int ix, int iy) const {
  const Patch patch_here = patch(ix, iy);
  const double low_x = ix * kCellM - half_size_m_;
  const double low_y = iy * kCellM - half_size_m_;
  double u = std::clamp((p.x() - low_x) / kCellM, 0.0, 1.0);
  double v = std::clamp((p.y() - low_y) / kCellM, 0.0, 1.0);
  const auto at = [&](double u_at, double v_at) {
    return Eigen::Vector3d(low_x + kCellM * u_at, low_y + kCellM * v_at,
                           patch_here.h00 + patch_here.dx * u_at + patch_here.dy * v_at +
                               patch_here.dxy * u_at * v_at);
  };
  // One coordinate at a time: along it the patch is a straight line, whose foot is exact.
  constexpr int kRounds = 12;
  for (int i = 0; i < kRounds; ++i) {
    for (double* coordinate : {&u, &v}) {
      *coordinate = 0.0;
      const Eigen::Vector3d from = at(u, v);
      *coordinate = 1.0;
      const Eigen::Vector3d along = at(u, v) - from;
      *coordinate = std::clamp(along.dot(p - from) / along.squaredNorm(), 0.0, 1.0);
    }
  }
  return at(u, v);
}

}  // namespace ladar_perception::sim
