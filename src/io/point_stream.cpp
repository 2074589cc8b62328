// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/point_stream.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ladar_perception {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points positionsOf(const Scan& scan) {
  const std::vector<double> x = readColumn(scan, "x");
  const std::vector<double> y = readColumn(scan, "y");
  const std::vector<double> z = readColumn(scan, "z");
  Points points(scan.size());
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = {x[i], y[i], z[i]};
  return points;
}

/// Main horizontal axis of the points, pointing to positive x.
Eigen::Vector2d mainAxis(const Points& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (const Eigen::Vector3d& p : points) {
    if (!p.allFinite()) continue;
    sum += p.head<2>();
    count += 1.0;
  }
  const Eigen::Vector2d mean = sum / std::max(count, 1.0);
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;
  for (const Eigen::Vector3d& p : points) {
    if (!p.allFinite()) continue;
    const Eigen::Vector2d d = p.head<2>() - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double angle = 0.5 * std::atan2(2.0 * xy, xx - yy);
  return {std::cos(angle), std::sin(angle)};
}

std::vector<std::size_t> sweepOrder(const Points& points) {
  const Eigen::Vector2d axis = mainAxis(points);
  std::vector<double> along(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    // A point without a place keeps the one of its predecessor in the file.
    const bool finite = points[i].allFinite();
    along[i] = finite ? axis.dot(points[i].head<2>()) : (i == 0 ? 0.0 : along[i - 1]);
  }
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return along[a] < along[b]; });
  return order;
}

/// The value below which `share` of the values lie; `values` must not be empty.
double percentile(std::vector<double> values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// Where a vehicle would stand among these points; `fallback` if none has a place.
Eigen::Vector3d standpoint(const Points& points, const std::vector<std::size_t>& indices,
                           const Eigen::Vector3d& fallback) {
  // A tenth of the points lies below ground level even where leaves or walls prevail, and
  // reflections below the ground are fewer than that.
  constexpr double kGroundShare = 0.1;
  constexpr double kLowBandM = 1.0;
  constexpr double kLevelShare = 0.3;
  std::vector<double> z;
  for (const std::size_t i : indices) {
    if (points[i].allFinite()) z.push_back(points[i].z());
  }
  if (z.empty()) return fallback;
  const double ground_z = percentile(z, kGroundShare);
  std::vector<double> low[3];
  for (const std::size_t i : indices) {
    if (!(std::abs(points[i].z() - ground_z) <= kLowBandM) || !points[i].allFinite()) continue;
    for (int k = 0; k < 3; ++k) low[k].push_back(points[i][k]);
  }
  return {percentile(low[0], 0.5), percentile(low[1], 0.5), percentile(low[2], kLevelShare)};
}

/// Mean of each position and its neighbours with weights 1, 2, 1: smooth, and without the lag of
/// a filter that knows only the past.
Points smoothed(const Points& track) {
  Points smooth(track.size());
  for (std::size_t i = 0; i < track.size(); ++i) {
    const Eigen::Vector3d& before = track[i == 0 ? i : i - 1];
    const Eigen::Vector3d& after = track[i + 1 == track.size() ? i : i + 1];
    smooth[i] = 0.25 * before + 0.5 * track[i] + 0.25 * after;
  }
  return smooth;
}

}  // namespace

std::vector<StreamScan> cutStream(const Scan& tile, const StreamConfig& config) {
  const Points points = positionsOf(tile);
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (config.order == StreamOrder::kSweep) order = sweepOrder(points);

  const std::size_t step = std::max<std::size_t>(config.points_per_scan, 1);
  std::vector<StreamScan> scans;
  Points track;
  for (std::size_t begin = 0; begin < order.size();) {
    const std::size_t left = order.size() - begin;
    const std::size_t count = left < step + (step + 1) / 2 ? left : step;
    const auto first = order.begin() + static_cast<std::ptrdiff_t>(begin);
    scans.emplace_back();
    scans.back().points.assign(first, first + static_cast<std::ptrdiff_t>(count));
    const Eigen::Vector3d before = track.empty() ? Eigen::Vector3d(0, 0, 0) : track.back();
    track.push_back(standpoint(points, scans.back().points, before));
    begin += count;
  }
  const Points smooth = smoothed(track);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    scans[i].T_map_vehicle.translation() = smooth[i];
  }
  return scans;
}

Scan takeStreamScan(const Scan& tile, const StreamScan& stream_scan,
                    const Eigen::Isometry3d& T_map_sensor) {
  const Eigen::Isometry3d T_sensor_map = T_map_sensor.inverse();
  std::vector<Column> columns;
  for (const char* axis : {"x", "y", "z"}) {
    // float32 is enough near the sensor.
    columns.push_back({axis, ScalarType::kFloat32, readColumn(tile, axis, stream_scan.points)});
  }
  for (std::size_t i = 0; i < stream_scan.points.size(); ++i) {
    const Eigen::Vector3d p_map(columns[0].values[i], columns[1].values[i], columns[2].values[i]);
    const Eigen::Vector3d p_sensor = T_sensor_map * p_map;
    columns[0].values[i] = p_sensor.x();
    columns[1].values[i] = p_sensor.y();
    columns[2].values[i] = p_sensor.z();
  }
  for (const Field& field : tile.layout.fields) {
    if (field.name == "x" || field.name == "y" || field.name == "z") continue;
    columns.push_back({field.name, field.type, readColumn(tile, field.name, stream_scan.points)});
  }
  return makeScan(columns);
}

}  // namespace ladar_perception
