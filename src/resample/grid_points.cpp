// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/grid_points.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/radix_sort.h"

namespace ladar_perception {
namespace {

/// Bits of coordinates spread for Morton keys, ten at a time.
struct SpreadBits {
  std::array<uint32_t, 1024> of_ten{};

  constexpr SpreadBits() {
    for (uint32_t i = 0; i < of_ten.size(); ++i)
      of_ten[i] = static_cast<uint32_t>(morton::spread(i));
  }
  uint64_t ofCell(float coordinate) const {
    constexpr auto kOrigin = static_cast<int>(GridFrame::kOriginCell);
    const auto cell = static_cast<uint32_t>(floorToInt(coordinate) + kOrigin);
    return of_ten[cell & 1023] | uint64_t{of_ten[cell >> 10 & 1023]} << 30;
  }
};
constexpr SpreadBits kSpread;

}  // namespace

uint64_t cellKey(const Eigen::Vector3f& p) {
  return kSpread.ofCell(p.x()) | kSpread.ofCell(p.y()) << 1 | kSpread.ofCell(p.z()) << 2;
}

Eigen::Vector3f cubeCenter(uint64_t key, int level) {
  const auto center = [level](uint32_t cube) {
    const int64_t twice = (2 * static_cast<int64_t>(cube) + 1) << level;
    return 0.5F * static_cast<float>(twice - 2 * int64_t{GridFrame::kOriginCell});
  };
  return {center(morton::x(key)), center(morton::y(key)), center(morton::z(key))};
}

GridPoints sortIntoGrid(const std::vector<Eigen::Vector3d>& positions_m, const GridFrame& frame,
                        std::size_t stride) {
  std::vector<Eigen::Vector3f> cells(positions_m.size());
  std::vector<KeyedIndex> keyed;
  keyed.reserve(positions_m.size() / stride + 1);
  for (std::size_t i = 0; i < positions_m.size(); i += stride) {
    const Eigen::Vector3d p = frame.toCells(positions_m[i]);
    if (!frame.reaches(p)) continue;
    cells[i] = p.cast<float>();
    keyed.push_back({cellKey(cells[i]), static_cast<uint32_t>(i)});
  }
  radixSort(&keyed);
  GridPoints points;
  points.frame = frame;
  points.keys.resize(keyed.size());
  points.sources.resize(keyed.size());
  points.positions.resize(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    points.keys[i] = keyed[i].key;
    points.sources[i] = keyed[i].index;
    points.positions[i] = cells[keyed[i].index];
  }
  return points;
}

Eigen::Vector3d gridOrigin(const std::vector<Eigen::Vector3d>& positions_m, double cell_m) {
  if (positions_m.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d least = positions_m.front();
  Eigen::Vector3d greatest = positions_m.front();
  for (const Eigen::Vector3d& p : positions_m) {
    least = least.cwiseMin(p);
    greatest = greatest.cwiseMax(p);
  }
  if ((greatest - least).maxCoeff() < GridFrame::kReachCells * cell_m) return least;
  std::vector<double> values(positions_m.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = positions_m[i][axis];
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    least[axis] = *middle;
  }
  return least;
}

}  // namespace ladar_perception
