// SPDX-License-Identifier: BSD-3-Clause
// Which cells of a crust have samples, found by place: on another sheet of the surface, or another
// island, no link leads to them.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/sparse_grid.h"

namespace ladar_perception {

class TakenCells {
 public:
  /// How far around a cell others are found at least, in its edges.
  static constexpr int kReach = 2;

  explicit TakenCells(const Crust& crust);

  /// Different tiles may do so at the same time.
  void add(uint32_t cell);
  /// Appends the taken cells around a place in or near a cell, of its size, half and twice of it;
  /// of other sizes some farther off, too.
  void findAround(uint32_t cell, const Eigen::Vector3f& place, std::vector<uint32_t>* cells) const;

 private:
  /// The cells of one size.
  struct Level {
    SparseGrid grid;
    std::vector<uint32_t> numbers;  // in the crust
    std::vector<uint64_t> taken;    // by brick: a bit a cell
    std::vector<uint8_t> edge;      // by brick: cells of which other sizes may be in reach
  };

  /// Marks the bricks of a level and of the next larger one that are near to each other.
  void markEdges(std::size_t number);
  /// Taken cells near the one at a bit of a brick.
  static void findNear(const Level& level, uint32_t brick, uint64_t bit,
                       std::vector<uint32_t>* cells);
  /// Taken cells of another size around one, and some farther off.
  void findWithin(std::size_t number, uint32_t cell, std::vector<uint32_t>* cells) const;

  const Crust& crust_;
  std::vector<Level> levels_;
  std::vector<uint32_t> bricks_;  // by cell, in the grid of its level
};

}  // namespace ladar_perception
