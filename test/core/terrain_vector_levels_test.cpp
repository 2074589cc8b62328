// SPDX-License-Identifier: BSD-3-Clause
// Everything that is compiled once per vector level gives the same bits on all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "hand_model.h"
#include "ladar_perception/saliency/features.h"
#include "ladar_perception/terrain/terrain_pipeline.h"
#include "support_volumes.h"
#include "terrain_comparisons.h"
#include "terrain_recomputation.h"
#include "terrain_scenes.h"
#include "vector_level_limit.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::handModel;
using test::kVectorLevels;
using test::MixedScene;
using test::processAt;
using test::SupportVolume;
using test::TestRandom;
using test::VectorLevelLimit;
using test::VolumeKind;
using test::VolumeMaker;

constexpr double kStep_m = 0.1 / static_cast<double>(kStepsPerVoxel);
constexpr int kSize = kSaliencyBlock;

class VectorLevels : public testing::TestWithParam<VectorLevel> {
 protected:
  void SetUp() override {
    if (GetParam() > bestVectorLevel()) {
      GTEST_SKIP() << "this CPU has no " << vectorLevelName(GetParam());
    }
  }
  /// What `compute` gives at the baseline, and at the level of the test.
  template <typename Compute>
  auto atBaseline(const Compute& compute) const {
    const VectorLevelLimit limit(VectorLevel::kBaseline);
    return compute();
  }
  template <typename Compute>
  auto atLevel(const Compute& compute) const {
    const VectorLevelLimit limit(GetParam());
    EXPECT_EQ(vectorLevel(), GetParam());
    return compute();
  }
};

/// Everything a pipeline said, scan by scan and voxel by voxel.
struct PipelineRecord {
  std::vector<SaliencyF> saliencies;
  std::vector<Classification> classifications;
  std::vector<PointLabel> labels;
  std::vector<Moments> moments;
  std::vector<std::size_t> updated_voxels;
};

PipelineRecord drive(const TerrainConfig& config) {
  TerrainPipeline pipeline(config, test::modelFor(config));
  PipelineRecord record;
  const Vector3d places[] = {{0, 0, 0}, {0.7, -0.3, 0.1}, {0.7, -0.3, 0.1}, {1e6, 1e6, -300}};
  for (int scan = 0; scan < 4; ++scan) {
    const MixedScene scene(scan);
    processAt(&pipeline, scene.points, places[scan]);
    pipeline.map().forEachVoxel([&](const VoxelIndex& /*voxel*/, std::size_t slot) {
      record.saliencies.push_back(pipeline.saliency(slot));
      record.classifications.push_back(pipeline.classification(slot));
      record.moments.push_back(pipeline.map().record(slot));
    });
    const auto& labels = pipeline.pointLabels();
    record.labels.insert(record.labels.end(), labels.begin(), labels.end());
    record.updated_voxels.push_back(pipeline.report().updated_voxels);
  }
  return record;
}

void expectSame(const PipelineRecord& a, const PipelineRecord& b) {
  ASSERT_FALSE(a.saliencies.empty());
  ASSERT_EQ(a.updated_voxels, b.updated_voxels);
  ASSERT_EQ(a.moments == b.moments, true);
  ASSERT_EQ(a.saliencies.size(), b.saliencies.size());
  for (std::size_t i = 0; i < a.saliencies.size(); ++i) {
    ASSERT_NO_FATAL_FAILURE(test::expectSame(a.saliencies[i], b.saliencies[i])) << i;
    ASSERT_TRUE(test::same(a.classifications[i], b.classifications[i])) << i;
  }
  ASSERT_EQ(a.labels.size(), b.labels.size());
  for (std::size_t i = 0; i < a.labels.size(); ++i) {
    ASSERT_EQ(a.labels[i].label, b.labels[i].label) << i;
    ASSERT_EQ(a.labels[i].confidence, b.labels[i].confidence) << i;
    ASSERT_EQ(a.labels[i].rgb, b.labels[i].rgb) << i;
  }
}

TEST_P(VectorLevels, APipelineSaysTheSame) {
  const auto run = [] { return drive({}); };
  expectSame(atBaseline(run), atLevel(run));
}

TEST_P(VectorLevels, APipelineWithAKernelThatForgetsSaysTheSame) {
  const auto run = [] {
    TerrainConfig config;
    config.support_kernel = "gaussian";
    config.forget_after_scans = 2;
    return drive(config);
  };
  expectSame(atBaseline(run), atLevel(run));
}

TEST_P(VectorLevels, APipelineOfATallMapWithThreadsSaysTheSame) {
  const auto run = [] {
    TerrainConfig config;
    config.map_size_z_m = 7.0;
    config.support_radius_voxels = 2;
    config.threads = 3;
    return drive(config);
  };
  expectSame(atBaseline(run), atLevel(run));
}

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

/// Every feature of every volume.
std::vector<float> allFeatureValues(const std::vector<SaliencyBlock>& blocks) {
  std::vector<float> all;
  for (const SaliencyBlock& block : blocks) {
    for (const FeatureInfo& info : allFeatures()) {
      float values[kSize];
      featureValues(info.feature, block, values);
      all.insert(all.end(), values, values + kSize);
    }
  }
  return all;
}

/// Bits, so that a NaN is itself and -0 is not 0.
template <typename T>
bool sameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
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
  const auto isFinite = [](float value) { return std::isfinite(value); };
  EXPECT_TRUE(std::all_of(expected.begin(), expected.end(), isFinite));
}

/// Three classes on all the features, each a mixture with correlations.
ClassifierModel fullModel() {
  const auto features = static_cast<Eigen::Index>(allFeatures().size());
  ClassifierModel model = handModel();
  model.features.clear();
  for (const FeatureInfo& info : allFeatures()) model.features.push_back(info.feature);
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

TEST_P(VectorLevels, ClassificationOfAnyVolumeIsTheSame) {
  const std::vector<SaliencyBlock> saliencies = saliencyBlocks(someBlocks());
  for (const ClassifierModel& model : {handModel(), fullModel()}) {
    const Classifier classifier(model);
    const auto run = [&] {
      std::vector<Classification> all;
      for (const SaliencyBlock& block : saliencies) {
        FeatureBlock features(static_cast<int>(model.features.size()));
        for (std::size_t f = 0; f < model.features.size(); ++f) {
          featureValues(model.features[f], block, features.row(static_cast<int>(f)));
        }
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
