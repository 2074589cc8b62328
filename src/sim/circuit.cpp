// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/circuit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ladar_perception::sim {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr int kSteps = 16384;
constexpr double kTableStepM = 0.5;
constexpr double kTableRimM = 60.0;

}  // namespace

Circuit::Circuit(const CircuitShape& shape) : shape_(shape), lengths_m_(kSteps + 1, 0.0) {
  for (int i = 1; i <= kSteps; ++i) {
    const double step = (pointAt(kTwoPi * i / kSteps) - pointAt(kTwoPi * (i - 1) / kSteps)).norm();
    lengths_m_[i] = lengths_m_[i - 1] + step;
  }
  length_m_ = lengths_m_.back();
  fillDistances();
}

double Circuit::radius(double angle_rad) const {
  const double n = shape_.squareness;
  const double x = std::pow(std::abs(std::cos(angle_rad)) / shape_.radius_x_m, n);
  const double y = std::pow(std::abs(std::sin(angle_rad)) / shape_.radius_y_m, n);
  const double waves = shape_.wave2 * std::cos(2.0 * angle_rad + shape_.wave2_phase_rad) +
                       shape_.wave3 * std::cos(3.0 * angle_rad + shape_.wave3_phase_rad);
  return std::pow(x + y, -1.0 / n) * (1.0 + waves);
}

Eigen::Vector2d Circuit::pointAt(double angle_rad) const {
  return radius(angle_rad) * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

double Circuit::angleAt(double s_m) const {
  const double s = s_m - length_m_ * std::floor(s_m / length_m_);
  const auto above = std::upper_bound(lengths_m_.begin() + 1, lengths_m_.end() - 1, s);
  const auto i = static_cast<double>(above - lengths_m_.begin() - 1);
  const double share = (s - above[-1]) / (*above - above[-1]);
  return kTwoPi * (i + share) / kSteps;
}

Eigen::Vector2d Circuit::position(double s_m) const { return pointAt(angleAt(s_m)); }

double Circuit::heading(double s_m) const {
  // Wide enough that the table's steps do not show, narrow against the track's curvature.
  const double angle = angleAt(s_m);
  const Eigen::Vector2d chord = pointAt(angle + 1e-4) - pointAt(angle - 1e-4);
  return std::atan2(chord.y(), chord.x());
}

Eigen::Vector2d Circuit::beside(double s_m, double left_m) const {
  const double h = heading(s_m);
  return position(s_m) + left_m * Eigen::Vector2d(-std::sin(h), std::cos(h));
}

void Circuit::fillDistances() {
  for (double s = 0.0; s < length_m_; s += 1.0) {
    points_.push_back(position(s));
    headings_rad_.push_back(heading(s));
  }
  for (const Eigen::Vector2d& p : points_) {
    half_size_m_ = std::max(half_size_m_, p.cwiseAbs().maxCoeff() + kTableRimM);
  }
  side_ = static_cast<int>(std::ceil(2.0 * half_size_m_ / kTableStepM)) + 1;
  distances_m_.assign(static_cast<std::size_t>(side_) * side_, static_cast<float>(kTableRimM));
  nearest_.assign(distances_m_.size(), 0);
  const auto reach = static_cast<int>(kTableRimM / kTableStepM);
  // Points 1 m apart are exact to 0.5^2 / (2 d) at the distance d.
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector2d& p = points_[i];
    const auto cx = static_cast<int>((p.x() + half_size_m_) / kTableStepM);
    const auto cy = static_cast<int>((p.y() + half_size_m_) / kTableStepM);
    for (int iy = std::max(cy - reach, 0); iy <= std::min(cy + reach, side_ - 1); ++iy) {
      for (int ix = std::max(cx - reach, 0); ix <= std::min(cx + reach, side_ - 1); ++ix) {
        const double dx = ix * kTableStepM - half_size_m_ - p.x();
        const double dy = iy * kTableStepM - half_size_m_ - p.y();
        const std::size_t node = static_cast<std::size_t>(iy) * side_ + ix;
        const auto squared = static_cast<float>(dx * dx + dy * dy);
        if (squared >= distances_m_[node] * distances_m_[node]) continue;
        distances_m_[node] = std::sqrt(squared);
        nearest_[node] = static_cast<uint16_t>(i);
      }
    }
  }
}

TrackPlace Circuit::placeOf(double x_m, double y_m) const {
  const auto cell = [&](double v) {
    const auto i = static_cast<int>(std::lround((v + half_size_m_) / kTableStepM));
    return static_cast<std::size_t>(std::clamp(i, 0, side_ - 1));
  };
  const uint16_t nearest = nearest_[cell(y_m) * side_ + cell(x_m)];
  const double h = headings_rad_[nearest];
  const Eigen::Vector2d offset = Eigen::Vector2d(x_m, y_m) - points_[nearest];
  const double along = offset.x() * std::cos(h) + offset.y() * std::sin(h);
  const double left = -offset.x() * std::sin(h) + offset.y() * std::cos(h);
  // The points stand one metre apart. What is along their tangent far out is less on the track in
  // a bend, or more on its inner side.
  const double next = headings_rad_[(nearest + 1) % points_.size()];
  const double bend = std::remainder(next - h, kTwoPi);
  return {nearest + along / std::max(1.0 - bend * left, 0.2), left};
}

double Circuit::distanceTo(double x_m, double y_m) const {
  const double gx = (x_m + half_size_m_) / kTableStepM;
  const double gy = (y_m + half_size_m_) / kTableStepM;
  if (gx < 0.0 || gy < 0.0 || gx >= side_ - 1 || gy >= side_ - 1) return kTableRimM;
  const auto ix = static_cast<std::size_t>(gx);
  const auto iy = static_cast<std::size_t>(gy);
  const double u = gx - static_cast<double>(ix);
  const double v = gy - static_cast<double>(iy);
  const float* row = &distances_m_[iy * side_ + ix];
  return (1.0 - v) * ((1.0 - u) * row[0] + u * row[1]) +
         v * ((1.0 - u) * row[side_] + u * row[side_ + 1]);
}

}  // namespace ladar_perception::sim
