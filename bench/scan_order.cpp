// SPDX-License-Identifier: BSD-3-Clause
#include "scan_order.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "ladar_perception/sim/random.h"

namespace ladar_perception::bench {
namespace {

// A ladar like that of the paper's vehicle: 32 lines of 180 points in 90 x 20 degrees, on a turret
// that pans and nods.
constexpr std::size_t kPointsPerFrame = 32 * 180;
constexpr double kHalfWidth_rad = 0.785;
constexpr double kHalfHeight_rad = 0.175;
constexpr double kLineSpacing_rad = 2.0 * kHalfHeight_rad / 32;
constexpr double kMaxPan_rad = 1.4;
constexpr double kPanPerFrame_rad = 0.13;
constexpr double kMeanTilt_rad = -0.35;
constexpr double kMaxNod_rad = 0.35;
constexpr double kNodPerFrame_rad = 0.37;
constexpr double kSensorHeight_m = 2.2;
constexpr int kAttempts = 100;
// Of a line's spacing: a point this near to a line may be on it.
constexpr double kOnLine = 0.15;

struct Frame {
  Eigen::Vector3d origin;
  double pan_rad, tilt_rad;
};

std::vector<Frame> drive(std::size_t frames, const Eigen::Vector3d& size_m) {
  std::vector<Frame> result;
  for (std::size_t i = 0; i < frames; ++i) {
    const auto index = static_cast<double>(i);
    const double x = -6.0 + (size_m.x() + 4.0) * index / static_cast<double>(frames);
    result.push_back({{x, 0.5 * size_m.y(), kSensorHeight_m},
                      kMaxPan_rad * std::sin(kPanPerFrame_rad * index),
                      kMeanTilt_rad + kMaxNod_rad * std::sin(kNodPerFrame_rad * index)});
  }
  return result;
}

/// Where in a frame's view a point lies.
struct View {
  double right_of_center_rad, above_center_rad;

  bool inside() const {
    return std::abs(right_of_center_rad) < kHalfWidth_rad &&
           std::abs(above_center_rad) < kHalfHeight_rad;
  }
  /// Distance from the nearest line, as a share of their spacing.
  double offLine() const {
    const double line = above_center_rad / kLineSpacing_rad;
    return std::abs(line - std::round(line));
  }
  /// Line, then place along it, in one number that sorts like a frame.
  uint64_t key() const {
    const auto line =
        static_cast<uint64_t>(std::round(above_center_rad / kLineSpacing_rad + 512.0));
    return line << 24 | static_cast<uint64_t>((right_of_center_rad + 8.0) * 1e6);
  }
};

View viewOf(const Frame& frame, const Eigen::Vector3d& p) {
  const Eigen::Vector3d from_sensor = p - frame.origin;
  return {std::atan2(from_sensor.y(), from_sensor.x()) - frame.pan_rad,
          std::atan2(from_sensor.z(), from_sensor.head<2>().norm()) - frame.tilt_rad};
}

}  // namespace

void sortInScanOrder(const Eigen::Vector3d& size_m, uint64_t seed,
                     std::vector<Eigen::Vector3d>* points) {
  const std::vector<Frame> frames = drive(points->size() / kPointsPerFrame + 1, size_m);
  sim::Random random(seed);
  std::vector<std::pair<uint64_t, uint32_t>> order;
  order.reserve(points->size());
  for (std::size_t i = 0; i < points->size(); ++i) {
    // A point that no frame drawn can see is a straggler of the last one.
    uint64_t key = 0;
    double off_line = 2.0;
    for (int attempt = 0; attempt < kAttempts && off_line > kOnLine; ++attempt) {
      const int index = random.below(static_cast<int>(frames.size()));
      const View view = viewOf(frames[static_cast<std::size_t>(index)], (*points)[i]);
      const double off = view.inside() ? view.offLine() : 1.0;
      if (off > off_line) continue;
      off_line = off;
      key = static_cast<uint64_t>(index) << 40 | view.key();
    }
    order.emplace_back(key, static_cast<uint32_t>(i));
  }
  std::sort(order.begin(), order.end());
  std::vector<Eigen::Vector3d> sorted;
  sorted.reserve(points->size());
  for (const auto& entry : order) sorted.push_back((*points)[entry.second]);
  points->swap(sorted);
}

}  // namespace ladar_perception::bench
