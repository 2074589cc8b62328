// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "ladar_perception/saliency/features.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3f;

constexpr double kPi = 3.14159265358979323846;

SaliencyF someSaliency() {
  SaliencyF s;
  s.points = 10;
  s.defined = true;
  s.scatter = 0.001F;
  s.surface = 0.008F;
  s.linear = 0.064F;
  s.normal = Vector3f(0.0F, std::sqrt(0.5F), std::sqrt(0.5F));
  s.tangent = Vector3f::UnitX();
  return s;
}

TEST(Features, NamesRoundTripAndAreUnique) {
  std::set<std::string> names;
  for (const FeatureInfo& info : allFeatures()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_STREQ(featureName(info.feature), info.name);
    ASSERT_TRUE(featureFromName(info.name).has_value());
    EXPECT_EQ(*featureFromName(info.name), info.feature);
    EXPECT_STRNE(info.unit, "");
    EXPECT_STRNE(info.meaning, "");
  }
  EXPECT_EQ(names.size(), 8U);
  EXPECT_FALSE(featureFromName("Scatter").has_value());
  EXPECT_FALSE(featureFromName("").has_value());
}

TEST(Features, ValuesOfAKnownShape) {
  const SaliencyF s = someSaliency();
  EXPECT_FLOAT_EQ(featureValue(Feature::kScatter, s), 0.001F);
  EXPECT_FLOAT_EQ(featureValue(Feature::kSurface, s), 0.008F);
  EXPECT_FLOAT_EQ(featureValue(Feature::kLinear, s), 0.064F);
  EXPECT_FLOAT_EQ(featureValue(Feature::kCbrtScatter, s), 0.1F);
  EXPECT_FLOAT_EQ(featureValue(Feature::kCbrtSurface, s), 0.2F);
  EXPECT_FLOAT_EQ(featureValue(Feature::kCbrtLinear, s), 0.4F);
  EXPECT_FLOAT_EQ(featureValue(Feature::kNormalAngle, s), static_cast<float>(kPi / 4));
  EXPECT_FLOAT_EQ(featureValue(Feature::kTangentAngle, s), static_cast<float>(kPi / 2));
}

TEST(Features, AnglesDoNotDependOnTheSignOfADirection) {
  SaliencyF s = someSaliency();
  const float angle = featureValue(Feature::kNormalAngle, s);
  s.normal = -s.normal;
  EXPECT_EQ(featureValue(Feature::kNormalAngle, s), angle);
}

TEST(Features, AVerticalUnitVectorLongerByRoundingHasAngleZero) {
  SaliencyF s = someSaliency();
  s.normal = Vector3f(0.0F, 0.0F, 1.0F + 2e-7F);
  s.tangent = Vector3f(0.0F, 0.0F, -1.0F - 2e-7F);
  EXPECT_EQ(featureValue(Feature::kNormalAngle, s), 0.0F);
  EXPECT_EQ(featureValue(Feature::kTangentAngle, s), 0.0F);
}

TEST(Features, AllAreFiniteWhereTwoSalienciesAreZero) {
  SaliencyF s = someSaliency();
  s.scatter = s.surface = 0.0F;
  for (const FeatureInfo& info : allFeatures()) {
    EXPECT_TRUE(std::isfinite(featureValue(info.feature, s))) << info.name;
  }
}

}  // namespace
}  // namespace ladar_perception
