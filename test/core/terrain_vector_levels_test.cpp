// SPDX-License-Identifier: BSD-3-Clause
// A terrain pipeline says the same bits on every vector level.
#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "ladar_perception/terrain/terrain_pipeline.h"
#include "terrain_comparisons.h"
#include "terrain_scenes.h"
#include "vector_levels.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::areFinite;
using test::handModel;
using test::kVectorLevels;
using test::MixedScene;
using test::processAt;
using test::randomModel;
using test::sameBits;
using test::VectorLevels;
using test::wideFeatures;

/// Everything a pipeline said, scan by scan and voxel by voxel.
struct PipelineRecord {
  std::vector<SaliencyF> saliencies;
  std::vector<Classification> classifications;
  std::vector<PointLabel> labels;
  std::vector<Moments> moments;
  std::vector<float> features;
  std::vector<std::size_t> updated_voxels;
};

PipelineRecord drive(const TerrainConfig& config, const ClassifierModel& model) {
  TerrainPipeline pipeline(config, model);
  pipeline.keepFeatures(true);
  PipelineRecord record;
  const Vector3d places[] = {{0, 0, 0}, {0.7, -0.3, 0.1}, {0.7, -0.3, 0.1}, {1e6, 1e6, -300}};
  for (int scan = 0; scan < 4; ++scan) {
    const MixedScene scene(scan);
    processAt(&pipeline, scene.points, places[scan]);
    pipeline.map().forEachVoxel([&](const VoxelIndex& /*voxel*/, std::size_t slot) {
      record.saliencies.push_back(pipeline.saliency(slot));
      record.classifications.push_back(pipeline.classification(slot));
      record.moments.push_back(pipeline.map().record(slot));
      const float* features = pipeline.features(slot);
      record.features.insert(record.features.end(), features, features + model.features.size());
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
  ASSERT_TRUE(sameBits(a.features, b.features));
  ASSERT_TRUE(areFinite(a.features));
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
  const auto run = [] { return drive({}, handModel()); };
  expectSame(atBaseline(run), atLevel(run));
}

TEST_P(VectorLevels, APipelineThatDoesNotSmoothSaysTheSame) {
  const auto run = [] {
    TerrainConfig config;
    config.smooth_labels = false;
    return drive(config, handModel());
  };
  expectSame(atBaseline(run), atLevel(run));
}

TEST_P(VectorLevels, APipelineWithManySupportsLayersAndClassesSaysTheSame) {
  for (const int classes : {4, 7, 16}) {
    const auto run = [&] {
      TerrainConfig config;
      config.map_size_x_m = config.map_size_y_m = 12.0;
      ClassifierModel model = randomModel(config, wideFeatures(), classes);
      model.calibration.smoothing.exponents = {0.3, 1.7, 0.6};
      for (int c = 0; c < classes; ++c) {
        model.calibration.smoothing.offsets.push_back(0.1 * (c % 3));
      }
      return drive(config, model);
    };
    expectSame(atBaseline(run), atLevel(run));
  }
}

TEST_P(VectorLevels, APipelineWithAKernelThatForgetsSaysTheSame) {
  const auto run = [] {
    TerrainConfig config;
    config.support_kernel = "gaussian";
    config.forget_after_scans = 2;
    return drive(config, test::modelFor(config));
  };
  expectSame(atBaseline(run), atLevel(run));
}

TEST_P(VectorLevels, APipelineOfATallMapWithThreadsSaysTheSame) {
  const auto run = [] {
    TerrainConfig config;
    config.map_size_z_m = 7.0;
    config.support_radius_voxels = 2;
    config.threads = 3;
    return drive(config, test::modelFor(config));
  };
  expectSame(atBaseline(run), atLevel(run));
}

INSTANTIATE_TEST_SUITE_P(All, VectorLevels, testing::ValuesIn(kVectorLevels),
                         [](const auto& level) { return vectorLevelName(level.param); });

}  // namespace
}  // namespace ladar_perception
