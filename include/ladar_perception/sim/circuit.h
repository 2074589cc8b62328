// SPDX-License-Identifier: BSD-3-Clause
// The closed track a vehicle drives round and round, and how far things stand from it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ladar_perception::sim {

/// Closed curve around the origin, in polar form: a superellipse times slow waves.
struct CircuitShape {
  double radius_x_m = 55.0;
  double radius_y_m = 45.0;
  double squareness = 2.0;  ///< exponent of the superellipse; 2 is an ellipse
  double wave2 = 0.0;       ///< share of the radius that varies twice per turn
  double wave3 = 0.0;       ///< share of the radius that varies three times per turn
  double wave2_phase_rad = 0.0;
  double wave3_phase_rad = 0.0;
};

/// Place of a point in the coordinates of a track.
struct TrackPlace {
  double s_m = 0.0;     ///< arc length of the track's nearest point
  double left_m = 0.0;  ///< distance to the left of it; negative: to the right
};

/// Track, driven counter-clockwise, parametrised by its arc length.
class Circuit {
 public:
  explicit Circuit(const CircuitShape& shape);

  double length() const { return length_m_; }
  /// Point at arc length `s_m`; any value, the track is periodic.
  Eigen::Vector2d position(double s_m) const;
  /// Direction of travel, in (-pi, pi].
  double heading(double s_m) const;
  /// Point `left_m` to the left of the track.
  Eigen::Vector2d beside(double s_m, double left_m) const;
  /// The inverse of beside(), within 0.1 m up to 60 m from the track; beyond, and where the nearest
  /// point jumps, s_m means little.
  TrackPlace placeOf(double x_m, double y_m) const;
  /// Distance from the track's centre line, within 0.1 m from 2 m on; never more than 60 m.
  double distanceTo(double x_m, double y_m) const;

 private:
  double radius(double angle_rad) const;
  Eigen::Vector2d pointAt(double angle_rad) const;
  double angleAt(double s_m) const;
  void fillDistances();

  CircuitShape shape_;
  double length_m_ = 0.0;
  std::vector<double> lengths_m_;  // arc length at equal steps of the angle
  int side_ = 0;                   // nodes along a side of the distance table
  double half_size_m_ = 0.0;
  std::vector<float> distances_m_;
  std::vector<uint16_t> nearest_;        // of points_, for each node of the table
  std::vector<Eigen::Vector2d> points_;  // one metre apart
  std::vector<double> headings_rad_;     // at points_
};

}  // namespace ladar_perception::sim
