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

/// Exponents are the voxel's own, then by radius.
ClassifierModel modelOf(int classes, const std::vector<int>& radii,
                        const std::vector<double>& exponents,
                        const std::vector<double>& offsets = {}) {
  ClassifierModel model;
  model.features = {{Quantity::kScatter}};
  model.classes = test::randomClasses(classes, 1, 1);
  model.calibration.smoothing.radii_voxels = radii;
  model.calibration.smoothing.exponents = exponents;
  model.calibration.smoothing.offsets = offsets;
  return model;
}

/// Offsets for any number of classes, none equal to the next one's.
std::vector<double> someOffsets(int classes) {
  std::vector<double> offsets;
  for (int c = 0; c < classes; ++c) offsets.push_back(0.375 * (c * 5 % 7) - 1.0);
  return offsets;
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
        smoother_(LabelSmoother::make(classifier_, model_.calibration.smoothing, threads)),
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

  std::vector<Classification> label(const ColumnSet& columns,
                                    std::vector<float>* terms = nullptr) {
    std::vector<Classification> labels(map_.slotBound(), {77, -1.0F});
    smoother_->label(map_, columns, &pool_, &labels, terms);
    return labels;
  }
  std::vector<Classification> labelAll(std::vector<float>* terms = nullptr) {
    return label(all_, terms);
  }

  /// Whole posteriors of the voxel, then sums of them over the cubes, voxel by voxel.
  std::vector<std::vector<uint64_t>> sumsAround(const VoxelIndex& center) const {
    const std::vector<int>& radii = smoothing().radii_voxels;
    std::vector<std::vector<uint64_t>> sums(1 + radii.size(),
                                            std::vector<uint64_t>(model_.classes.size(), 0));
    for (const auto& [voxel, slot] : listVoxels(map_)) {
      if (posteriors_[slot].empty()) continue;
      const int distance = std::max({std::abs(voxel.x - center.x), std::abs(voxel.y - center.y),
                                     std::abs(voxel.z - center.z)});
      for (std::size_t t = 0; t < sums.size(); ++t) {
        if (distance > (t == 0 ? 0 : radii[t - 1])) continue;
        for (std::size_t c = 0; c < sums[t].size(); ++c) {
          sums[t][c] += test::wholePosterior(posteriors_[slot][c]);
        }
      }
    }
    return sums;
  }
  void expectRight(const std::vector<Classification>& labels, const std::vector<float>& terms,
                   int most_voxels = 300) const {
    const auto voxels = listVoxels(map_);
    const std::size_t stride = 1 + voxels.size() / most_voxels;
    for (std::size_t i = 0; i < voxels.size(); i += stride) {
      const auto& [voxel, slot] = voxels[i];
      const Classification& found = labels[slot];
      const auto sums = sumsAround(voxel);
      ASSERT_NO_FATAL_FAILURE(expectTerms(terms, slot, sums));
      if (posteriors_[slot].empty()) {
        ASSERT_EQ(found.label, kUnknownLabel);
        ASSERT_EQ(found.confidence, 0.0F);
        continue;
      }
      const Classification expected = test::smoothedClass(classifier_, smoothing(), sums);
      ASSERT_TRUE(test::same(found, expected))
          << i << ": " << +found.label << " at " << found.confidence << ", expected "
          << +expected.label << " at " << expected.confidence;
      ASSERT_NO_FATAL_FAILURE(expectProduct(found, sums));
    }
  }

 private:
  const Calibration::Smoothing& smoothing() const { return model_.calibration.smoothing; }
  static double share(const std::vector<uint64_t>& sums, std::size_t c) {
    const uint64_t total = std::accumulate(sums.begin(), sums.end(), uint64_t{0});
    const double exact = static_cast<double>(sums[c]) / std::max(static_cast<double>(total), 1.0);
    return std::max(exact, static_cast<double>(kLeastPosterior));
  }
  /// Without the classifier's own code and in double precision: products of powers.
  void expectProduct(const Classification& found,
                     const std::vector<std::vector<uint64_t>>& sums) const {
    double normalizer = 0.0;
    std::vector<double> products;
    for (std::size_t c = 0; c < model_.classes.size(); ++c) {
      products.push_back(smoothing().offsets.empty() ? 1.0 : std::exp(smoothing().offsets[c]));
      for (std::size_t t = 0; t < sums.size(); ++t) {
        products.back() *= std::pow(share(sums[t], c), smoothing().exponents[t]);
      }
      normalizer += products.back();
    }
    const double greatest = *std::max_element(products.begin(), products.end());
    ASSERT_NEAR(products[found.label - 1], greatest, 3e-5 * greatest);
    ASSERT_NEAR(found.confidence, greatest / normalizer, 5e-5);
  }
  void expectTerms(const std::vector<float>& terms, std::size_t slot,
                   const std::vector<std::vector<uint64_t>>& sums) const {
    const std::size_t classes = model_.classes.size();
    ASSERT_GE(terms.size(), (slot + 1) * sums.size() * classes);
    for (std::size_t t = 0; t < sums.size(); ++t) {
      for (std::size_t c = 0; c < classes; ++c) {
        const float term = terms[(slot * sums.size() + t) * classes + c];
        ASSERT_EQ(term, test::logShare(sums[t], c)) << "term " << t << ", class " << c;
        ASSERT_NEAR(term, std::log(share(sums[t], c)), 2e-6);
      }
    }
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

TEST_P(LabelSmoothers, MultiplyWhatVoxelAndCubesSay) {
  struct Rule {
    std::vector<int> radii;
    std::vector<double> exponents;
    bool has_offsets;
  };
  const Rule rules[] = {{{1}, {0.0, 1.0}, false},
                        {{3}, {0.5, 2.5}, true},
                        {{3, 8}, {0.2, 0.5, 1.0}, true},
                        {{8, 1}, {1.5, 0.0, 0.75}, false},
                        {{2, 7, 4, 4}, {0.3, 0.1, 0.6, 1.2, 0.4}, true}};
  for (const MapShape& shape : {MapShape{25, 19, 12}, MapShape{3, 40, 70}, MapShape{1, 1, 1},
                                MapShape{30, 2, 200}, MapShape{66, 5, 4}}) {
    for (const Rule& rule : rules) {
      const auto offsets = rule.has_offsets ? someOffsets(GetParam()) : std::vector<double>();
      SmoothedMap smoothed(shape, modelOf(GetParam(), rule.radii, rule.exponents, offsets));
      smoothed.fillAtRandom(std::max(shape.nx * shape.ny * shape.nz / 4, 1));
      smoothed.keepAtRandom(4);
      std::vector<float> terms;
      const std::vector<Classification> labels = smoothed.labelAll(&terms);
      ASSERT_NO_FATAL_FAILURE(smoothed.expectRight(labels, terms, 60))
          << test::shapeName(shape) << ", " << testing::PrintToString(rule.radii);
    }
  }
}

TEST_P(LabelSmoothers, FollowAMapThatScrollsAndChanges) {
  const ClassifierModel model = modelOf(GetParam(), {1, 3}, {0.5, 1.5, 0.25},
                                        someOffsets(GetParam()));
  SmoothedMap smoothed({20, 23, 15}, model, 3);
  TestRandom random(4);
  VoxelIndex min = smoothed.map().minCorner();
  std::vector<float> terms;
  for (int step = 0; step < 12; ++step) {
    min.x += static_cast<int32_t>(random.integer(-6, 6));
    min.y += static_cast<int32_t>(random.integer(-6, 6));
    min.z += static_cast<int32_t>(random.integer(-2, 2));
    smoothed.map().scrollTo(min);
    smoothed.fillAtRandom(step % 3 * 400);
    smoothed.keepAtRandom(step % 4);
    const std::vector<Classification> labels = smoothed.labelAll(&terms);
    ASSERT_NO_FATAL_FAILURE(smoothed.expectRight(labels, terms, 100)) << "step " << step;
  }
}

TEST_P(LabelSmoothers, GiveTheSameBitsForAnyNumberOfThreads) {
  const ClassifierModel model = modelOf(GetParam(), {4, 6}, {0.3, 1.2, 0.7});
  std::vector<Classification> expected;
  for (const int threads : {1, 2, 3, 5, 16}) {
    SmoothedMap smoothed({40, 37, 10}, model, threads, 6);
    smoothed.fillAtRandom(4000);
    smoothed.keepAtRandom(5);
    const std::vector<Classification> labels = smoothed.labelAll();
    if (threads == 1) expected = labels;
    ASSERT_EQ(labels.size(), expected.size());
    for (std::size_t slot = 0; slot < labels.size(); ++slot) {
      ASSERT_TRUE(test::same(labels[slot], expected[slot])) << threads << " threads";
    }
  }
}

TEST_P(LabelSmoothers, LabelTheColumnsAskedForAndNoOthers) {
  SmoothedMap smoothed({33, 21, 9}, modelOf(GetParam(), {3, 5}, {0.2, 0.5, 1.0}), 2);
  smoothed.fillAtRandom(1500);
  smoothed.keepAtRandom(6);
  const std::vector<Classification> all = smoothed.labelAll();
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
    SmoothedMap smoothed({9, 9, 9}, modelOf(classes, {8}, {0.0, 1.0}));
    const VoxelIndex& min = smoothed.map().minCorner();
    for (int i = 0; i < 9; ++i) smoothed.insert({min.x + i, min.y + 4, min.z + i});
    const auto voxels = listVoxels(smoothed.map());
    std::vector<float> p(classes, 0.4F / static_cast<float>(classes - 1));
    p[1] = 0.6F;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      smoothed.set(voxels[i].second, i == 3 ? p : std::vector<float>());
    }
    smoothed.keep();
    std::vector<Classification> labels = smoothed.labelAll();
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const Classification& found = labels[voxels[i].second];
      EXPECT_EQ(found.label, i == 3 ? 2 : kUnknownLabel);
      EXPECT_NEAR(found.confidence, i == 3 ? 0.6 : 0.0, 1e-4);
    }
    // Of none is anything known.
    smoothed.set(voxels[3].second, {});
    smoothed.keep();
    labels = smoothed.labelAll();
    for (const auto& [voxel, slot] : voxels) {
      EXPECT_TRUE(test::same(labels[slot], Classification()));
    }
  }
}

TEST(LabelSmoother, TheManyOutvoteTheOne) {
  SmoothedMap smoothed({5, 5, 5}, modelOf(3, {1}, {0.0, 1.0}));
  const VoxelIndex& min = smoothed.map().minCorner();
  for (int x = 0; x < 5; ++x) smoothed.insert({min.x + x, min.y, min.z});
  for (const auto& [voxel, slot] : listVoxels(smoothed.map())) {
    const bool is_middle = voxel.x == min.x + 2;
    smoothed.set(slot, is_middle ? std::vector<float>{0.1F, 0.2F, 0.7F}
                                 : std::vector<float>{0.9F, 0.1F, 0.0F});
  }
  smoothed.keep();
  const auto labels = smoothed.labelAll();
  for (const auto& [voxel, slot] : listVoxels(smoothed.map())) {
    const int x = voxel.x - min.x;
    EXPECT_EQ(labels[slot].label, 1) << x;
    const double expected = x == 0 || x == 4 ? 0.9 : 1.9 / 3;
    EXPECT_NEAR(labels[slot].confidence, expected, 1e-4) << x;
  }
}

TEST(LabelSmoother, OffsetsAndOwnPosteriorsCanTurnTheVote) {
  for (const bool has_offset : {false, true}) {
    for (const double own : {0.0, 4.0}) {
      const std::vector<double> offsets = {0.0, has_offset ? 5.0 : 0.0, 0.0};
      SmoothedMap smoothed({5, 5, 5}, modelOf(3, {1}, {own, 1.0}, offsets));
      const VoxelIndex& min = smoothed.map().minCorner();
      for (int x = 0; x < 3; ++x) smoothed.insert({min.x + x, min.y, min.z});
      std::size_t middle = 0;
      for (const auto& [voxel, slot] : listVoxels(smoothed.map())) {
        const bool is_middle = voxel.x == min.x + 1;
        if (is_middle) middle = slot;
        smoothed.set(slot, is_middle ? std::vector<float>{0.2F, 0.2F, 0.6F}
                                     : std::vector<float>{0.8F, 0.2F, 0.0F});
      }
      smoothed.keep();
      // Means are (0.6, 0.2, 0.2); 3^4 by its own to 3 by its neighbours, e^5 to all of them.
      const double product[3] = {0.6 * std::pow(0.2, own),
                                 0.2 * std::pow(0.2, own) * std::exp(offsets[1]),
                                 0.2 * std::pow(0.6, own)};
      const double* greatest = std::max_element(product, product + 3);
      const Classification found = smoothed.labelAll()[middle];
      EXPECT_EQ(found.label, has_offset ? 2 : own > 0.0 ? 3 : 1);
      EXPECT_EQ(found.label, 1 + (greatest - product));
      EXPECT_NEAR(found.confidence, *greatest / (product[0] + product[1] + product[2]), 1e-3);
    }
  }
}

TEST(LabelSmoother, TermsAreWrittenForTheColumnsAskedForAndChangeNothing) {
  const ClassifierModel model = modelOf(5, {2, 4}, {0.2, 0.5, 1.0});
  SmoothedMap smoothed({12, 9, 6}, model, 2);
  smoothed.fillAtRandom(200);
  smoothed.keepAtRandom(5);
  ColumnSet some;
  some.resize(12, 9);
  for (int x = 0; x < 12; x += 2) some.add(x, x % 9);
  constexpr std::size_t kTerms = 3 * 5;
  std::vector<float> terms(smoothed.map().slotBound() * kTerms, 77.0F);
  const std::vector<Classification> with = smoothed.label(some, &terms);
  const std::vector<Classification> without = smoothed.label(some);
  const VoxelIndex& min = smoothed.map().minCorner();
  for (const auto& [voxel, slot] : listVoxels(smoothed.map())) {
    ASSERT_TRUE(test::same(with[slot], without[slot]));
    const bool is_asked = some.contains(voxel.x - min.x, voxel.y - min.y);
    for (std::size_t i = 0; i < kTerms; ++i) {
      ASSERT_EQ(terms[slot * kTerms + i] == 77.0F, !is_asked);
    }
  }
}

TEST(LabelSmoother, SaysItsCalibrationAndItsMemory) {
  ClassifierModel model = modelOf(5, {2, 6, 3}, {0.1, 0.2, 0.3, 0.4});
  model.calibration.smoothing.temperature = 3.5;
  SmoothedMap smoothed({10, 10, 10}, model);
  EXPECT_EQ(smoothed.smoother().reach(), 6);
  EXPECT_EQ(smoothed.smoother().temperature(), 3.5F);
  smoothed.smoother().resize(1000);
  EXPECT_GE(smoothed.smoother().memoryBytes(), 1000 * 8 * sizeof(uint16_t));
}

}  // namespace
}  // namespace ladar_perception
