// SPDX-License-Identifier: BSD-3-Clause
// Points added to a cloud that is there: what CloudResampler says of extend() is true.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "ladar_perception/resample/sampling_quality.h"
#include "resample_brute_force.h"

namespace ladar_perception::test {
namespace {

/// The engine, and whether resample() is told that more is to come.
class ResampleExtend : public testing::TestWithParam<std::tuple<std::string, bool>> {
 protected:
  static ResampledCloud begin(CloudResampler* resampler, const PoseCloudData& cloud,
                              const Policies& policies = {}) {
    return resampler->resample(cloud, policies, std::get<1>(GetParam()));
  }

  static ResampleConfig config(int count, double radius_m = 0.0) {
    ResampleConfig config;
    config.engine = std::get<0>(GetParam());
    config.count = count;
    config.radius_m = radius_m;
    return config;
  }

  /// The points of a cloud with x in [low, high).
  static PoseCloudData slab(const PoseCloudData& cloud, double low, double high) {
    PoseCloudData part;
    part.sensor_m = cloud.sensor_m;
    for (const Eigen::Vector3d& p : cloud.positions_m) {
      if (p.x() >= low && p.x() < high) part.positions_m.push_back(p);
    }
    return part;
  }

  /// How many of the samples stand in the extended cloud in the same order, at the same places, at
  /// its beginning.
  static std::size_t stayed(const ResampledCloud& before, const ResampledCloud& after) {
    std::size_t at = 0;
    for (const Eigen::Vector3d& p : before.positions_m) {
      if (at < after.size() && after.positions_m[at] == p) ++at;
    }
    return at;
  }
};

const Eigen::Vector3d kBox(6, 5, 3);

TEST_P(ResampleExtend, WithoutACloudBeforeIsResampling) {
  const PoseCloudData cloud = boxCloud(kBox, 20000, 0.005);
  CloudResampler resampler(config(800));
  const ResampledCloud extended = resampler.extend(cloud);
  const ResampledCloud resampled = CloudResampler(config(800)).resample(cloud);
  EXPECT_TRUE(extended.positions_m == resampled.positions_m);
  EXPECT_TRUE(extended.covering_radii == resampled.covering_radii);
  EXPECT_TRUE(extended.sources == resampled.sources);
}

TEST_P(ResampleExtend, AfterAnEmptyCloudCountsItsPoints) {
  const PoseCloudData cloud = boxCloud(kBox, 20000, 0.005);
  PoseCloudData nothing;
  nothing.positions_m.assign(3, Eigen::Vector3d::Constant(std::nan("")));
  CloudResampler resampler(config(100));
  EXPECT_EQ(begin(&resampler, nothing).size(), 0u);
  const ResampledCloud extended = resampler.extend(cloud);
  EXPECT_EQ(extended.size(), 100u);
  EXPECT_EQ(extended.points_in, cloud.positions_m.size() + 3);
  EXPECT_EQ(extended.points_finite, cloud.positions_m.size());
  for (const uint32_t source : extended.sources) EXPECT_GE(source, 3u);
}

TEST_P(ResampleExtend, SamplesStayAndCountMeansMore) {
  const PoseCloudData cloud = boxCloud(kBox, 60000, 0.005);
  CloudResampler resampler(config(500));
  const ResampledCloud before = begin(&resampler, slab(cloud, -1, 3));
  ASSERT_EQ(before.size(), 500u);
  const ResampledCloud after = resampler.extend(slab(cloud, 3, 7));
  EXPECT_EQ(after.size(), 1000u);
  EXPECT_EQ(after.points_in, cloud.positions_m.size());
  EXPECT_GE(stayed(before, after), 495u);  // the seam's surface may be found to be elsewhere
  // The new part is covered like the old one.
  const double before_m = coveringRadius(slab(cloud, -1, 3).positions_m, before.positions_m, 500);
  EXPECT_LT(coveringRadius(cloud.positions_m, after.positions_m, 1000), 1.2 * before_m);
  for (std::size_t i = 1; i < after.size(); ++i) {
    EXPECT_LE(after.covering_radii[i], after.covering_radii[i - 1]) << i;
  }
}

/// Crust of all points at once: as many cells, whichever way the points came.
TEST_P(ResampleExtend, TheCrustIsThatOfAllPoints) {
  const PoseCloudData cloud = boxCloud(kBox, 60000, 0.005);
  ResampleConfig fixed = config(500);
  fixed.cell_size_m = 0.1;
  CloudResampler resampler(fixed);
  // The first part has the least corner of all, and with it the origin of the grid.
  begin(&resampler, slab(cloud, -1, 3));
  const ResampledCloud after = resampler.extend(slab(cloud, 3, 7));
  PoseCloudData in_order = slab(cloud, -1, 3);
  for (const Eigen::Vector3d& p : slab(cloud, 3, 7).positions_m) in_order.positions_m.push_back(p);
  const ResampledCloud together = CloudResampler(fixed).resample(in_order);
  EXPECT_EQ(after.cells, together.cells);
  EXPECT_EQ(after.cell_size_m, together.cell_size_m);
}

TEST_P(ResampleExtend, KeepsTheRadius) {
  const PoseCloudData cloud = boxCloud(kBox, 60000, 0.005);
  CloudResampler resampler(config(0, 0.3));
  const ResampledCloud before = begin(&resampler, slab(cloud, -1, 3));
  const ResampledCloud after = resampler.extend(slab(cloud, 3, 7));
  EXPECT_GT(after.size(), before.size() * 3 / 2);
  // A place that has a sample near in a straight line gets no other, though fronts come later to it
  // along the surface.
  EXPECT_LE(after.covering_radii.back(), 0.3F * 1.2F);
  EXPECT_LT(coveringRadius(cloud.positions_m, after.positions_m, after.size()), 0.3 + 0.15);
  // Points where there is cover bring no more samples.
  const ResampledCloud again = resampler.extend(boxCloud(kBox, 20000, 0.005, 9));
  EXPECT_LT(static_cast<double>(again.size()), 1.05 * static_cast<double>(after.size()));
}

TEST_P(ResampleExtend, SourcesCountThroughTheClouds) {
  const PoseCloudData cloud = boxCloud(kBox, 6000, 0.005);
  const PoseCloudData first = slab(cloud, -1, 3);
  PoseCloudData second = slab(cloud, 3, 7);
  second.positions_m.insert(second.positions_m.begin(), Eigen::Vector3d(0, std::nan(""), 0));
  std::vector<Eigen::Vector3d> all = first.positions_m;
  all.insert(all.end(), second.positions_m.begin(), second.positions_m.end());
  CloudResampler resampler(config(200));
  begin(&resampler, first);
  const ResampledCloud after = resampler.extend(second);
  ASSERT_EQ(after.sources.size(), 400u);
  for (std::size_t i = 0; i < after.size(); ++i) {
    ASSERT_LT(after.sources[i], all.size());
    double nearest_m = 1e9;
    for (const Eigen::Vector3d& p : all) {
      if (p.allFinite()) nearest_m = std::min(nearest_m, (p - after.positions_m[i]).norm());
    }
    EXPECT_NEAR((all[after.sources[i]] - after.positions_m[i]).norm(), nearest_m, 1e-5);
  }
}

TEST_P(ResampleExtend, ManyTimes) {
  CloudResampler resampler(config(100));
  ResampledCloud last;
  std::size_t points = 0;
  for (int i = 0; i < 6; ++i) {
    const PoseCloudData part = slab(boxCloud(kBox, 20000, 0.005), i, i + 1.0);
    points += part.positions_m.size();
    const ResampledCloud now = i == 0 ? begin(&resampler, part) : resampler.extend(part);
    EXPECT_GE(now.size(), last.size() + 95u);
    EXPECT_LE(now.size(), last.size() + 100u);
    EXPECT_EQ(now.points_in, points);
    last = now;
  }
}

/// Where nothing has come samples stay, and hardly any come between them: all vertices are looked
/// at anew, and a few were passed over.
TEST_P(ResampleExtend, FewPointsInACornerLeaveTheRest) {
  const PoseCloudData cloud = boxCloud(kBox, 60000, 0.005);
  CloudResampler resampler(config(0, 0.12));
  const ResampledCloud before = begin(&resampler, cloud);
  PoseCloudData corner;
  for (int i = 0; i < 400; ++i) {
    corner.positions_m.emplace_back(0.5 + 0.02 * (i % 20), 0.5 + 0.02 * (i / 20), 0.5);
  }
  const ResampledCloud after = resampler.extend(corner);
  EXPECT_GT(after.size(), before.size() + 5);
  EXPECT_EQ(stayed(before, after), before.size());
  std::size_t elsewhere = 0;
  for (std::size_t i = before.size(); i < after.size(); ++i) {
    elsewhere += (after.positions_m[i] - Eigen::Vector3d(0.7, 0.7, 0.5)).norm() > 0.6 ? 1 : 0;
  }
  EXPECT_LE(elsewhere, before.size() / 500);
}

/// A sample far away lies in a cell many times as large as the finest, which points that come near
/// it change.
TEST_P(ResampleExtend, SamplesStayInCellsOfAllSizes) {
  const Eigen::Vector3d hall(60, 50, 12);
  CloudResampler resampler(config(1500));
  const ResampledCloud before =
      begin(&resampler, boxCloud(hall, 60000, 0.02), {makePolicy("range:min=3")});
  ASSERT_EQ(before.size(), 1500u);
  const ResampledCloud after = resampler.extend(boxCloud(hall, 6000, 0.02, 9));
  EXPECT_EQ(stayed(before, after), 1500u);
}

TEST_P(ResampleExtend, NothingMore) {
  const PoseCloudData cloud = boxCloud(kBox, 20000, 0.005);
  CloudResampler resampler(config(300));
  const ResampledCloud before = begin(&resampler, cloud);
  PoseCloudData nothing;
  const ResampledCloud after = resampler.extend(nothing);
  EXPECT_GT(after.size(), 500u);  // cells of the size chosen for 300 hold no 600
  EXPECT_EQ(stayed(before, after), 300u);
}

TEST_P(ResampleExtend, ThreadsGiveTheSameBytes) {
  const PoseCloudData cloud = boxCloud(kBox, 60000, 0.005);
  const Policies policies = {makePolicy("range:min=1")};
  ResampledCloud expected;
  for (const int threads : {1, 2, 4}) {
    ResampleConfig many = config(500);
    many.threads = threads;
    CloudResampler resampler(many);
    begin(&resampler, slab(cloud, -1, 3), policies);
    const ResampledCloud after = resampler.extend(slab(cloud, 3, 7));
    if (threads == 1) expected = after;
    EXPECT_TRUE(after.positions_m == expected.positions_m) << threads;
    EXPECT_TRUE(after.covering_radii == expected.covering_radii) << threads;
    EXPECT_TRUE(after.weights == expected.weights) << threads;
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, ResampleExtend,
                         testing::Combine(testing::Values("fast_marching", "flood"),
                                          testing::Bool()),
                         [](const auto& test_case) {
                           return std::get<0>(test_case.param) +
                                  (std::get<1>(test_case.param) ? "_more_to_come" : "");
                         });

}  // namespace
}  // namespace ladar_perception::test
