// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "crust_clouds.h"
#include "ladar_perception/resample/column_mask.h"

namespace ladar_perception {
namespace {

constexpr uint32_t kAll = (uint32_t{1} << kMaskEdge) - 1;

bool at(const ColumnMask& mask, int u, int v) {
  return (mask[static_cast<std::size_t>(v)] >> u & 1) != 0;
}

/// By definition: a place is open if a free square holds it.
ColumnMask closedOneByOne(const ColumnMask& mask) {
  ColumnMask closed;
  closed.fill(kAll);
  for (int v0 = 1 - kOpenColumns; v0 < kMaskEdge; ++v0) {
    for (int u0 = 1 - kOpenColumns; u0 < kMaskEdge; ++u0) {
      ColumnMask square{};
      for (int v = std::max(v0, 0); v < std::min(v0 + kOpenColumns, kMaskEdge); ++v) {
        for (int u = std::max(u0, 0); u < std::min(u0 + kOpenColumns, kMaskEdge); ++u) {
          square[static_cast<std::size_t>(v)] |= uint32_t{1} << u;
        }
      }
      bool free = true;
      for (std::size_t v = 0; v < mask.size(); ++v) free = free && (mask[v] & square[v]) == 0;
      for (std::size_t v = 0; free && v < mask.size(); ++v) closed[v] &= ~square[v];
    }
  }
  return closed;
}

TEST(CloseGaps, FillsBetweenLinesUpToTheWidthOfASquare) {
  for (int gap = 1; gap <= 8; ++gap) {
    ColumnMask lines{};
    lines[1] = kAll;
    lines[static_cast<std::size_t>(gap + 2)] = kAll;
    const ColumnMask closed = closeGaps(lines);
    for (std::size_t row = 0; row < closed.size(); ++row) {
      const bool between = row >= 1 && row <= static_cast<std::size_t>(gap + 2);
      const bool filled = lines[row] != 0 || (between && gap < kOpenColumns);
      EXPECT_EQ(closed[row], filled ? kAll : 0u) << gap << ", row " << row;
    }
  }
}

TEST(CloseGaps, LeavesAPlaceOpenThatWasNotSeen) {
  // Points all around a free place of 10 columns.
  ColumnMask around{};
  for (int v = 0; v < kMaskEdge; ++v) {
    for (int u = 0; u < kMaskEdge; ++u) {
      const double radius = std::hypot(u - 5.5, v - 5.5);
      if (radius > 5.2) around[static_cast<std::size_t>(v)] |= uint32_t{1} << u;
    }
  }
  const ColumnMask closed = closeGaps(around);
  for (int i = 3; i <= 8; ++i) {
    EXPECT_FALSE(at(closed, i, 5)) << i;
    EXPECT_FALSE(at(closed, 5, i)) << i;
  }
}

TEST(CloseGaps, AgreesWithSquareBySquare) {
  test::TestRandom random(1);
  for (int round = 0; round < 300; ++round) {
    ColumnMask mask{};
    const int points = static_cast<int>(random.real(0, 30));
    for (int i = 0; i < points; ++i) {
      mask[static_cast<std::size_t>(random.real(0, kMaskEdge))] |=
          uint32_t{1} << static_cast<int>(random.real(0, kMaskEdge));
    }
    const ColumnMask closed = closeGaps(mask);
    ASSERT_EQ(closed, closedOneByOne(mask));
    for (std::size_t row = 0; row < mask.size(); ++row) ASSERT_EQ(mask[row] & ~closed[row], 0u);
    ASSERT_EQ(closeGaps(closed), closed);
  }
}

TEST(ColumnsWithPoints, AreThoseOfAllPointsAround) {
  test::TestRandom random(2);
  const test::GriddedCloud gridded(test::ball({0, 0, 0}, 30, 400, &random));
  for (const int level : {2, 3, 4}) {
    const SparseGrid& grid = gridded.pyramid.level(level).grid;
    const double quarter = std::ldexp(1.0, level - 2);
    for (const int u : {0, 1, 2}) {
      const int v = (u + 1) % 3;
      for (uint32_t voxel = 0; voxel < grid.size(); ++voxel) {
        const Eigen::Vector3f corner =
            cubeCenter(grid.keys()[voxel], level).array() - static_cast<float>(6.0 * quarter);
        ColumnMask expected{};
        for (const Eigen::Vector3f& p : gridded.points.positions) {
          const Eigen::Array3f place = (p - corner).array() / static_cast<float>(quarter);
          if ((place < 0.0F).any() || (place >= static_cast<float>(kMaskEdge)).any()) continue;
          expected[static_cast<std::size_t>(place[v])] |= uint32_t{1} << static_cast<int>(place[u]);
        }
        ASSERT_EQ(columnsWithPoints(gridded.pyramid, level, voxel, u, v), expected);
      }
    }
  }
}

}  // namespace
}  // namespace ladar_perception
