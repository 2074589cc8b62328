// SPDX-License-Identifier: BSD-3-Clause
// From sums to classes, whatever is compiled once per vector level gives the same bits on all.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ladar_perception/classify/classifier.h"
#include "ladar_perception/saliency/features.h"
#include "support_volumes.h"
#include "terrain_comparisons.h"
#include "vector_levels.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

using test::areFinite;
using test::handModel;
using test::kVectorLevels;
using test::randomModel;
using test::sameBits;
using test::SupportVolume;
using test::TestRandom;
using test::VectorLevels;
using test::VolumeKind;
using test::VolumeMaker;

constexpr double kStep_m = 0.1 / static_cast<double>(kStepsPerVoxel);
constexpr int kSize = kSaliencyBlock;

/// Volumes that fill a block, or part of it.
struct Block {
  std::vector<Moments> sums;
  std::vector<VoxelIndex> voxels;
};

Block blockOf(const std::vector<SupportVolume>& volumes) {
  Block block;
  for (const SupportVolume& volume : volumes) {
    block.sums.push_back(volume.sum);
    block.voxels.push_back(volume.voxel);
  }
  return block;
}

/// One block of every kind of volume, mixed ones of all sizes and one of nothing.
std::vector<Block> someBlocks() {
  TestRandom random(5);
  VolumeMaker maker(&random);
  std::vector<Block> blocks = {Block()};
  for (int kind = 0; kind < test::kVolumeKinds; ++kind) {
    std::vector<SupportVolume> volumes;
    for (int i = 0; i < kSize; ++i) volumes.push_back(maker.make(static_cast<VolumeKind>(kind)));
    blocks.push_back(blockOf(volumes));
  }
  for (int i = 0; i < 150; ++i) {
    const auto count = static_cast<int>(random.integer(1, kSize));
    blocks.push_back(blockOf(maker.makeMany(i % 3 == 0 ? kSize : count)));
  }
  return blocks;
}

std::vector<SaliencyBlock> saliencyBlocks(const std::vector<Block>& blocks) {
  std::vector<SaliencyBlock> saliencies(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    saliencyOfBlock(blocks[i].sums.data(), blocks[i].voxels.data(),
                    static_cast<int>(blocks[i].sums.size()), kStep_m, &saliencies[i]);
  }
  return saliencies;
}

/// Every quantity of every volume.
std::vector<float> allFeatureValues(const std::vector<SaliencyBlock>& blocks) {
  std::vector<float> all;
  for (const SaliencyBlock& block : blocks) {
    for (const QuantityInfo& info : allQuantities()) {
      if (isOfColumns(info.quantity)) continue;
      float values[kSize];
      featureValues(info.quantity, block, values);
      all.insert(all.end(), values, values + kSize);
    }
  }
  return all;
}

/// Every quantity of columns, of numbers small, great and negative.
std::vector<float> allColumnFeatureValues() {
  TestRandom random(3);
  std::vector<float> all;
  for (int round = 0; round < 100; ++round) {
    int32_t numbers[kSize];
    for (int32_t& number : numbers) {
      const int64_t greatest = int64_t{1} << random.integer(0, 30);
      number = static_cast<int32_t>(random.integer(-greatest / 4, greatest));
    }
    for (const QuantityInfo& info : allQuantities()) {
      if (!isOfColumns(info.quantity)) continue;
      float values[kSize];
      columnFeatureValues(info.quantity, numbers, 0.1 * (1 + round % 5), values);
      all.insert(all.end(), values, values + kSize);
    }
  }
  return all;
}

TEST_P(VectorLevels, SaliencyOfAnyVolumeIsTheSame) {
  const std::vector<Block> blocks = someBlocks();
  const auto run = [&] { return saliencyBlocks(blocks); };
  EXPECT_TRUE(sameBits(atBaseline(run), atLevel(run)));
}

TEST_P(VectorLevels, FeaturesOfAnyVolumeAreTheSame) {
  const std::vector<SaliencyBlock> saliencies = saliencyBlocks(someBlocks());
  const auto run = [&] { return allFeatureValues(saliencies); };
  const std::vector<float> expected = atBaseline(run);
  EXPECT_TRUE(sameBits(expected, atLevel(run)));
  EXPECT_TRUE(areFinite(expected));
}

TEST_P(VectorLevels, FeaturesOfColumnsAreTheSame) {
  const auto run = [] { return allColumnFeatureValues(); };
  const std::vector<float> expected = atBaseline(run);
  EXPECT_TRUE(sameBits(expected, atLevel(run)));
  EXPECT_TRUE(areFinite(expected));
}

/// Three classes on all quantities of support volumes, each a mixture with correlations.
ClassifierModel fullModel() {
  ClassifierModel model = handModel();
  model.features.clear();
  for (const QuantityInfo& info : allQuantities()) {
    if (!isOfColumns(info.quantity)) model.features.push_back({info.quantity});
  }
  const auto features = static_cast<Eigen::Index>(model.features.size());
  TestRandom random(8);
  for (ModelClass& model_class : model.classes) {
    model_class.prior = random.real(0.1, 1.0);
    model_class.mixture.resize(3);
    for (GaussianComponent& component : model_class.mixture) {
      component.weight = 1.0 / 3;
      component.mean = Eigen::VectorXd::Zero(features);
      Eigen::MatrixXd root = Eigen::MatrixXd::Identity(features, features) * 0.2;
      for (Eigen::Index i = 0; i < features; ++i) {
        component.mean[i] = random.real(0.0, 1.0);
        for (Eigen::Index j = 0; j < i; ++j) root(i, j) = random.real(-0.1, 0.1);
      }
      component.covariance = root * root.transpose();
    }
  }
  return model;
}

/// Models of all sizes, on what is of support volumes.
std::vector<ClassifierModel> someModels() {
  std::vector<ClassifierModel> models = {handModel(), fullModel()};
  for (const int classes : {2, 8, 16}) {
    models.push_back(randomModel({}, {"saliency", "log_points", "scatter_ratio"}, classes));
  }
  return models;
}

std::vector<FeatureBlock> featureBlocks(const ClassifierModel& model) {
  std::vector<FeatureBlock> blocks;
  for (const SaliencyBlock& block : saliencyBlocks(someBlocks())) {
    blocks.emplace_back(static_cast<int>(model.features.size()));
    for (std::size_t f = 0; f < model.features.size(); ++f) {
      featureValues(model.features[f].quantity, block, blocks.back().row(static_cast<int>(f)));
    }
  }
  return blocks;
}

TEST_P(VectorLevels, PosteriorsOfAnyVolumeAreTheSameAndFinite) {
  for (const ClassifierModel& model : someModels()) {
    const Classifier classifier(model);
    const std::vector<FeatureBlock> blocks = featureBlocks(model);
    for (const float temperature : {0.001F, 1.0F, 2.5F, 1000.0F}) {
      const auto run = [&] {
        std::vector<float> all;
        const auto keep = [&](const PosteriorBlock& posterior) {
          for (std::size_t c = 0; c < classifier.classes(); ++c) {
            const float* p = posterior.probability[c];
            all.insert(all.end(), p, p + kSize);
          }
        };
        std::vector<float> offsets(classifier.classes(), -1.25F);
        offsets.front() = 3.5F;
        for (const FeatureBlock& features : blocks) {
          PosteriorBlock posterior;
          classifier.posteriors(features, temperature, nullptr, &posterior);
          keep(posterior);
          classifier.posteriors(features, temperature, offsets.data(), &posterior);
          keep(posterior);
          // Probabilities are logarithms of others as good as any.
          classifier.normalize(&posterior);
          keep(posterior);
        }
        return all;
      };
      const std::vector<float> expected = atBaseline(run);
      ASSERT_TRUE(sameBits(expected, atLevel(run)));
      ASSERT_TRUE(areFinite(expected));
    }
  }
}

TEST_P(VectorLevels, ClassificationOfAnyVolumeIsTheSame) {
  for (const ClassifierModel& model : someModels()) {
    const Classifier classifier(model);
    const std::vector<FeatureBlock> blocks = featureBlocks(model);
    const auto run = [&] {
      std::vector<Classification> all;
      for (const FeatureBlock& features : blocks) {
        Classification classified[kSize];
        classifier.classify(features, kSize, classified);
        all.insert(all.end(), classified, classified + kSize);
      }
      return all;
    };
    const std::vector<Classification> expected = atBaseline(run);
    const std::vector<Classification> found = atLevel(run);
    ASSERT_EQ(expected.size(), found.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_TRUE(test::same(expected[i], found[i])) << i;
      ASSERT_GT(found[i].confidence, 0.0F) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, VectorLevels, testing::ValuesIn(kVectorLevels),
                         [](const auto& level) { return vectorLevelName(level.param); });

}  // namespace
}  // namespace ladar_perception
