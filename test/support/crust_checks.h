// SPDX-License-Identifier: BSD-3-Clause
// What must hold for every crust, and what tests ask about one.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <set>
#include <vector>

#include "crust_clouds.h"
#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/morton.h"

namespace ladar_perception::test {

using CellPlace = std::array<int, 3>;

/// The cell's least cell of level 0.
inline CellPlace placeOf(const Crust& crust, std::size_t cell) {
  const uint64_t key = crust.keys[cell];
  return {static_cast<int>(morton::x(key)), static_cast<int>(morton::y(key)),
          static_cast<int>(morton::z(key))};
}

/// Whether the cubes of two cells share at least a corner.
inline bool touch(const Crust& crust, std::size_t a, std::size_t b) {
  const CellPlace at_a = placeOf(crust, a);
  const CellPlace at_b = placeOf(crust, b);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (at_a[axis] > at_b[axis] + (1 << crust.levels[b])) return false;
    if (at_b[axis] > at_a[axis] + (1 << crust.levels[a])) return false;
  }
  return true;
}

inline std::set<uint32_t> neighborsOf(const Crust& crust, std::size_t cell) {
  return {crust.neighbors.begin() + crust.first_neighbor[cell],
          crust.neighbors.begin() + crust.first_neighbor[cell + 1]};
}

inline void expectSoundCells(const Crust& crust, const Eigen::Vector3f& sensor) {
  const std::size_t size = crust.size();
  ASSERT_EQ(crust.keys.size(), size);
  ASSERT_EQ(crust.normals.size(), size);
  ASSERT_EQ(crust.slowness.size(), size);
  ASSERT_EQ(crust.levels.size(), size);
  for (std::size_t i = 0; i < size; ++i) {
    if (i > 0) {
      ASSERT_LT(crust.keys[i - 1], crust.keys[i]);
    }
    ASSERT_EQ(crust.keys[i] & ((uint64_t{1} << 3 * crust.levels[i]) - 1), 0u);
    ASSERT_TRUE(crust.positions[i].allFinite());
    ASSERT_NEAR(crust.normals[i].norm(), 1.0F, 1e-4F);
    ASSERT_GT(crust.slowness[i], 0.0F);
    // Blended from normals that face the sensor; at grazing angles not quite.
    const Eigen::Vector3f to_sensor = (sensor - crust.positions[i]).normalized();
    ASSERT_GT(crust.normals[i].dot(to_sensor), -0.2F) << i;
  }
}

/// Links are of both cells, once, to another cell that touches, never through a thin wall.
inline void expectSoundLinks(const Crust& crust) {
  ASSERT_EQ(crust.first_neighbor.size(), crust.size() + 1);
  ASSERT_EQ(crust.first_neighbor.front(), 0u);
  ASSERT_EQ(crust.first_neighbor.back(), crust.neighbors.size());
  std::vector<std::set<uint32_t>> neighbors;
  for (std::size_t i = 0; i < crust.size(); ++i) {
    ASSERT_LE(crust.first_neighbor[i], crust.first_neighbor[i + 1]);
    neighbors.push_back(neighborsOf(crust, i));
    ASSERT_EQ(neighbors[i].size(), crust.first_neighbor[i + 1] - crust.first_neighbor[i]);
  }
  for (std::size_t i = 0; i < crust.size(); ++i) {
    for (const uint32_t other : neighbors[i]) {
      ASSERT_LT(other, crust.size());
      ASSERT_NE(other, i);
      ASSERT_EQ(neighbors[other].count(static_cast<uint32_t>(i)), 1u);
      ASSERT_TRUE(touch(crust, i, other));
    }
  }
}

inline void expectSoundCrust(const Crust& crust, const Eigen::Vector3f& sensor) {
  expectSoundCells(crust, sensor);
  expectSoundLinks(crust);
}

inline void expectSameCrust(const Crust& a, const Crust& b) {
  ASSERT_EQ(a.keys, b.keys);
  ASSERT_TRUE(a.positions == b.positions);
  ASSERT_TRUE(a.normals == b.normals);
  ASSERT_EQ(a.slowness, b.slowness);
  ASSERT_EQ(a.levels, b.levels);
  ASSERT_EQ(a.first_neighbor, b.first_neighbor);
  ASSERT_EQ(a.neighbors, b.neighbors);
}

/// Number of the linked part of the crust for every cell, from 0.
inline std::vector<std::size_t> partsOf(const Crust& crust) {
  constexpr std::size_t kNone = ~std::size_t{0};
  std::vector<std::size_t> part(crust.size(), kNone);
  std::size_t parts = 0;
  for (std::size_t seed = 0; seed < crust.size(); ++seed) {
    if (part[seed] != kNone) continue;
    std::vector<std::size_t> open = {seed};
    part[seed] = parts;
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back();
      for (const uint32_t other : neighborsOf(crust, at)) {
        if (part[other] != kNone) continue;
        part[other] = parts;
        open.push_back(other);
      }
    }
    ++parts;
  }
  return part;
}

inline std::size_t countParts(const Crust& crust) {
  const std::vector<std::size_t> parts = partsOf(crust);
  return std::set<std::size_t>(parts.begin(), parts.end()).size();
}

/// Share of the cells in the largest part.
inline double largestPart(const Crust& crust) {
  const std::vector<std::size_t> parts = partsOf(crust);
  std::size_t most = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto same = std::count(parts.begin(), parts.end(), i);
    most = std::max(most, static_cast<std::size_t>(same));
    if (same == 0) break;
  }
  return static_cast<double>(most) / static_cast<double>(parts.size());
}

/// The two coordinates of a cell across an axis.
inline std::array<int, 2> columnOf(const Crust& crust, std::size_t cell, std::size_t axis) {
  const CellPlace at = placeOf(crust, cell);
  return {at[(axis + 1) % 3], at[(axis + 2) % 3]};
}

}  // namespace ladar_perception::test
