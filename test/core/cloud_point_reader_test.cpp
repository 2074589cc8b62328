// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>

#include "cloud_builder.h"
#include "ladar_perception/cloud/point_reader.h"

namespace ladar_perception {
namespace {

using Eigen::Vector3d;
using test::CloudBuilder;

constexpr double kMaxOffset_s = 1.0;

CloudBuilder emptyXyz(ScalarType type, uint32_t width) {
  CloudBuilder cloud;
  for (const char* name : {"x", "y", "z"}) cloud.layout.append(name, type);
  cloud.layout.width = width;
  cloud.layout.pack();
  return cloud;
}

std::vector<Vector3d> positionsOf(const CloudView& view) {
  std::string error;
  const auto fields = findPointFields(view, &error);
  EXPECT_TRUE(fields.has_value()) << error;
  std::vector<Vector3d> positions = {Vector3d(9, 9, 9)};  // what was there must go
  if (fields) readPositions(view, *fields, &positions);
  return positions;
}

std::string errorOf(const CloudView& view) {
  std::string error;
  EXPECT_FALSE(findPointFields(view, &error).has_value());
  return error;
}

class AllTypes : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
  ScalarType type() const { return static_cast<ScalarType>(std::get<0>(GetParam())); }
  bool bigEndian() const { return std::get<1>(GetParam()); }
  bool isSigned() const {
    return std::get<0>(GetParam()) % 2 == 1 || type() == ScalarType::kFloat64;
  }
};

TEST_P(AllTypes, OrganisedPaddedUnalignedPositions) {
  CloudBuilder cloud;
  CloudLayout& layout = cloud.layout;
  const auto size = static_cast<uint32_t>(scalarSize(type()));
  // z before x, all at odd offsets, gaps between and after.
  layout.fields = {{"ring", 0, ScalarType::kUint8, 1},
                   {"z", 1, type(), 1},
                   {"x", 3 + size, type(), 0},
                   {"y", 5 + 2 * size, type(), 1}};
  layout.point_step = 7 + 3 * size;
  layout.width = 4;
  layout.height = 3;
  layout.row_step = layout.width * layout.point_step + 5;
  layout.big_endian = bigEndian();
  cloud.allocate();
  std::vector<Vector3d> expected;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 4; ++col) {
      const double sign = isSigned() ? -1.0 : 1.0;
      expected.emplace_back(10 * row + col, sign * (20 + row), 100 + col);
      cloud.set(row, col, "x", expected.back().x());
      cloud.set(row, col, "y", expected.back().y());
      cloud.set(row, col, "z", expected.back().z());
    }
  }
  EXPECT_EQ(positionsOf(cloud.view()), expected);
}

TEST_P(AllTypes, ExtremesOfTheType) {
  CloudBuilder cloud = emptyXyz(type(), 1);
  cloud.layout.big_endian = bigEndian();
  cloud.allocate();
  const int bits = static_cast<int>(8 * scalarSize(type()));
  double low = isSigned() ? -std::ldexp(1.0, bits - 1) : 0.0;
  double high = std::ldexp(1.0, isSigned() ? bits - 1 : bits) - 1.0;
  if (type() == ScalarType::kFloat32) {
    low = -std::numeric_limits<float>::max();
    high = std::numeric_limits<float>::denorm_min();
  } else if (type() == ScalarType::kFloat64) {
    low = -std::numeric_limits<double>::max();
    high = std::numeric_limits<double>::denorm_min();
  }
  cloud.set(0, 0, "x", low);
  cloud.set(0, 0, "y", high);
  cloud.set(0, 0, "z", 1.0);
  EXPECT_EQ(positionsOf(cloud.view()), std::vector<Vector3d>{Vector3d(low, high, 1.0)});
}

TEST_P(AllTypes, ScalarsOfAnyField) {
  CloudBuilder cloud = emptyXyz(ScalarType::kFloat32, 3);
  cloud.layout.big_endian = bigEndian();
  cloud.layout.append("value", type()).count = 2;
  cloud.layout.point_step += 11;
  cloud.layout.pack();
  cloud.allocate();
  for (int i = 0; i < 3; ++i) {
    cloud.set(0, i, "value", 40 + i, 0);
    cloud.set(0, i, "value", 90, 1);
  }
  std::vector<double> values;
  readScalars(cloud.view(), *cloud.layout.find("value"), &values);
  EXPECT_EQ(values, (std::vector<double>{40, 41, 42}));
}

INSTANTIATE_TEST_SUITE_P(Cloud, AllTypes, testing::Combine(testing::Range(1, 9), testing::Bool()),
                         [](const auto& types) {
                           return scalarName(static_cast<ScalarType>(std::get<0>(types.param))) +
                                  (std::get<1>(types.param) ? "_big" : "_little");
                         });

TEST(FindPointFields, AMissingCoordinateListsWhatIsThere) {
  for (const std::string missing : {"x", "y", "z"}) {
    CloudBuilder cloud;
    for (const std::string name : {"x", "y", "z", "intensity"}) {
      if (name != missing) cloud.layout.append(name, ScalarType::kFloat32);
    }
    const std::string error = errorOf(cloud.view());
    EXPECT_NE(error.find("'" + missing + "' is missing"), std::string::npos) << error;
    EXPECT_NE(error.find(cloud.layout.describeFields()), std::string::npos) << error;
  }
  EXPECT_NE(errorOf(CloudBuilder().view()).find("none"), std::string::npos);
}

TEST(FindPointFields, ContradictionsAreReported) {
  CloudBuilder cloud = emptyXyz(ScalarType::kFloat32, 2);
  cloud.allocate();
  cloud.bytes.pop_back();
  EXPECT_NE(errorOf(cloud.view()).find("23 bytes"), std::string::npos);
  cloud.bytes.push_back(0);
  cloud.layout.append("far", ScalarType::kFloat32).offset = 100;
  EXPECT_NE(errorOf(cloud.view()).find("'far'"), std::string::npos);
}

TEST(FindPointFields, FindsTimesAndColoursByTheirUsualNames) {
  std::string error;
  for (const char* name : {"time", "t", "timestamp", "time_stamp", "offset_time", "time_offset"}) {
    CloudBuilder cloud = emptyXyz(ScalarType::kFloat32, 0);
    cloud.layout.append(name, ScalarType::kUint32);
    const auto fields = findPointFields(cloud.view(), &error);
    ASSERT_TRUE(fields && fields->time) << name;
    EXPECT_EQ(fields->time->name, name);
    EXPECT_FALSE(fields->color);
  }
  for (const char* name : {"rgb", "rgba"}) {
    CloudBuilder cloud = emptyXyz(ScalarType::kFloat32, 0);
    cloud.layout.append(name, ScalarType::kFloat32);
    const auto fields = findPointFields(cloud.view(), &error);
    ASSERT_TRUE(fields && fields->color) << name;
    EXPECT_FALSE(fields->time);
  }
  CloudBuilder odd = emptyXyz(ScalarType::kFloat32, 0);
  odd.layout.append("rgb", ScalarType::kUint8);  // no packed colour fits
  EXPECT_FALSE(findPointFields(odd.view(), &error)->color);
}

TEST(ReadPositions, NoPoints) {
  CloudBuilder cloud = emptyXyz(ScalarType::kFloat32, 0);
  EXPECT_TRUE(positionsOf(cloud.view()).empty());
  cloud.layout.width = 5;
  cloud.layout.height = 0;
  EXPECT_TRUE(positionsOf(cloud.view()).empty());
}

TEST(ReadPositions, NanAndInfinityPassThrough) {
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  const CloudBuilder cloud = test::xyzCloud({{nan, 1, 2}, {1, inf, -inf}});
  const auto positions = positionsOf(cloud.view());
  EXPECT_TRUE(std::isnan(positions[0].x()));
  EXPECT_EQ(positions[1], Vector3d(1, inf, -inf));
}

TEST(ReadColors, TheBitsOfAnyFourByteType) {
  for (const bool big_endian : {false, true}) {
    for (const ScalarType type : {ScalarType::kFloat32, ScalarType::kUint32, ScalarType::kInt32}) {
      CloudBuilder cloud = emptyXyz(ScalarType::kFloat32, 3);
      cloud.layout.append("rgb", type);
      cloud.layout.big_endian = big_endian;
      cloud.layout.pack();
      cloud.allocate();
      // The second is a signalling NaN as a float, the third carries alpha.
      const uint32_t bits[] = {0x00123456, 0x7f800001, 0xfff0e0d0};
      for (int i = 0; i < 3; ++i) cloud.setBits(0, i, "rgb", bits[i]);
      std::vector<uint32_t> rgb;
      readColors(cloud.view(), *cloud.layout.find("rgb"), &rgb);
      EXPECT_EQ(rgb, (std::vector<uint32_t>{0x123456, 0x800001, 0xf0e0d0}));
    }
  }
}

/// Offsets read from a time field of these values; empty when refused.
std::vector<float> offsetsOf(ScalarType type, const std::vector<double>& times, double stamp_s,
                             bool* good) {
  CloudBuilder cloud;
  cloud.layout.append("t", type);
  cloud.layout.width = static_cast<uint32_t>(times.size());
  cloud.layout.pack();
  cloud.allocate();
  for (std::size_t i = 0; i < times.size(); ++i) cloud.set(0, i, "t", times[i]);
  std::vector<float> offsets = {7.0F};
  *good = readTimeOffsets(cloud.view(), cloud.layout.fields[0], stamp_s, kMaxOffset_s, &offsets);
  return offsets;
}

void expectOffsets(ScalarType type, const std::vector<double>& times, double stamp_s,
                   const std::vector<float>& expected) {
  bool good = false;
  const std::vector<float> offsets = offsetsOf(type, times, stamp_s, &good);
  ASSERT_TRUE(good);
  ASSERT_EQ(offsets.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(offsets[i], expected[i], 1e-6);
}

TEST(ReadTimeOffsets, UnitsOfTheDriversInUse) {
  const double stamp_s = 1.6e9 + 0.25;
  expectOffsets(ScalarType::kFloat32, {-0.05, 0.0, 0.1}, stamp_s, {-0.05F, 0.0F, 0.1F});
  expectOffsets(ScalarType::kFloat64, {-0.05, 0.0, 0.1}, stamp_s, {-0.05F, 0.0F, 0.1F});
  expectOffsets(ScalarType::kUint32, {0.0, 5e7, 1e8}, stamp_s, {0.0F, 0.05F, 0.1F});
  expectOffsets(ScalarType::kInt32, {-5e7, 1e8}, stamp_s, {-0.05F, 0.1F});
  expectOffsets(ScalarType::kFloat64, {stamp_s - 0.1, stamp_s + 0.05}, stamp_s, {-0.1F, 0.05F});
  expectOffsets(ScalarType::kFloat64, {stamp_s * 1e9 - 1e8, stamp_s * 1e9 + 5e7}, stamp_s,
                {-0.1F, 0.05F});
  expectOffsets(ScalarType::kFloat32, {}, stamp_s, {});
}

TEST(ReadTimeOffsets, AbsurdTimesAreRefused) {
  const double stamp_s = 1.6e9;
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), inf, -inf, 1.01, -1.01, stamp_s + 1.5, stamp_s - 1.5,
                           (stamp_s + 2.0) * 1e9, 1e300}) {
    bool good = true;
    EXPECT_TRUE(offsetsOf(ScalarType::kFloat64, {0.0, bad, 0.01}, stamp_s, &good).empty()) << bad;
    EXPECT_FALSE(good) << bad;
  }
  bool good = true;
  EXPECT_TRUE(offsetsOf(ScalarType::kUint32, {0.0, 4e9}, stamp_s, &good).empty());
  EXPECT_FALSE(good);
}

}  // namespace
}  // namespace ladar_perception
