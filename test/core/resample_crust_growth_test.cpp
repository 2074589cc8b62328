// SPDX-License-Identifier: BSD-3-Clause
// A crust made with the memory of an earlier one: the same bits as without, and only what depends
// on a change is worked out.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "crust_clouds.h"
#include "ladar_perception/resample/crust.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using test::Cloud;
using test::GriddedCloud;
using test::joined;
using test::PlaneFrame;
using test::TestRandom;

const Vector3f kSensor(20, -30, 60);

/// Ground under rings that are bridged, a wall, foliage and a wire.
Cloud scene(TestRandom* random) {
  std::vector<double> radii;
  for (double radius = 8.0; radius < 120.0; radius *= 1.12) radii.push_back(radius);
  Cloud cloud = test::rings(radii, 400, 0.05, random);
  cloud = joined(cloud, test::patch(PlaneFrame({0, 60, 15}, Vector3d(0.2, -1, 0.05)), 80, 30, 6000,
                                    0.1, random));
  cloud = joined(cloud, test::ball({50, -20, 12}, 10, 3000, random));
  return joined(cloud, test::segment({-60, -60, 20}, {60, -50, 22}, 300, 0.05, random));
}

Cloud within(const Cloud& cloud, const Vector3d& center, double radius, bool inside) {
  Cloud part;
  for (const Vector3d& p : cloud) {
    if (((p - center).norm() < radius) == inside) part.push_back(p);
  }
  return part;
}

class CrustGrowth : public testing::TestWithParam<std::string> {
 protected:
  static constexpr int kCoarsest = 2;

  /// Sizes of cells by place, or none.
  static std::vector<uint8_t> levelsOf(const GriddedCloud& cloud) {
    std::vector<uint8_t> levels;
    if (GetParam() == "OneSize") return levels;
    for (const uint64_t key : cloud.pyramid.level(0).grid.keys()) {
      const Vector3f middle = cubeCenter(key, 0);
      levels.push_back(
          static_cast<uint8_t>(std::clamp(static_cast<int>(middle.norm() / 40), 0, kCoarsest)));
    }
    return levels;
  }

  /// The next crust, with and without memory.
  void expectSame(const Cloud& cloud, int threads = 1) {
    auto now = std::make_unique<GriddedCloud>(cloud, test::gridFrame(1.0), std::vector<float>(),
                                              kBridgeLevels + 1 + kCoarsest);
    std::vector<std::vector<uint32_t>> unchanged;
    for (int level = 0; before_ && level < now->pyramid.levels(); ++level) {
      unchanged.push_back(
          unchangedBricks(now->pyramid.level(level), before_->pyramid.level(level)));
    }
    ThreadPool pool(threads);
    const Crust grown = makeSurfelCrust(now->pyramid, now->points.frame, levelsOf(*now), kSensor,
                                        &pool, unchanged, &memory_);
    const Crust anew =
        makeSurfelCrust(now->pyramid, now->points.frame, levelsOf(*now), kSensor, &pool);
    ASSERT_GT(anew.size(), 1000u);
    EXPECT_TRUE(grown.keys == anew.keys);
    EXPECT_TRUE(grown.positions == anew.positions);
    EXPECT_TRUE(grown.normals == anew.normals);
    EXPECT_TRUE(grown.slowness == anew.slowness);
    EXPECT_TRUE(grown.levels == anew.levels);
    EXPECT_TRUE(grown.first_neighbor == anew.first_neighbor);
    EXPECT_TRUE(grown.neighbors == anew.neighbors);
    before_ = std::move(now);
  }

  CrustMemory memory_;
  std::unique_ptr<GriddedCloud> before_;
};

TEST_P(CrustGrowth, IsTheCrustOfAllPoints) {
  TestRandom random(1);
  const Cloud all = scene(&random);
  Cloud cloud = within(all, {40, 40, 0}, 40, false);
  expectSame(cloud);
  cloud = joined(cloud, within(all, {40, 40, 0}, 40, true));
  expectSame(cloud);
  for (int i = 0; i < 12; ++i) {
    const Vector3d center(random.real(-80, 80), random.real(-80, 80), random.real(0, 20));
    const auto count = static_cast<std::size_t>(std::pow(10.0, random.real(0, 3)));
    cloud = joined(cloud, test::ball(center, random.real(0.5, 25), count, &random));
    expectSame(cloud, 1 + i % 3);
  }
}

/// Points may go again, as lone ones do and small islands.
TEST_P(CrustGrowth, OrShrinks) {
  TestRandom random(2);
  const Cloud all = scene(&random);
  expectSame(all);
  expectSame(within(all, {30, 30, 0}, 15, false), 2);
  expectSame(within(all, {0, 60, 15}, 30, false));
  expectSame(all);
}

TEST_P(CrustGrowth, NothingNew) {
  TestRandom random(3);
  const Cloud all = scene(&random);
  expectSame(all);
  expectSame(all);
}

INSTANTIATE_TEST_SUITE_P(Cells, CrustGrowth, testing::Values("OneSize", "SeveralSizes"),
                         [](const auto& test_case) { return test_case.param; });

/// Pieces far from a change come out of the memory: here with a mark that no fit would give them.
TEST(CrustGrowthWork, FitsOnlyWhatDependsOnTheChange) {
  TestRandom random(4);
  const Cloud cloud = test::patch(PlaneFrame(), 200, 200, 80000, 0.05, &random);
  const GriddedCloud before(cloud);
  const GriddedCloud after(joined(cloud, test::ball({60, 60, 0}, 2, 100, &random)));
  ThreadPool pool(1);
  FitMemory memory;
  fitSurface(before.pyramid, 0, {}, kSensor, &pool, {}, &memory);
  for (FitMemory::Level& level : memory.levels) {
    for (SurfaceFit& fit : level.fits) fit.weight = 7.0F;
  }
  std::vector<std::vector<uint32_t>> unchanged;
  for (int level = 0; level <= kBridgeLevels; ++level) {
    unchanged.push_back(unchangedBricks(after.pyramid.level(level), before.pyramid.level(level)));
  }
  std::size_t marked = 0;
  for (const SurfaceFit& piece :
       fitSurface(after.pyramid, 0, {}, kSensor, &pool, unchanged, &memory)) {
    if (piece.level > 0) continue;  // larger voxels depend on more
    marked += piece.weight == 7.0F ? 1 : 0;
    // A brick with new points, those around it, and the reach of a voxel.
    const float off = (piece.center - Vector3f(60, 60, 0)).head<2>().cwiseAbs().maxCoeff();
    if (off > 14.0F) {
      EXPECT_EQ(piece.weight, 7.0F) << piece.center.transpose();
    } else if (off < 4.0F) {
      EXPECT_EQ(piece.weight, 1.0F) << piece.center.transpose();
    }
  }
  EXPECT_GT(marked, 15000u);
}

TEST(CrustGrowthWork, BlendsOnlyTilesThatAChangeReaches) {
  std::vector<SurfaceFit> pieces;
  for (int y = -100; y < 100; y += 2) {
    for (int x = -100; x < 100; x += 2) {
      SurfaceFit piece;
      piece.center = Vector3f(static_cast<float>(x), static_cast<float>(y), 0.3F);
      piece.normal = Vector3f::UnitZ();
      piece.major = Vector3f::UnitX();
      piece.semi_major = piece.semi_minor = 2.0F;
      pieces.push_back(piece);
    }
  }
  ThreadPool pool(1);
  BlendMemory memory;
  blendSurface(pieces, 0, &pool, &memory);
  const std::size_t cells = memory.surfels.size();
  for (Surfel& surfel : memory.surfels) surfel.slowness = 7.0F;
  for (SurfaceFit& piece : pieces) {
    if (piece.center.x() == 10.0F && piece.center.y() == 10.0F) piece.center.z() += 0.1F;
  }
  blendSurface(pieces, 0, &pool, &memory);
  EXPECT_EQ(memory.surfels.size(), cells);
  std::size_t blended = 0;
  for (const Surfel& surfel : memory.surfels) {
    if (surfel.slowness == 7.0F) continue;
    ++blended;
    EXPECT_EQ(surfel.slowness, 1.0F);
    // The tile of 32 cells that the piece lies in.
    EXPECT_GE(surfel.position.x(), 0.0F);
    EXPECT_GE(surfel.position.y(), 0.0F);
    EXPECT_LT(surfel.position.x(), 32.0F);
    EXPECT_LT(surfel.position.y(), 32.0F);
  }
  EXPECT_EQ(blended, 32u * 32u);
}

}  // namespace
}  // namespace ladar_perception
