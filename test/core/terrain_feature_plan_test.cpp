// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ladar_perception/map/moments.h"
#include "ladar_perception/terrain/feature_plan.h"
#include "wide_model.h"

namespace ladar_perception {
namespace {

FeaturePlan planOf(const std::vector<std::string>& names) {
  return FeaturePlan(parseFeatures(names));
}

const BoxStack kFour = {{cube(4), 1}};

TEST(FeaturePlan, OfTheConfiguredSupportNeedsNothingElse) {
  const FeaturePlan plan = planOf({"saliency", "normal_angle", "log_points"});
  EXPECT_TRUE(plan.boxes.empty());
  EXPECT_TRUE(plan.layers.empty());
  EXPECT_EQ(plan.source, std::vector<int>(5, 0));
  EXPECT_EQ(plan.reach(kFour), 4);
  EXPECT_EQ(plan.maxPointsPerVoxel(kFour), maxPointsPerVoxel(4));
}

TEST(FeaturePlan, EachBoxAndEachLayerIsThereOnce) {
  const FeaturePlan plan =
      planOf({"scatter@6", "log_height@40", "surface@3x15", "scatter", "linear@6", "sqrt_height@40",
              "log_ground_height@40", "log_fill@40", "log_height@10", "linear@3x15", "scatter@9x3",
              "log_ground_height@10", "scatter@3"});
  EXPECT_EQ(plan.boxes, (std::vector<SupportBox>{{6, 6}, {3, 15}, {9, 3}, {3, 3}}));
  ASSERT_EQ(plan.layers.size(), 5U);
  const auto expectLayer = [&](int i, ColumnQuantity quantity, int radius) {
    EXPECT_EQ(plan.layers[i].quantity(), quantity) << i;
    EXPECT_EQ(plan.layers[i].radius(), radius) << i;
  };
  expectLayer(0, ColumnQuantity::kLowest, 40);
  expectLayer(1, ColumnQuantity::kGround, 40);
  expectLayer(2, ColumnQuantity::kFill, 40);
  expectLayer(3, ColumnQuantity::kLowest, 10);
  expectLayer(4, ColumnQuantity::kGround, 10);
  EXPECT_EQ(plan.source, (std::vector<int>{1, 0, 2, 0, 1, 0, 1, 2, 3, 2, 3, 4, 4}));
}

/// Whatever the features, each finds its own, and nothing is there that none asks for.
TEST(FeaturePlan, EveryFeatureFindsItsSource) {
  std::vector<std::string> names = test::wideFeatures();
  std::sort(names.begin(), names.end());
  do {
    const std::vector<Feature> features = parseFeatures(names);
    const FeaturePlan plan(features);
    ASSERT_EQ(plan.source.size(), features.size());
    std::vector<bool> box_used(plan.boxes.size(), false);
    std::vector<bool> layer_used(plan.layers.size(), false);
    for (std::size_t f = 0; f < features.size(); ++f) {
      const int source = plan.source[f];
      if (isOfColumns(features[f].quantity)) {
        ASSERT_EQ(plan.layers.at(source).quantity(), columnQuantity(features[f].quantity));
        ASSERT_EQ(plan.layers.at(source).radius(), features[f].box.radius_xy);
        layer_used[source] = true;
      } else if (features[f].isOfConfiguredSupport()) {
        ASSERT_EQ(source, 0);
      } else {
        ASSERT_EQ(plan.boxes.at(source - 1), features[f].box);
        box_used[source - 1] = true;
      }
    }
    ASSERT_EQ(std::count(box_used.begin(), box_used.end(), false), 0);
    ASSERT_EQ(std::count(layer_used.begin(), layer_used.end(), false), 0);
    ASSERT_EQ(plan.boxes.size(), 2U);
    ASSERT_EQ(plan.layers.size(), 5U);
    std::rotate(names.begin(), names.begin() + 1, names.end());
  } while (!std::is_sorted(names.begin(), names.end()));
}

TEST(FeaturePlan, ReachIsThatOfTheWidestSupport) {
  EXPECT_EQ(planOf({"scatter@6", "scatter@8"}).reach(kFour), 8);
  EXPECT_EQ(planOf({"scatter@2"}).reach(kFour), 4);
  EXPECT_EQ(planOf({"scatter@3x15"}).reach(kFour), 4) << "columns change by their points at once";
  EXPECT_EQ(planOf({"scatter@10x1"}).reach(kFour), 10);
  EXPECT_EQ(planOf({"scatter", "log_height@40"}).reach(kFour), 4) << "layers tell by themselves";
  EXPECT_EQ(planOf({"scatter@5"}).reach(gaussianBoxStack(6)), 6);
}

TEST(FeaturePlan, VoxelsHoldWhatTheLargestSumsTake) {
  EXPECT_EQ(planOf({"scatter@6"}).maxPointsPerVoxel(kFour), maxPointsPerVoxel(6));
  EXPECT_EQ(planOf({"scatter@2", "scatter@8"}).maxPointsPerVoxel(kFour), maxPointsPerVoxel(8));
  EXPECT_EQ(planOf({"scatter@2", "log_fill@100"}).maxPointsPerVoxel(kFour), maxPointsPerVoxel(4));
  // 7 x 7 x 31 voxels, every coordinate up to 31 half voxels off.
  EXPECT_EQ(planOf({"scatter@3x15"}).maxPointsPerVoxel(kFour),
            (uint64_t{1} << 31) / (uint64_t{128} * 31 * 7 * 7 * 31));
  // A kernel's weights take room as well.
  const BoxStack kernel = gaussianBoxStack(4);
  EXPECT_EQ(planOf({"scatter@2"}).maxPointsPerVoxel(kernel), maxPointsPerVoxel(kernel));
  EXPECT_LT(maxPointsPerVoxel(kernel), maxPointsPerVoxel(4));
}

}  // namespace
}  // namespace ladar_perception
