// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>
#include <limits>

#include "io_test_files.h"
#include "ladar_perception/io/resampled_scan.h"

namespace ladar_perception {
namespace {

using Values = std::vector<double>;

const double kInfinity = std::numeric_limits<double>::infinity();

Column column(const std::string& name, const Values& values,
              ScalarType type = ScalarType::kFloat32) {
  return {name, type, values};
}

double colorBits(uint32_t rgb) {
  float value = 0.0F;
  std::memcpy(&value, &rgb, sizeof value);
  return value;
}

Scan threePoints(std::vector<Column> more) {
  std::vector<Column> columns = {column("x", {1, 2, 3}), column("y", {4, 5, 6}),
                                 column("z", {7, 8, 9})};
  columns.insert(columns.end(), more.begin(), more.end());
  return makeScan(columns);
}

ResampledCloud twoSamples() {
  ResampledCloud samples;
  samples.positions_m = {{3.125, 6.5, 9.25}, {1.0, 4.0, 7.0}};
  samples.normals = {{0, 0, 1}, {0.6F, 0.8F, 0}};
  samples.sources = {2, 0};
  samples.covering_radii = {std::numeric_limits<float>::infinity(), 0.5F};
  samples.weights = {1, 1};
  return samples;
}

TEST(IoResampledScan, SamplesHaveTheFieldsOfTheirSources) {
  const Scan scan = threePoints(
      {column("intensity", {10, 20, 30}), column("ring", {1, 2, 65535}, ScalarType::kUint16)});
  const Scan samples = resampledScan(scan, twoSamples());
  EXPECT_EQ(samples.layout.describeFields(),
            "x:float32, y:float32, z:float32, intensity:float32, ring:uint16, normal_x:float32, "
            "normal_y:float32, normal_z:float32, covering_radius:float32");
  EXPECT_EQ(layoutError({samples.layout, samples.data.data(), samples.data.size()}), "");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(readColumn(samples, "x"), (Values{3.125, 1}));
  EXPECT_EQ(readColumn(samples, "z"), (Values{9.25, 7}));
  EXPECT_EQ(readColumn(samples, "intensity"), (Values{30, 10}));
  EXPECT_EQ(readColumn(samples, "ring"), (Values{65535, 1}));
  EXPECT_NEAR(readColumn(samples, "normal_y")[1], 0.8, 1e-6);
  EXPECT_EQ(readColumn(samples, "covering_radius"), (Values{kInfinity, 0.5}));
  EXPECT_TRUE(samples.is_dense);
}

TEST(IoResampledScan, KeepsDoublesAndMakesFloatsOfWholeNumbers) {
  Scan scan = makeScan({column("x", {4567890.5, 0, 4567891.5}, ScalarType::kFloat64),
                        column("y", {0, 1, 2}, ScalarType::kInt16),
                        column("z", {0, 0, 0}, ScalarType::kFloat32)});
  ResampledCloud samples = twoSamples();
  samples.positions_m[0].x() = 4567891.625;
  const Scan again = resampledScan(scan, samples);
  EXPECT_EQ(readColumn(again, "x")[0], 4567891.625);
  EXPECT_EQ(readColumn(again, "y"), (Values{6.5, 4}));
  EXPECT_EQ(again.layout.describeFields().substr(0, 36), "x:float64, y:float32, z:float32, nor");
}

TEST(IoResampledScan, FieldsThatMakeWayKeepTheirValues) {
  const Scan scan = threePoints({column("normal_x", {1, 2, 3}), column("normal_x_input", {4, 5, 6}),
                                 column("covering_radius", {7, 8, 9}, ScalarType::kFloat64)});
  const Scan samples = resampledScan(scan, twoSamples());
  EXPECT_EQ(readColumn(samples, "normal_x_input"), (Values{6, 4}));
  EXPECT_EQ(readColumn(samples, "normal_x_input_input"), (Values{3, 1}));
  EXPECT_EQ(readColumn(samples, "covering_radius_input"), (Values{9, 7}));
  EXPECT_EQ(readColumn(samples, "normal_x"), (Values{0, readColumn(samples, "normal_x")[1]}));
}

TEST(IoResampledScan, RowsAndWideFieldsAreFollowed) {
  Scan scan = threePoints({column("h", {1, 2, 3}), column("h2", {4, 5, 6})});
  scan.layout.fields.pop_back();
  scan.layout.fields.back().count = 2;
  scan.layout.width = 1;
  scan.layout.height = 3;
  scan.layout.pack();
  const Scan samples = resampledScan(scan, twoSamples());
  EXPECT_EQ(layoutError({samples.layout, samples.data.data(), samples.data.size()}), "");
  const Field* wide = samples.layout.find("h");
  ASSERT_NE(wide, nullptr);
  EXPECT_EQ(wide->count, 2u);
  float second = 0.0F;
  std::memcpy(&second, samples.data.data() + wide->offset + sizeof(float), sizeof second);
  EXPECT_EQ(second, 6.0F);
}

TEST(IoResampledScan, NoSamplesIsAScanWithoutPoints) {
  const Scan samples = resampledScan(threePoints({}), ResampledCloud());
  EXPECT_EQ(samples.size(), 0u);
  EXPECT_EQ(samples.layout.fields.size(), 7u);
}

TEST(IoResampledScan, CloudsHavePositionsAndColours) {
  const PoseCloudData plain = poseCloudOf(threePoints({}));
  ASSERT_EQ(plain.positions_m.size(), 3u);
  EXPECT_EQ(plain.positions_m[1], Eigen::Vector3d(2, 5, 8));
  EXPECT_TRUE(plain.rgb.empty());
  const Scan coloured =
      threePoints({column("rgb", {colorBits(0x010203), colorBits(0xff0080), colorBits(0)})});
  EXPECT_EQ(poseCloudOf(coloured).rgb, (std::vector<uint32_t>{0x010203, 0xff0080, 0}));
}

TEST(IoResampledScan, NumbersOfTextFilesBecomeColours) {
  const std::vector<uint32_t> expected = {0x010203, 0xff0080, 0};
  for (const std::vector<std::string>& names : {std::vector<std::string>{"red", "green", "blue"},
                                                std::vector<std::string>{"r", "g", "b"}}) {
    Scan scan = threePoints({column(names[0], {1, 255, 0}), column("i", {5, 6, 7}),
                             column(names[1], {2, 0, 0}), column(names[2], {3, 128, 0})});
    packColors(&scan);
    EXPECT_EQ(scan.layout.describeFields(),
              "x:float32, y:float32, z:float32, i:float32, rgb:float32");
    EXPECT_EQ(poseCloudOf(scan).rgb, expected);
    EXPECT_EQ(readColumn(scan, "i"), (Values{5, 6, 7}));
  }
  Scan number = threePoints({column("rgb", {66051, 16711808, 0})});
  packColors(&number);
  EXPECT_EQ(poseCloudOf(number).rgb, expected);
  Scan bits = threePoints({column("rgb", {colorBits(0x010203), colorBits(0xff0080), 0})});
  packColors(&bits);
  EXPECT_EQ(poseCloudOf(bits).rgb, expected);
  Scan none = threePoints({column("r", {1, 2, 3})});
  packColors(&none);
  EXPECT_TRUE(poseCloudOf(none).rgb.empty());
  Scan wrong = threePoints(
      {column("red", {1, 2, 3}), column("green", {1, 2.5, 3}), column("blue", {1, 2, 3})});
  expectError([&] { packColors(&wrong); }, {"'green'", "point 1", "2.5", "0 to 255"});
}

TEST(IoResampledScan, LabelsAreNumbersOfClasses) {
  const Scan scan = threePoints({column("label", {0, 3, 1}), column("truth", {4, 0.5, -1})});
  EXPECT_EQ(labelsOf(scan, "label", 3), (std::vector<uint8_t>{0, 3, 1}));
  expectError([&] { labelsOf(scan, "label", 2); }, {"'label'", "point 1", "3", "from 0 to 2"});
  expectError([&] { labelsOf(scan, "truth", 4); }, {"'truth'", "point 1", "0.5"});
  expectError([&] { labelsOf(scan, "class", 3); }, {"'class'", "x:float32"});
  ClassMapping mapping;
  mapping.names = {"floor", "other"};
  mapping.truth_of_label = {{3, 2}, {1, 1}};
  EXPECT_EQ(labelsOf(scan, "label", mapping), (std::vector<uint8_t>{0, 2, 1}));
  expectError([&] { labelsOf(scan, "truth", mapping); }, {"'truth'", "whole number"});
}

}  // namespace
}  // namespace ladar_perception
