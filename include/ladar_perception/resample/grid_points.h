// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ladar_perception {

/// A grid's place in space. Inside the room lengths are counted in cells and places from the
/// origin, so that float32 holds them to a thousandth of a cell wherever the cloud lies.
struct GridFrame {
  /// Cell coordinates of the origin: room on both sides for points that come later.
  static constexpr uint32_t kOriginCell = 1U << 19;
  /// Cells from the origin that have a key, on either side.
  static constexpr double kReachCells = (1U << 19) - 64;

  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  double cell_m = 1.0;

  Eigen::Vector3d toCells(const Eigen::Vector3d& p_m) const {
    return (p_m - origin_m) * (1.0 / cell_m);
  }
  Eigen::Vector3d toMetres(const Eigen::Vector3f& p_cells) const {
    return origin_m + cell_m * p_cells.cast<double>();
  }
  bool reaches(const Eigen::Vector3d& p_cells) const {
    return p_cells.cwiseAbs().maxCoeff() < kReachCells;
  }
};

/// The library's floor is a call on CPUs without SSE4.1.
inline int floorToInt(float value) {
  const int towards_zero = static_cast<int>(value);
  return towards_zero - (value < static_cast<float>(towards_zero) ? 1 : 0);
}

/// Morton key of the cell a place lies in, given in cells from the origin.
uint64_t cellKey(const Eigen::Vector3f& p_cells);
/// Cells from the origin to the centre of a cube of 2^level cells; `key` is that of its cells, less
/// the lowest 3 `level` bits.
Eigen::Vector3f cubeCenter(uint64_t key, int level);

/// Points in the order of their cells' Morton keys; those of one cell keep the order they came in.
struct GridPoints {
  GridFrame frame;
  std::vector<uint64_t> keys;
  std::vector<uint32_t> sources;           ///< index among the points given
  std::vector<Eigen::Vector3f> positions;  ///< cells from the origin

  std::size_t size() const { return keys.size(); }
};

/// Sorts points, or every `stride`-th, into a grid; points out of the grid's reach (524,000 cells
/// from the origin) are left out.
GridPoints sortIntoGrid(const std::vector<Eigen::Vector3d>& positions_m, const GridFrame& frame,
                        std::size_t stride = 1);

/// The origin for a cloud: its least corner, or around its median where the extent is out of reach.
Eigen::Vector3d gridOrigin(const std::vector<Eigen::Vector3d>& positions_m, double cell_m);

}  // namespace ladar_perception
