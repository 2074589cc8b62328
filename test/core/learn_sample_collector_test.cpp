// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "hand_model.h"
#include "ladar_perception/learn/sample_collector.h"
#include "terrain_scenes.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::handModel;
using Sizes = std::vector<std::size_t>;

TEST(LearnEvenShares, AllAlikeAsFarAsThereIsEnough) {
  EXPECT_EQ(evenShares({10, 10, 10}, 9), (Sizes{3, 3, 3}));
  EXPECT_EQ(evenShares({1, 10, 10}, 9), (Sizes{1, 4, 4}));
  EXPECT_EQ(evenShares({100, 2, 0, 4}, 20), (Sizes{14, 2, 0, 4}));
  EXPECT_EQ(evenShares({3, 4}, 100), (Sizes{3, 4}));
  EXPECT_EQ(evenShares({}, 5), (Sizes{}));
  // What does not divide goes to some, but all is given.
  const Sizes shares = evenShares({5, 5, 5}, 7);
  EXPECT_EQ(std::accumulate(shares.begin(), shares.end(), std::size_t{0}), 7u);
  EXPECT_EQ(evenShares({9, 9, 9}, 2), (Sizes{0, 1, 1}));
}

/// A pipeline that has seen the mixed scene at a place.
class LearnSampleCollector : public ::testing::Test {
 protected:
  explicit LearnSampleCollector() : pipeline_(wideConfig(), handModel()) {
    pipeline_.keepFeatures(true);
  }
  static TerrainConfig wideConfig() {
    TerrainConfig config;
    config.min_range_m = 0.0;
    return config;
  }
  /// Ground is class 1, the wire 3, leaves 2.
  void see(SampleCollector* collector, const Vector3d& place = Vector3d::Zero(), int seed = 1) {
    pipeline_.reset();
    const test::MixedScene scene(seed);
    test::processAt(&pipeline_, scene.points, place);
    std::vector<double> truth(scene.points.size(), 1.0);
    std::fill(truth.begin() + 20000, truth.begin() + 21000, 3.0);
    std::fill(truth.begin() + 21000, truth.end(), 2.0);
    collector->add(pipeline_, truth);
  }

  TerrainPipeline pipeline_;
};

TEST_F(LearnSampleCollector, TakesEveryVoxelOnceWithWhatTheClassifierSaw) {
  SampleCollector collector(3, 3, 100000, 1);
  see(&collector);
  std::vector<std::vector<float>> expected;
  pipeline_.map().forEachVoxel([&](const VoxelIndex& voxel, std::size_t slot) {
    // The wire is alone at its height.
    if (voxel.z < 10 || voxel.x > 40 || pipeline_.saliency(slot).points < 3) return;
    const float* values = pipeline_.features(slot);
    expected.emplace_back(values, values + 3);
  });
  const Samples samples = collector.samples(2);
  std::vector<std::vector<float>> taken;
  for (Eigen::Index i = 0; i < samples.values.cols(); ++i) {
    const Eigen::VectorXf column = samples.values.col(i).cast<float>();
    taken.emplace_back(column.begin(), column.end());
  }
  std::sort(expected.begin(), expected.end());
  std::sort(taken.begin(), taken.end());
  EXPECT_GT(taken.size(), 90u);
  EXPECT_EQ(taken, expected);
  const ClassCounts counts = collector.counts(2);
  EXPECT_EQ(counts.points, 1000u);
  EXPECT_EQ(counts.points_used, 1000u);
  EXPECT_EQ(counts.voxels, taken.size());
  EXPECT_EQ(counts.places, 2u);  // squares of 10 m; the wire crosses y = 0
}

TEST_F(LearnSampleCollector, IgnoresPointsWithoutTruthOrFeatures) {
  SampleCollector collector(3, 3, 1000, 1);
  const std::vector<Vector3d> points = {{3, 0, 0}, {3, 0.1, 0}, {3, 4, 0}, {500, 0, 0}};
  test::processAt(&pipeline_, points, Vector3d::Zero());
  collector.add(pipeline_, {1.0, 4.0, 0.0, 1.0});
  EXPECT_EQ(collector.counts(0).points, 2u);  // one with thin support, one outside the map
  EXPECT_EQ(collector.counts(0).points_used, 0u);
  EXPECT_EQ(collector.samples(0).size(), 0u);
  EXPECT_EQ(collector.counts(1).points, 0u);
}

TEST_F(LearnSampleCollector, InputsHaveEqualShares) {
  SampleCollector collector(3, 3, 60, 1);
  // The first input has seen ten times as much.
  collector.beginInput();
  for (int scan = 0; scan < 10; ++scan) {
    collector.beginFile();
    see(&collector, Vector3d::Zero(), scan);
  }
  const std::size_t places_of_first = collector.counts(0).places;
  collector.beginInput();
  collector.beginFile();
  see(&collector);
  const Samples samples = collector.samples(0);
  ASSERT_EQ(samples.size(), 60u);
  const auto first = std::count_if(samples.places.begin(), samples.places.end(),
                                   [&](std::size_t place) { return place < places_of_first; });
  EXPECT_EQ(first, 30);
  EXPECT_TRUE(std::is_sorted(samples.places.begin(), samples.places.end()));
}

TEST_F(LearnSampleCollector, PlacesHaveEqualShares) {
  // Ground over four squares of 10 m, of which the scene's middle is the corner of all.
  SampleCollector collector(3, 3, 200, 1);
  see(&collector);
  const Samples samples = collector.samples(0);
  std::map<std::size_t, int> counts;
  for (const std::size_t place : samples.places) ++counts[place];
  ASSERT_EQ(counts.size(), 4u);
  for (const auto& [place, count] : counts) EXPECT_EQ(count, 50) << place;
}

TEST_F(LearnSampleCollector, SameSeedSameSamples) {
  Eigen::MatrixXd values[3];
  for (int i = 0; i < 3; ++i) {
    SampleCollector collector(3, 3, 100, i < 2 ? 7 : 8);
    for (int scan = 0; scan < 4; ++scan) see(&collector, Vector3d(2.0 * scan, 0, 0), scan);
    values[i] = collector.samples(1).values;
    EXPECT_EQ(values[i].cols(), 100);
  }
  EXPECT_EQ(values[0], values[1]);
  EXPECT_NE(values[0], values[2]);
}

TEST_F(LearnSampleCollector, MemoryIsBoundedAndSamplesStayEven) {
  // Far more is offered than kept: it is thinned out many times.
  SampleCollector collector(3, 3, 40, 1);
  for (int scan = 0; scan < 30; ++scan) see(&collector, Vector3d(40.0 * scan, 0, 0), scan % 3);
  EXPECT_GT(collector.counts(0).voxels, 100000u);
  const Samples samples = collector.samples(0);
  EXPECT_EQ(samples.size(), 40u);
  const std::set<std::size_t> places(samples.places.begin(), samples.places.end());
  EXPECT_EQ(places.size(), 40u);  // there are 120 places: none gives two
}

}  // namespace
}  // namespace ladar_perception
