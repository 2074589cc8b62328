// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "expect_error.h"
#include "ladar_perception/resample/policy.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::expectError;
using test::TestRandom;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kFloatNaN = std::numeric_limits<float>::quiet_NaN();

/// Points along the x axis, the sensor at the origin.
PointAttributes pointsAtRanges(const std::vector<double>& ranges_m) {
  PointAttributes points;
  for (const double range : ranges_m) points.positions_m.emplace_back(range, 0.0, 0.0);
  return points;
}

PointAttributes pointsWithVariation(const std::vector<float>& variations) {
  PointAttributes points = pointsAtRanges(std::vector<double>(variations.size(), 1.0));
  points.normals.assign(variations.size(), Eigen::Vector3f::UnitZ());
  points.normal_variation = variations;
  return points;
}

PointAttributes pointsWithColors(const std::vector<uint32_t>& colors) {
  PointAttributes points = pointsAtRanges(std::vector<double>(colors.size(), 1.0));
  points.rgb = colors;
  return points;
}

PointAttributes pointsWithLabels(const std::vector<uint8_t>& labels) {
  PointAttributes points = pointsAtRanges(std::vector<double>(labels.size(), 1.0));
  points.labels = labels;
  return points;
}

std::vector<float> weightsOf(const Policy& policy, const PointAttributes& points) {
  std::vector<float> weights(points.size(), 1.0f);
  policy.multiply(points, &weights);
  return weights;
}

std::vector<float> weightsOf(const std::string& specification, const PointAttributes& points) {
  return weightsOf(*makePolicy(specification), points);
}

void expectRefused(const std::string& specification, std::vector<std::string> parts) {
  parts.push_back("'" + specification + "'");
  expectError<std::invalid_argument>([&] { makePolicy(specification); }, parts);
}

TEST(ResamplePolicy, UniformChangesNothing) {
  std::vector<float> weights = {0.25f, 3.0f};
  makePolicy("uniform")->multiply(pointsAtRanges({1.0, 2.0}), &weights);
  EXPECT_EQ(weights, (std::vector<float>{0.25f, 3.0f}));
}

TEST(ResamplePolicy, RangeFallsWithTheSquareBeyondItsMinimum) {
  PointAttributes points = pointsAtRanges({0.0, 1.0, 2.0, 4.0, 20.0});
  EXPECT_EQ(weightsOf("range:min=2", points),
            (std::vector<float>{0.25f, 0.25f, 0.25f, 0.0625f, 0.0025f}));
  EXPECT_FLOAT_EQ(weightsOf("range", points)[1], 1.0f / 9.0f);
  points.sensor_m = Eigen::Vector3d(4.0, 0.0, 10.0);
  EXPECT_FLOAT_EQ(weightsOf("range:min=2", points)[3], 0.01f);
}

TEST(ResamplePolicy, RangeNeedsTheSensorsPlace) {
  PointAttributes points = pointsAtRanges({1.0});
  points.sensor_m.y() = kNaN;
  expectError<std::runtime_error>([&] { weightsOf("range", points); }, {"range:min=3", "sensor"});
}

TEST(ResamplePolicy, NormalVariationIsSpreadEvenly) {
  // A few points that vary much leave the others as far apart as without them.
  const PointAttributes points = pointsWithVariation({0.3f, 0.001f, 900.0f, 0.002f, 0.1f});
  EXPECT_EQ(weightsOf("normal_variation:mode=attract,ratio=5", points),
            (std::vector<float>{4, 1, 5, 2, 3}));
  EXPECT_EQ(weightsOf("normal_variation:mode=inhibit,ratio=5", points),
            (std::vector<float>{2, 5, 1, 4, 3}));
  EXPECT_EQ(weightsOf("normal_variation", points), (std::vector<float>{12.25, 1, 16, 4.75, 8.5}));
}

TEST(ResamplePolicy, NormalVariationGivesTiesTheirMean) {
  const PointAttributes points = pointsWithVariation({0.0f, 0.5f, 0.0f, 0.0f, 0.7f});
  EXPECT_EQ(weightsOf("normal_variation:ratio=5", points), (std::vector<float>{2, 4, 2, 2, 5}));
  EXPECT_EQ(weightsOf("normal_variation:ratio=5", pointsWithVariation({0.2f, 0.2f})),
            (std::vector<float>{3, 3}));
  EXPECT_EQ(weightsOf("normal_variation:ratio=5", pointsWithVariation({0.2f})),
            (std::vector<float>{3}));
  // What rounding left below zero is zero.
  EXPECT_EQ(weightsOf("normal_variation:ratio=3", pointsWithVariation({-0.0f, -1e-9f, 0.0f})),
            (std::vector<float>{2, 2, 2}));
}

TEST(ResamplePolicy, NormalVariationWithoutANormalIsInTheMiddle) {
  PointAttributes points = pointsWithVariation({0.1f, 0.2f, 0.0f, kFloatNaN, 0.3f});
  points.normals[2].setZero();
  EXPECT_EQ(weightsOf("normal_variation:ratio=3", points), (std::vector<float>{1, 2, 2, 2, 3}));
  points.normals.assign(points.size(), Eigen::Vector3f::Zero());
  EXPECT_EQ(weightsOf("normal_variation:ratio=3", points), (std::vector<float>(5, 2.0f)));
}

/// Ranks by sorting, as an oracle.
TEST(ResamplePolicy, NormalVariationAgreesWithSortedRanks) {
  constexpr std::size_t kCount = 5000;
  TestRandom random(1);
  std::vector<float> variations;
  for (std::size_t i = 0; i < kCount; ++i) {
    variations.push_back(static_cast<float>(std::exp(random.real(-12.0, 1.0))));
  }
  std::vector<float> sorted = variations;
  std::sort(sorted.begin(), sorted.end());
  const auto weights =
      weightsOf("normal_variation:mode=attract,ratio=11", pointsWithVariation(variations));
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto below = std::lower_bound(sorted.begin(), sorted.end(), variations[i]);
    const double rank = static_cast<double>(below - sorted.begin()) / (kCount - 1.0);
    ASSERT_NEAR(weights[i], 1.0 + 10.0 * rank, 0.02);
  }
}

TEST(ResamplePolicy, OnlyNormalVariationAsksForNormals) {
  EXPECT_TRUE(makePolicy("normal_variation")->needsNormals());
  for (const char* name : {"uniform", "range", "color:target=#000000", "label:surface=2"}) {
    EXPECT_FALSE(makePolicy(name)->needsNormals()) << name;
  }
}

TEST(ResamplePolicy, ColorFallsWithTheDistance) {
  const PointAttributes points = pointsWithColors(
      {0xb08060u, 0xb08060u + 0x180000u + 0x2000u, 0xb08060u + 0x20u, 0x00000000u, 0x0000ffu});
  const auto weights = weightsOf("color:target=#B08060,softness=40,ratio=17", points);
  EXPECT_EQ(weights[0], 17.0f);
  EXPECT_EQ(weights[1], 9.0f);  // 24 and 32 are 40 together
  EXPECT_GT(weights[2], 9.0f);
  EXPECT_NEAR(weights[3], 1.0f, 0.05f);
  EXPECT_NEAR(weights[4], 1.0f, 0.05f);
}

TEST(ResamplePolicy, ColorIgnoresTheByteAboveRed) {
  const PointAttributes points = pointsWithColors({0xff102030u, 0x00102030u});
  EXPECT_EQ(weightsOf("color:target=#102030,ratio=8", points), (std::vector<float>{8, 8}));
}

TEST(ResamplePolicy, ColorsMayBeAvoided) {
  const PointAttributes points = pointsWithColors({0x102030u, 0xffffffu});
  const auto weights = weightsOf("color:target=#102030,ratio=0.25", points);
  EXPECT_EQ(weights[0], 0.25f);
  EXPECT_NEAR(weights[1], 1.0f, 0.01f);
}

TEST(ResamplePolicy, LabelsHaveTheirFactors) {
  const PointAttributes points = pointsWithLabels({0, 1, 2, 3, 1});
  EXPECT_EQ(weightsOf("label:surface=0.25,linear=5", points),
            (std::vector<float>{1.0f, 0.25f, 1.0f, 5.0f, 0.25f}));
  EXPECT_EQ(weightsOf("label:unknown=0.5", points),
            (std::vector<float>{0.5f, 1.0f, 1.0f, 1.0f, 1.0f}));
  const auto own = makePolicy("label:bicycle=3,path=2", {"path", "bicycle", "wall"});
  EXPECT_EQ(weightsOf(*own, points), (std::vector<float>{1, 2, 3, 1, 2}));
}

TEST(ResamplePolicy, LabelsWithoutANameAreRefused) {
  expectError<std::runtime_error>(
      [] {
        weightsOf("label:surface=2", pointsWithLabels({1, 4}));
      },
      {"label:surface=2", "point 1", "label 4", "3 classes"});
}

TEST(ResamplePolicy, ProductsMultiply) {
  PointAttributes points = pointsAtRanges({1.0, 2.0});
  points.labels = {1, 3};
  std::vector<float> weights(2, 1.0f);
  for (const char* policy : {"range:min=1", "label:linear=8,surface=3"}) {
    makePolicy(policy)->multiply(points, &weights);
  }
  EXPECT_EQ(weights, (std::vector<float>{3.0f, 2.0f}));
}

TEST(ResamplePolicy, CallablesSeeAllOfAPoint) {
  PointAttributes points = pointsAtRanges({1.0, 2.0});
  points.labels = {1, 3};
  const auto policy = makePolicy(
      "mine",
      [](const PointAttributes& all, std::size_t i) {
        return all.positions_m[i].x() * all.labels[i];
      },
      true);
  EXPECT_EQ(weightsOf(*policy, points), (std::vector<float>{1.0f, 6.0f}));
  EXPECT_EQ(policy->describe(), "mine");
  EXPECT_TRUE(policy->needsNormals());
}

TEST(ResamplePolicy, CallablesMustGiveFinitePositiveWeights) {
  for (const double bad : {kNaN, 0.0, -1.0, kInfinity}) {
    const auto policy = makePolicy(
        "mine", [&](const PointAttributes&, std::size_t i) { return i == 2 ? bad : 1.0; });
    expectError<std::runtime_error>(
        [&] {
          weightsOf(*policy, pointsAtRanges({1, 2, 3}));
        },
        {"'mine'", "point 2", "greater than 0"});
  }
  expectError<std::invalid_argument>([] { makePolicy("mine", nullptr, false); }, {"'mine'"});
  expectError<std::invalid_argument>(
      [] { makePolicy("", [](const PointAttributes&, std::size_t) { return 1.0; }); }, {"name"});
}

TEST(ResamplePolicy, WeightsStayFiniteAndPositive) {
  const PointAttributes points = pointsAtRanges({1e30, 1.0});
  std::vector<float> weights(2, 1.0f);
  const auto huge = makePolicy("huge", [](const PointAttributes&, std::size_t) { return 1e300; });
  const auto tiny = makePolicy("tiny", [](const PointAttributes&, std::size_t) { return 1e-300; });
  for (const auto& policy : {makePolicy("range"), tiny, tiny}) policy->multiply(points, &weights);
  for (const float weight : weights) EXPECT_GT(weight, 0.0f);
  for (const auto& policy : {huge, huge}) policy->multiply(points, &weights);
  for (const float weight : weights) EXPECT_TRUE(std::isfinite(weight));
}

TEST(ResamplePolicy, EmptyCloudsHaveNoWeights) {
  for (const char* name :
       {"uniform", "range", "normal_variation", "color:target=#000000", "label:surface=2"}) {
    EXPECT_TRUE(weightsOf(name, PointAttributes()).empty()) << name;
  }
}

TEST(ResamplePolicy, MissingFieldsAreNamed) {
  expectError<std::runtime_error>(
      [] {
        weightsOf("color:target=#b08060", pointsWithLabels({1, 2}));
      },
      {"color:target=#b08060", "'rgb'", "x, y, z, label"});
  expectError<std::runtime_error>([] { weightsOf("label:linear=2", pointsWithColors({0})); },
                                  {"label:linear=2", "'label'", "x, y, z, rgb"});
  expectError<std::runtime_error>([] { weightsOf("normal_variation", pointsAtRanges({1})); },
                                  {"normal_variation:", "'normal'"});
  PointAttributes few = pointsAtRanges({1.0, 2.0});
  few.rgb = {0x102030u};
  expectError<std::runtime_error>([&] { weightsOf("color:target=#102030", few); }, {"'rgb'"});
}

TEST(ResamplePolicy, DescriptionsAreSpecifications) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"uniform", "uniform"},
      {"range", "range:min=3"},
      {"range:min=2.50", "range:min=2.5"},
      {"normal_variation:ratio=4", "normal_variation:mode=attract,ratio=4"},
      {"normal_variation:mode=inhibit", "normal_variation:mode=inhibit,ratio=16"},
      {"color:target=#0A0b0C", "color:target=#0a0b0c,softness=40,ratio=16"},
      {"label:linear=5,surface=0.2", "label:linear=5,surface=0.2"}};
  for (const auto& [given, described] : cases) {
    EXPECT_EQ(makePolicy(given)->describe(), described);
    EXPECT_EQ(makePolicy(described)->describe(), described);
  }
}

TEST(ResamplePolicy, SpecificationsAreReadStrictly) {
  expectRefused("", {"unknown policy ''", "uniform, range, normal_variation, color or label"});
  expectRefused("rnge:min=3", {"unknown policy 'rnge'", "range"});
  expectRefused(" range", {"unknown policy ' range'"});
  expectRefused("uniform:min=3", {"unknown key 'min'", "no options"});
  expectRefused("range:mni=3", {"unknown key 'mni'", "expected min"});
  expectRefused("range:", {"'' is no option", "key=value"});
  expectRefused("range:min", {"'min' is no option", "key=value"});
  expectRefused("range:min=", {"'min=' is no option"});
  expectRefused("range:=3", {"'=3' is no option"});
  expectRefused("range:min=3,", {"'' is no option"});
  expectRefused("range:min=3,min=4", {"'min' is given twice"});
  for (const char* number : {"three", "3m", "0x10", "0", "-3", "nan", "inf", "1e999", "3=3"}) {
    expectRefused(std::string("range:min=") + number,
                  {std::string("min is '") + number + "'", "number from 0.001 to 1e+06"});
  }
  expectRefused("normal_variation:mode=repel", {"mode is 'repel'", "attract or inhibit"});
  expectRefused("normal_variation:ratio=0.5", {"ratio is '0.5'", "from 1 to"});
  expectRefused("color", {"'target' is missing", "#rrggbb"});
  expectRefused("color:softness=3", {"'target' is missing"});
  for (const char* color : {"red", "#12345", "#1234567", "#12345g", "123456", "#-12345"}) {
    expectRefused(std::string("color:target=") + color,
                  {std::string("target is '") + color + "'", "#rrggbb"});
  }
  expectRefused("color:target=#102030,softness=0", {"softness is '0'"});
  expectRefused("color:target=#102030,hue=1", {"unknown key 'hue'", "target, softness or ratio"});
}

TEST(ResamplePolicy, FactorsOfLabelsAreReadStrictly) {
  expectRefused("label", {"no factors", "unknown, surface, scatter or linear"});
  expectRefused("label:wall=2", {"unknown key 'wall'", "unknown, surface, scatter or linear"});
  expectRefused("label:Surface=2", {"unknown key 'Surface'"});
  for (const char* factor : {"0", "-1", "much", "1e-7", "nan"}) {
    expectRefused(std::string("label:linear=") + factor,
                  {std::string("linear is '") + factor + "'", "number from 1e-06 to 1e+06"});
  }
  expectError<std::invalid_argument>(
      [] {
        makePolicy("label:surface=2", {"path", "bicycle"});
      },
      {"unknown key 'surface'", "unknown, path or bicycle"});
}

}  // namespace
}  // namespace ladar_perception
