// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "ladar_perception/classify/label_smoother.h"
#include "map_oracle.h"
#include "posterior_average.h"
#include "terrain_comparisons.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

using test::listVoxels;
using test::TestRandom;

constexpr int kSize = FeatureBlock::kSize;

ClassifierModel modelOf(int classes, int radius, double sharpness) {
  ClassifierModel model;
  model.features = {{Quantity::kScatter}};
  model.classes = test::randomClasses(classes, 1, 1);
  model.calibration.smoothing_radius_voxels = radius;
  model.calibration.smoothing_sharpness = sharpness;
  return model;
}

/// A map with posteriors, and the smoother they were given to.
class SmoothedMap {
 public:
  SmoothedMap(const MapShape& shape, const ClassifierModel& model, int threads = 1,
              uint64_t seed = 1)
      : model_(model),
        classifier_(model_),
        map_(shape, 1000),
        pool_(threads),
        smoother_(LabelSmoother::make(classifier_, model_.calibration, threads)),
        random_(seed) {
    map_.scrollTo({-5, 7, -11});
    all_.assignAll(shape.nx, shape.ny);
  }

  VoxelMap& map() { return map_; }
  LabelSmoother& smoother() { return *smoother_; }
  const std::vector<float>& posterior(std::size_t slot) const { return posteriors_[slot]; }

  void fillAtRandom(int voxels) {
    const VoxelIndex& min = map_.minCorner();
    const auto within = [&](int32_t from, int n) {
      return static_cast<int32_t>(random_.integer(from, int64_t{from} + n - 1));
    };
    for (int i = 0; i < voxels; ++i) {
      const int32_t x = within(min.x, map_.shape().nx);
      const int32_t y = within(min.y, map_.shape().ny);
      insert({x, y, within(min.z, map_.shape().nz)});
    }
  }
  void insert(const VoxelIndex& voxel) {
    CellId cell = 0;
    map_.insert(test::pointIn(voxel), &cell);
  }
  /// Any posteriors for every voxel; of one in `unknown_of` nothing is known.
  void keepAtRandom(int unknown_of) {
    for (const auto& [voxel, slot] : listVoxels(map_)) {
      std::vector<float> p(model_.classes.size());
      for (float& part : p) part = static_cast<float>(std::pow(random_.real(0.0, 1.0), 4.0));
      const float sum = std::accumulate(p.begin(), p.end(), 0.0F);
      for (float& part : p) part /= sum;
      if (unknown_of > 0 && random_.integer(1, unknown_of) == 1) p.clear();
      set(slot, p);
    }
    keep();
  }
  /// Nothing in `p`: unknown.
  void set(std::size_t slot, const std::vector<float>& p) {
    posteriors_.resize(map_.slotBound());
    posteriors_[slot] = p;
  }
  /// Gives the smoother all posteriors, in blocks of any size.
  void keep() {
    smoother_->resize(map_.slotBound());
    const auto voxels = listVoxels(map_);
    for (std::size_t first = 0; first < voxels.size();) {
      const auto count = std::min<std::size_t>(random_.integer(1, kSize), voxels.size() - first);
      PosteriorBlock block;
      uint32_t slots[kSize];
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t slot = voxels[first + i].second;
        const std::vector<float>& p = posteriors_[slot];
        slots[i] = static_cast<uint32_t>(slot);
        block.known[i] = p.empty() ? 0 : 1;
        for (std::size_t c = 0; c < model_.classes.size(); ++c) {
          // What an unknown one's probabilities are must not matter.
          block.probability[c][i] = p.empty() ? 0.9F : p[c];
        }
      }
      smoother_->keep(block, slots, static_cast<int>(count));
      first += count;
    }
  }

  std::vector<Classification> label(const ColumnSet& columns) {
    std::vector<Classification> labels(map_.slotBound(), {77, -1.0F});
    smoother_->label(map_, columns, &pool_, &labels);
    return labels;
  }
  std::vector<Classification> label() { return label(all_); }

  /// Sums of whole posteriors over the cube, voxel by voxel.
  std::vector<uint64_t> sumsAround(const VoxelIndex& center) const {
    std::vector<uint64_t> sums(model_.classes.size(), 0);
    const int r = model_.calibration.smoothing_radius_voxels;
    for (const auto& [voxel, slot] : listVoxels(map_)) {
      const bool is_near = std::abs(voxel.x - center.x) <= r && std::abs(voxel.y - center.y) <= r &&
                           std::abs(voxel.z - center.z) <= r;
      if (!is_near || posteriors_[slot].empty()) continue;
      for (std::size_t c = 0; c < sums.size(); ++c) {
        sums[c] += test::wholePosterior(posteriors_[slot][c]);
      }
    }
    return sums;
  }
  void expectRight(const std::vector<Classification>& labels, int most_voxels = 300) const {
    const auto voxels = listVoxels(map_);
    const std::size_t stride = 1 + voxels.size() / most_voxels;
    for (std::size_t i = 0; i < voxels.size(); i += stride) {
      const Classification& found = labels[voxels[i].second];
      if (posteriors_[voxels[i].second].empty()) {
        ASSERT_EQ(found.label, kUnknownLabel);
        ASSERT_EQ(found.confidence, 0.0F);
        continue;
      }
      const std::vector<uint64_t> sums = sumsAround(voxels[i].first);
      const Classification expected = test::smoothedClass(classifier_, model_.calibration, sums);
      ASSERT_TRUE(test::same(found, expected))
          << i << ": " << +found.label << " at " << found.confidence << ", expected "
          << +expected.label << " at " << expected.confidence;
      ASSERT_NO_FATAL_FAILURE(expectPower(found, sums));
    }
  }

 private:
  /// The same in double precision and without the classifier's own code.
  void expectPower(const Classification& found, const std::vector<uint64_t>& sums) const {
    const double total =
        static_cast<double>(std::accumulate(sums.begin(), sums.end(), uint64_t{0}));
    double normalizer = 0.0;
    std::vector<double> powers;
    for (const uint64_t sum : sums) {
      powers.push_back(
          std::pow(static_cast<double>(sum) / total, model_.calibration.smoothing_sharpness));
      normalizer += powers.back();
    }
    const double greatest = *std::max_element(powers.begin(), powers.end());
    ASSERT_NEAR(powers[found.label - 1], greatest, 1e-5 * greatest);
    ASSERT_NEAR(found.confidence, greatest / normalizer, 3e-5);
  }

  ClassifierModel model_;
  Classifier classifier_;
  VoxelMap map_;
  ThreadPool pool_;
  std::unique_ptr<LabelSmoother> smoother_;
  TestRandom random_;
  ColumnSet all_;
  std::vector<std::vector<float>> posteriors_;  // by slot
};

class LabelSmoothers : public testing::TestWithParam<int> {};

TEST_P(LabelSmoothers, AverageOverTheCube) {
  for (const MapShape& shape : {MapShape{25, 19, 12}, MapShape{3, 40, 70}, MapShape{1, 1, 1},
                                MapShape{30, 2, 200}, MapShape{66, 5, 4}}) {
    for (const int radius : {1, 3, 8}) {
      for (const double sharpness : {1.0, 2.5}) {
        SmoothedMap smoothed(shape, modelOf(GetParam(), radius, sharpness));
        smoothed.fillAtRandom(std::max(shape.nx * shape.ny * shape.nz / 4, 1));
        smoothed.keepAtRandom(4);
        ASSERT_NO_FATAL_FAILURE(smoothed.expectRight(smoothed.label(), 60))
            << test::shapeName(shape) << ", radius " << radius;
      }
    }
  }
}

TEST_P(LabelSmoothers, FollowAMapThatScrollsAndChanges) {
  SmoothedMap smoothed({20, 23, 15}, modelOf(GetParam(), 2, 1.5), 3);
  TestRandom random(4);
  VoxelIndex min = smoothed.map().minCorner();
  for (int step = 0; step < 12; ++step) {
    min.x += static_cast<int32_t>(random.integer(-6, 6));
    min.y += static_cast<int32_t>(random.integer(-6, 6));
    min.z += static_cast<int32_t>(random.integer(-2, 2));
    smoothed.map().scrollTo(min);
    smoothed.fillAtRandom(step % 3 * 400);
    smoothed.keepAtRandom(step % 4);
    ASSERT_NO_FATAL_FAILURE(smoothed.expectRight(smoothed.label(), 100)) << "step " << step;
  }
}

TEST_P(LabelSmoothers, GiveTheSameBitsForAnyNumberOfThreads) {
  const ClassifierModel model = modelOf(GetParam(), 4, 1.2);
  std::vector<Classification> expected;
  for (const int threads : {1, 2, 3, 5, 16}) {
    SmoothedMap smoothed({40, 37, 10}, model, threads, 6);
    smoothed.fillAtRandom(4000);
    smoothed.keepAtRandom(5);
    const std::vector<Classification> labels = smoothed.label();
    if (threads == 1) expected = labels;
    ASSERT_EQ(labels.size(), expected.size());
    for (std::size_t slot = 0; slot < labels.size(); ++slot) {
      ASSERT_TRUE(test::same(labels[slot], expected[slot])) << threads << " threads";
    }
  }
}

TEST_P(LabelSmoothers, LabelTheColumnsAskedForAndNoOthers) {
  SmoothedMap smoothed({33, 21, 9}, modelOf(GetParam(), 3, 1.0), 2);
  smoothed.fillAtRandom(1500);
  smoothed.keepAtRandom(6);
  const std::vector<Classification> all = smoothed.label();
  TestRandom random(8);
  for (const int columns : {0, 1, 5, 100}) {
    ColumnSet some;
    some.resize(33, 21);
    for (int i = 0; i < columns; ++i) {
      const auto x = static_cast<int>(random.integer(0, 32));
      some.add(x, static_cast<int>(random.integer(0, 20)));
    }
    const std::vector<Classification> labels = smoothed.label(some);
    const VoxelIndex& min = smoothed.map().minCorner();
    for (const auto& [voxel, slot] : listVoxels(smoothed.map())) {
      const bool is_asked = some.contains(voxel.x - min.x, voxel.y - min.y);
      ASSERT_TRUE(test::same(labels[slot], is_asked ? all[slot] : Classification{77, -1.0F}));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Classes, LabelSmoothers, testing::Values(2, 4, 5, 8, 9, 16),
                         testing::PrintToStringParamName());

TEST(LabelSmoother, UnknownVoxelsStayUnknownAndGiveNothing) {
  for (const int classes : {3, 16}) {
    SmoothedMap smoothed({9, 9, 9}, modelOf(classes, 8, 1.0));
    const VoxelIndex& min = smoothed.map().minCorner();
    for (int i = 0; i < 9; ++i) smoothed.insert({min.x + i, min.y + 4, min.z + i});
    const auto voxels = listVoxels(smoothed.map());
    std::vector<float> p(classes, 0.4F / static_cast<float>(classes - 1));
    p[1] = 0.6F;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      smoothed.set(voxels[i].second, i == 3 ? p : std::vector<float>());
    }
    smoothed.keep();
    std::vector<Classification> labels = smoothed.label();
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const Classification& found = labels[voxels[i].second];
      EXPECT_EQ(found.label, i == 3 ? 2 : kUnknownLabel);
      EXPECT_NEAR(found.confidence, i == 3 ? 0.6 : 0.0, 1e-4);
    }
    // Of none is anything known.
    smoothed.set(voxels[3].second, {});
    smoothed.keep();
    labels = smoothed.label();
    for (const auto& [voxel, slot] : voxels) {
      EXPECT_TRUE(test::same(labels[slot], Classification()));
    }
  }
}

TEST(LabelSmoother, TheManyOutvoteTheOne) {
  SmoothedMap smoothed({5, 5, 5}, modelOf(3, 1, 1.0));
  const VoxelIndex& min = smoothed.map().minCorner();
  for (int x = 0; x < 5; ++x) smoothed.insert({min.x + x, min.y, min.z});
  for (const auto& [voxel, slot] : listVoxels(smoothed.map())) {
    const bool is_middle = voxel.x == min.x + 2;
    smoothed.set(slot, is_middle ? std::vector<float>{0.1F, 0.2F, 0.7F}
                                 : std::vector<float>{0.9F, 0.1F, 0.0F});
  }
  smoothed.keep();
  const auto labels = smoothed.label();
  for (const auto& [voxel, slot] : listVoxels(smoothed.map())) {
    const int x = voxel.x - min.x;
    EXPECT_EQ(labels[slot].label, 1) << x;
    const double expected = x == 0 || x == 4 ? 0.9 : 1.9 / 3;
    EXPECT_NEAR(labels[slot].confidence, expected, 1e-4) << x;
  }
}

TEST(LabelSmoother, SaysItsCalibrationAndItsMemory) {
  ClassifierModel model = modelOf(5, 6, 1.0);
  model.calibration.smoothing_temperature = 3.5;
  SmoothedMap smoothed({10, 10, 10}, model);
  EXPECT_EQ(smoothed.smoother().radius(), 6);
  EXPECT_EQ(smoothed.smoother().temperature(), 3.5F);
  smoothed.smoother().resize(1000);
  EXPECT_GE(smoothed.smoother().memoryBytes(), 1000 * 8 * sizeof(uint16_t));
}

}  // namespace
}  // namespace ladar_perception
