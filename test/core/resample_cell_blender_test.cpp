// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "crust_clouds.h"
#include "ladar_perception/resample/cell_blender.h"
#include "ladar_perception/resample/grid_points.h"
#include "ladar_perception/resample/morton.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::TestRandom;

std::vector<Surfel> blended(const std::vector<SurfaceFit>& pieces, int level = 0, int threads = 1) {
  ThreadPool pool(threads);
  BlendMemory memory;
  blendSurface(pieces, level, &pool, &memory);
  return memory.surfels;
}

/// A disc.
SurfaceFit disc(const Vector3f& center, const Vector3f& normal, float radius) {
  SurfaceFit piece;
  piece.center = center;
  piece.normal = normal.normalized();
  piece.major = piece.normal.unitOrthogonal();
  piece.semi_major = piece.semi_minor = radius;
  return piece;
}

int mainAxis(const Vector3f& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return axis;
}

using Column = std::array<uint32_t, 2>;

Column columnOf(uint64_t key, int axis) {
  const std::array<uint32_t, 3> at = {morton::x(key), morton::y(key), morton::z(key)};
  const auto a = static_cast<std::size_t>(axis);
  return {at[(a + 1) % 3], at[(a + 2) % 3]};
}

void expectSound(const std::vector<Surfel>& surfels, int level) {
  const auto edge = static_cast<float>(1 << level);
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    const Surfel& surfel = surfels[i];
    if (i > 0) {
      ASSERT_LT(surfels[i - 1].key, surfel.key);
    }
    ASSERT_TRUE(surfel.position.allFinite());
    ASSERT_NEAR(surfel.normal.norm(), 1.0F, 1e-4F);
    ASSERT_GT(surfel.slowness, 0.0F);
    // In the cell, or close to it where its column's other cells are farther away.
    const Vector3f off = (surfel.position - cubeCenter(surfel.key, level)) / edge;
    ASSERT_LE(off.cwiseAbs().maxCoeff(), 1.0F);
  }
}

/// Of one surface whose main axis is everywhere the same.
void expectOneCellAColumn(const std::vector<Surfel>& surfels, int axis) {
  std::set<Column> columns;
  for (const Surfel& surfel : surfels) {
    ASSERT_EQ(mainAxis(surfel.normal), axis);
    ASSERT_TRUE(columns.insert(columnOf(surfel.key, axis)).second);
  }
}

TEST(BlendSurface, OfNothingIsNothing) { EXPECT_TRUE(blended({}).empty()); }

TEST(BlendSurface, ADiscIsTheColumnsInIt) {
  const std::array<Vector3f, 6> normals = {Vector3f(0, 0, 1),     Vector3f(0.3F, 0.2F, 1),
                                           Vector3f(1, 0, 0.1F),  Vector3f(-0.5F, 1, 0.3F),
                                           Vector3f(0.2F, -1, 0), Vector3f(0.6F, 0.1F, -1)};
  for (const Vector3f& direction : normals) {
    for (int level = 0; level <= 2; ++level) {
      const auto edge = static_cast<float>(1 << level);
      const SurfaceFit piece = disc({-3.3F, 2.2F, 1.6F}, direction, 6.4F * edge);
      const std::vector<Surfel> surfels = blended({piece}, level);
      expectSound(surfels, level);
      const int axis = mainAxis(piece.normal);
      expectOneCellAColumn(surfels, axis);
      for (const Surfel& surfel : surfels) {
        const Vector3f d = surfel.position - piece.center;
        ASSERT_NEAR(d.dot(piece.normal), 0.0F, 1e-3F * edge);
        ASSERT_LT(d.norm(), piece.semi_major * 1.001F);
        ASSERT_GT(surfel.normal.dot(piece.normal), 0.9999F);
      }
      // As many columns as their faces have room in the disc's shadow.
      const double shadow = M_PI * 6.4 * 6.4 * std::abs(piece.normal[axis]);
      EXPECT_NEAR(static_cast<double>(surfels.size()), shadow, 0.08 * shadow);
    }
  }
}

TEST(BlendSurface, AnEllipseLiesAlongItsMajorAxis) {
  SurfaceFit piece = disc({0.5F, 0.5F, 0.5F}, {0, 0, 1}, 1.0F);
  piece.major = Vector3f(1, 0, 0);
  piece.semi_major = 5.5F;
  piece.semi_minor = 0.75F;
  const std::vector<Surfel> surfels = blended({piece});
  ASSERT_EQ(surfels.size(), 11u);
  for (const Surfel& surfel : surfels) {
    EXPECT_NEAR(surfel.position.y(), 0.5F, 1e-5F);
    EXPECT_NEAR(surfel.position.z(), 0.5F, 1e-5F);
  }
}

TEST(BlendSurface, OverlappingPiecesMeetBetween) {
  // Two level discs, 0.3 cells one above the other, in one cell.
  const std::vector<SurfaceFit> pieces = {disc({0.5F, 0.5F, 0.35F}, {0, 0, 1}, 4.2F),
                                          disc({0.5F, 0.5F, 0.65F}, {0, 0, 1}, 4.2F)};
  const std::vector<Surfel> surfels = blended(pieces);
  expectSound(surfels, 0);
  expectOneCellAColumn(surfels, 2);
  for (const Surfel& surfel : surfels) EXPECT_NEAR(surfel.position.z(), 0.5F, 1e-4F);
}

TEST(BlendSurface, CoarsePiecesGiveWayToFineOnes) {
  std::vector<SurfaceFit> pieces = {disc({0.5F, 0.5F, 0.3F}, {0, 0, 1}, 4.2F),
                                    disc({0.5F, 0.5F, 0.7F}, {0, 0, 1}, 4.2F)};
  pieces[1].trust = 1.0F / 64.0F;
  for (const Surfel& surfel : blended(pieces)) EXPECT_NEAR(surfel.position.z(), 0.3F, 0.02F);
}

TEST(BlendSurface, SlownessIsTheRootOfTheMeanWeight) {
  std::vector<SurfaceFit> pieces = {disc({0.5F, 0.5F, 0.5F}, {0, 0, 1}, 4.2F)};
  pieces[0].weight = 0.16F;
  for (const Surfel& surfel : blended(pieces)) ASSERT_NEAR(surfel.slowness, 0.4F, 1e-5F);
  pieces.push_back(pieces[0]);
  pieces[1].weight = 1.0F;
  for (const Surfel& surfel : blended(pieces)) {
    ASSERT_NEAR(surfel.slowness * surfel.slowness, 0.58F, 1e-4F);
  }
}

TEST(BlendSurface, NormalsThatCancelAreNoSurface) {
  EXPECT_TRUE(blended({disc({0.5F, 0.5F, 0.5F}, {0, 0, 1}, 3.2F),
                       disc({0.5F, 0.5F, 0.5F}, {0, 0, -1}, 3.2F)})
                  .empty());
}

TEST(BlendSurface, SheetsAboveEachOtherStaySheets) {
  const std::vector<Surfel> surfels = blended(
      {disc({0.5F, 0.5F, 0.5F}, {0, 0, 1}, 6.2F), disc({0.5F, 0.5F, 3.5F}, {0, 0, 1}, 6.2F)});
  std::size_t low = 0;
  std::size_t high = 0;
  for (const Surfel& surfel : surfels) {
    low += std::abs(surfel.position.z() - 0.5F) < 1e-4F ? 1 : 0;
    high += std::abs(surfel.position.z() - 3.5F) < 1e-4F ? 1 : 0;
  }
  EXPECT_EQ(low, high);
  EXPECT_EQ(low + high, surfels.size());
  EXPECT_GT(low, 100u);
}

/// Discs in a row over a plane, as fits of its voxels are.
std::vector<SurfaceFit> discsOn(const test::PlaneFrame& plane, int half, TestRandom* random) {
  std::vector<SurfaceFit> pieces;
  for (int t = -half; t <= half; ++t) {
    for (int s = -half; s <= half; ++s) {
      const Vector3d center =
          plane.center + s * plane.u + t * plane.v + 0.05 * random->normal() * plane.normal;
      pieces.push_back(disc(center.cast<float>(),
                            (plane.normal + 0.03 * random->normal3()).cast<float>(), 1.3F));
    }
  }
  return pieces;
}

TEST(BlendSurface, OneCellAColumnWhereverAPlaneRunsThroughTheGrid) {
  TestRandom random(1);
  for (const double tilt : {0.0, 3.0, 15.0, 33.0}) {
    // At all heights in a cell, also on the very border between two.
    for (const double height : {0.0, 0.25, 0.5, 0.9}) {
      const test::PlaneFrame plane({0, 0, height}, test::tilted(tilt, 25.0));
      const std::vector<Surfel> surfels = blended(discsOn(plane, 25, &random));
      expectSound(surfels, 0);
      expectOneCellAColumn(surfels, 2);
      std::set<Column> columns;
      for (const Surfel& surfel : surfels) {
        columns.insert(columnOf(surfel.key, 2));
        ASSERT_NEAR(plane.height(surfel.position.cast<double>()), 0.0, 0.25);
      }
      // No holes in the middle.
      const uint32_t origin = GridFrame::kOriginCell;
      for (uint32_t y = origin - 14; y < origin + 14; ++y) {
        for (uint32_t x = origin - 14; x < origin + 14; ++x) {
          ASSERT_EQ(columns.count({x, y}), 1u) << tilt << " " << height << ": " << x << " " << y;
        }
      }
    }
  }
}

TEST(BlendSurface, IsTheSameForAnyNumberOfThreads) {
  TestRandom random(2);
  const std::vector<SurfaceFit> pieces = discsOn({{0, 0, 0}, {1, 2, 4}}, 90, &random);
  for (int level = 0; level <= 1; ++level) {
    const std::vector<Surfel> one = blended(pieces, level);
    for (const int threads : {2, 3}) {
      const std::vector<Surfel> several = blended(pieces, level, threads);
      ASSERT_EQ(one.size(), several.size());
      for (std::size_t i = 0; i < one.size(); ++i) {
        ASSERT_EQ(one[i].key, several[i].key);
        ASSERT_EQ(one[i].position, several[i].position);
        ASSERT_EQ(one[i].normal, several[i].normal);
        ASSERT_EQ(one[i].slowness, several[i].slowness);
      }
    }
  }
}

TEST(BlendSurface, FarFromTheGridsOrigin) {
  for (const float far : {-3e5F, 4e5F}) {
    const SurfaceFit piece = disc({far, -far, 1000.5F}, {0, 0, 1}, 5.3F);
    const std::vector<Surfel> surfels = blended({piece});
    expectSound(surfels, 0);
    EXPECT_NEAR(static_cast<double>(surfels.size()), M_PI * 5.3 * 5.3, 8.0);
  }
}

}  // namespace
}  // namespace ladar_perception
