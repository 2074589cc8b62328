// SPDX-License-Identifier: BSD-3-Clause
// Features by name: what model files and command lines say.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "ladar_perception/saliency/box_stack.h"
#include "ladar_perception/saliency/features.h"

namespace ladar_perception {
namespace {

TEST(Quantities, HaveUniqueNamesUnitsAndMeanings) {
  std::set<std::string> names;
  std::set<Quantity> quantities;
  for (const QuantityInfo& info : allQuantities()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_TRUE(quantities.insert(info.quantity).second) << info.name;
    EXPECT_STRNE(info.unit, "");
    EXPECT_STRNE(info.meaning, "");
    EXPECT_EQ(std::string(info.name).find_first_not_of("abcdefghijklmnopqrstuvwxyz_"),
              std::string::npos)
        << info.name;
  }
  EXPECT_EQ(names.size(), 25U);
}

TEST(Quantities, OfColumnsHaveALayer) {
  std::vector<std::string> of_columns;
  for (const QuantityInfo& info : allQuantities()) {
    if (isOfColumns(info.quantity)) of_columns.emplace_back(info.name);
  }
  EXPECT_EQ(of_columns, (std::vector<std::string>{"log_height", "sqrt_height", "log_ground_height",
                                                  "log_fill"}));
  EXPECT_EQ(columnQuantity(Quantity::kLogHeight), ColumnQuantity::kLowest);
  EXPECT_EQ(columnQuantity(Quantity::kSqrtHeight), ColumnQuantity::kLowest);
  EXPECT_EQ(columnQuantity(Quantity::kLogGroundHeight), ColumnQuantity::kGround);
  EXPECT_EQ(columnQuantity(Quantity::kLogFill), ColumnQuantity::kFill);
}

void expectRoundTrip(const std::string& name, const Feature& feature) {
  const Feature parsed = parseFeature(name);
  EXPECT_EQ(parsed, feature) << name << " is taken for " << featureName(parsed);
  EXPECT_EQ(featureName(feature), name);
}

TEST(FeatureNames, RoundTrip) {
  for (const QuantityInfo& info : allQuantities()) {
    const std::string name = info.name;
    if (isOfColumns(info.quantity)) {
      for (const int radius : {1, 7, 40, 100}) {
        expectRoundTrip(name + "@" + std::to_string(radius), {info.quantity, {radius, 0}});
      }
      continue;
    }
    expectRoundTrip(name, {info.quantity, {0, 0}});
    for (const int radius : {1, 4, 8}) {
      expectRoundTrip(name + "@" + std::to_string(radius), {info.quantity, cube(radius)});
    }
    expectRoundTrip(name + "@3x15", {info.quantity, {3, 15}});
    expectRoundTrip(name + "@12x2", {info.quantity, {12, 2}});
  }
}

TEST(FeatureNames, ACubeHasOneName) {
  EXPECT_EQ(featureName(parseFeature("scatter@6x6")), "scatter@6");
  EXPECT_EQ(featureName(parseFeature("scatter@06")), "scatter@6");
}

TEST(FeatureNames, OnlyThoseWithoutARadiusAreOfTheConfiguredSupport) {
  EXPECT_TRUE(parseFeature("scatter").isOfConfiguredSupport());
  EXPECT_FALSE(parseFeature("scatter@4").isOfConfiguredSupport());
  EXPECT_FALSE(parseFeature("log_height@4").isOfConfiguredSupport());
  EXPECT_FALSE(parseFeature("scatter") == parseFeature("scatter@4"));
  EXPECT_FALSE(parseFeature("scatter@4") == parseFeature("surface@4"));
  EXPECT_FALSE(parseFeature("scatter@4x5") == parseFeature("scatter@5x4"));
}

/// What parsing complains about, which must name the feature.
template <typename Parse>
std::string errorOf(const Parse& parse) {
  try {
    parse();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

void expectError(const std::string& name, const std::string& expected) {
  const std::string error = errorOf([&] { parseFeature(name); });
  EXPECT_NE(error.find("'" + name + "'"), std::string::npos) << error;
  EXPECT_NE(error.find(expected), std::string::npos) << "for '" << name << "': " << error;
}

TEST(FeatureNames, TheUnknownIsNamedBesideTheKnown) {
  for (const char* name : {"redness", "", "Scatter", " scatter", "scatter ", "redness@3", "@3"}) {
    expectError(name, "unknown feature");
    expectError(name, "known are: scatter surface linear");
    expectError(name, "log_ground_height log_fill");
  }
}

TEST(FeatureNames, RadiiMustBeWholeNumbersFromOne) {
  for (const char* radius : {"", "0", "-1", "+3", " 3", "3 ", "3.5", "abc", "3@4", "0x3", "3x0",
                             "x3", "3x", "3x-2", "3x4x5", "3X4", "99999", "3x99999", "1e1"}) {
    expectError(std::string("scatter@") + radius, "expected a whole number of voxels from 1");
  }
  expectError("scatter@3x0", "'0' is no radius");
  expectError("scatter@3x4x5", "'4x5' is no radius");
}

TEST(FeatureNames, SupportsMustNotBeTooLarge) {
  for (const char* box : {"9", "9999", "9x9", "64", "65x1", "1x65", "9999x1", "30x30", "17x3"}) {
    expectError(std::string("linear@") + box, "expected a cube of radius 8 at most");
  }
  // Whatever is taken leaves voxels room for points.
  for (int xy = 1; xy <= 70; ++xy) {
    for (int z = 1; z <= 70; ++z) {
      const std::string name = "linear@" + std::to_string(xy) + "x" + std::to_string(z);
      const bool is_taken = errorOf([&] { parseFeature(name); }) == "no error";
      const bool has_room = maxPointsPerVoxel({{SupportBox{xy, z}, 1}}) >= 200;
      ASSERT_EQ(is_taken, has_room && xy <= 64 && z <= 64) << name;
    }
  }
}

TEST(FeatureNames, ColumnsNeedARadius) {
  for (const char* name : {"log_height", "log_ground_height@", "log_height@101", "sqrt_height@9999",
                           "log_fill@3x4", "log_fill@x"}) {
    expectError(name, "needs '@' and a radius of 1 to 100 columns, as in '@40'");
  }
  for (const char* name : {"log_fill@0", "sqrt_height@-3", "log_height@ 3"}) {
    expectError(name, "expected a whole number of voxels from 1");
  }
}

TEST(FeatureSets, AreListsOfFeatures) {
  std::set<std::string> names;
  for (const FeatureSet& set : featureSets()) {
    EXPECT_TRUE(names.insert(set.name).second) << set.name;
    EXPECT_STRNE(set.meaning, "");
    const std::vector<Feature> features = parseFeatures({set.name});
    std::vector<std::string> members;  // of sets in it, too
    for (const std::string& member : set.features) {
      for (const Feature& feature : parseFeatures({member})) {
        members.push_back(featureName(feature));
      }
    }
    ASSERT_EQ(features.size(), members.size()) << set.name;
    for (std::size_t i = 0; i < features.size(); ++i) {
      EXPECT_EQ(featureName(features[i]), members[i]);
    }
    // A set that is called as a quantity would hide it.
    for (const QuantityInfo& info : allQuantities()) EXPECT_STRNE(info.name, set.name);
  }
  EXPECT_EQ(names.count("saliency"), 1U);
}

TEST(FeatureSets, MixWithFeaturesInOrder) {
  const std::vector<Feature> features = parseFeatures({"log_height@40", "saliency", "scatter@8"});
  std::vector<std::string> names;
  for (const Feature& feature : features) names.push_back(featureName(feature));
  EXPECT_EQ(names, (std::vector<std::string>{"log_height@40", "cbrt_scatter", "cbrt_surface",
                                             "cbrt_linear", "scatter@8"}));
}

TEST(FeatureSets, ErrorsNameWhatIsWrong) {
  const auto error = [](const std::vector<std::string>& names) {
    return errorOf([&] { parseFeatures(names); });
  };
  EXPECT_EQ(error({}), "no feature is named");
  EXPECT_EQ(error({"scatter", "linear", "scatter"}), "feature 'scatter' is there twice");
  EXPECT_EQ(error({"scatter@4", "scatter@4x4"}), "feature 'scatter@4x4' is there twice");
  EXPECT_EQ(error({"cbrt_linear", "saliency"}), "feature 'cbrt_linear' is there twice");
  EXPECT_NE(error({"saliency", "no_such_set"}).find("unknown feature 'no_such_set'"),
            std::string::npos);
  EXPECT_EQ(error({"scatter", "scatter@4", "scatter@4x5", "log_fill@4"}), "no error");
}

}  // namespace
}  // namespace ladar_perception
