// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "ladar_perception/saliency/features.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

Saliency someSaliency() {
  Saliency s;
  s.points = 10;
  s.defined = true;
  s.scatter = 0.001;
  s.surface = 0.008;
  s.linear = 0.064;
  s.normal = Vector3d(0.0, std::sqrt(0.5), std::sqrt(0.5));
  s.tangent = Vector3d(1.0, 0.0, 0.0);
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
  const Saliency s = someSaliency();
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
  Saliency s = someSaliency();
  const float angle = featureValue(Feature::kNormalAngle, s);
  s.normal = -s.normal;
  EXPECT_EQ(featureValue(Feature::kNormalAngle, s), angle);
}

TEST(Features, AVerticalUnitVectorLongerByRoundingHasAngleZero) {
  Saliency s = someSaliency();
  s.normal = Vector3d(0, 0, 1.0 + 4e-16);
  s.tangent = Vector3d(0, 0, -1.0 - 4e-16);
  EXPECT_EQ(featureValue(Feature::kNormalAngle, s), 0.0F);
  EXPECT_EQ(featureValue(Feature::kTangentAngle, s), 0.0F);
}

TEST(Features, AllAreFiniteWhereTwoSalienciesAreZero) {
  Saliency s = someSaliency();
  s.scatter = s.surface = 0.0;
  for (const FeatureInfo& info : allFeatures()) {
    EXPECT_TRUE(std::isfinite(featureValue(info.feature, s))) << info.name;
  }
}

}  // namespace
}  // namespace ladar_perception
