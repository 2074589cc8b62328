// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "ladar_perception/cloud/cloud_layout.h"

namespace ladar_perception {
namespace {

/// 2 rows of 3 points of float32 x, y, z, without padding.
CloudLayout smallLayout() {
  CloudLayout layout;
  for (const char* name : {"x", "y", "z"}) layout.append(name, ScalarType::kFloat32);
  layout.width = 3;
  layout.height = 2;
  layout.pack();
  return layout;
}

std::string errorFor(const CloudLayout& layout, std::size_t bytes) {
  return layoutError({layout, nullptr, bytes});
}

void expectMentions(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
  }
}

TEST(ScalarType, SizesAndNames) {
  const std::pair<std::size_t, const char*> expected[] = {
      {1, "int8"},  {1, "uint8"},  {2, "int16"},   {2, "uint16"},
      {4, "int32"}, {4, "uint32"}, {4, "float32"}, {8, "float64"}};
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(scalarSize(static_cast<ScalarType>(i + 1)), expected[i].first);
    EXPECT_EQ(scalarName(static_cast<ScalarType>(i + 1)), expected[i].second);
  }
  EXPECT_EQ(scalarSize(static_cast<ScalarType>(0)), 0U);
  EXPECT_EQ(scalarSize(static_cast<ScalarType>(9)), 0U);
  EXPECT_EQ(scalarName(static_cast<ScalarType>(9)), "invalid(9)");
}

TEST(CloudLayout, AppendsAtTheFieldsOwnAlignment) {
  CloudLayout layout;
  EXPECT_EQ(layout.append("a", ScalarType::kUint8).offset, 0U);
  EXPECT_EQ(layout.append("b", ScalarType::kFloat64).offset, 8U);
  EXPECT_EQ(layout.append("c", ScalarType::kUint16).offset, 16U);
  EXPECT_EQ(layout.append("d", ScalarType::kFloat32).offset, 20U);
  EXPECT_EQ(layout.append("e", ScalarType::kInt8).offset, 24U);
  EXPECT_EQ(layout.point_step, 25U);
  layout.width = 7;
  layout.pack();
  EXPECT_EQ(layout.row_step, 175U);
}

TEST(CloudLayout, FindsAndDescribesFields) {
  CloudLayout layout = smallLayout();
  layout.fields.push_back({"normal", 12, ScalarType::kFloat64, 3});
  ASSERT_NE(layout.find("y"), nullptr);
  EXPECT_EQ(layout.find("y")->offset, 4U);
  EXPECT_EQ(layout.find("Y"), nullptr);
  EXPECT_EQ(layout.describeFields(), "x:float32, y:float32, z:float32, normal:float64[3]");
  EXPECT_EQ(CloudLayout().describeFields(), "none");
}

TEST(CloudLayout, CountsPointsWithoutOverflow) {
  CloudLayout layout;
  layout.width = 1U << 20;
  layout.height = 1U << 20;
  EXPECT_EQ(layout.pointCount(), std::size_t{1} << 40);
}

TEST(CloudView, PointsAreWhereTheStepsSay) {
  CloudLayout layout = smallLayout();
  layout.row_step = 50;
  const uint8_t bytes[100] = {};
  const CloudView view{layout, bytes, sizeof(bytes)};
  EXPECT_EQ(view.point(0, 0), bytes);
  EXPECT_EQ(view.point(1, 2), bytes + 50 + 24);
}

TEST(LayoutError, GoodLayoutsPass) {
  EXPECT_EQ(errorFor(smallLayout(), 72), "");
  EXPECT_EQ(errorFor(smallLayout(), 1000), "");
  CloudLayout padded = smallLayout();
  padded.point_step = 32;
  padded.row_step = 100;
  // The last row need not be padded.
  EXPECT_EQ(errorFor(padded, 196), "");
  padded.fields[2].count = 0;  // means 1
  EXPECT_EQ(errorFor(padded, 196), "");
}

TEST(LayoutError, NoPointsNeedNoBytes) {
  CloudLayout layout = smallLayout();
  layout.width = 0;
  EXPECT_EQ(errorFor(layout, 0), "");
  layout.width = 3;
  layout.height = 0;
  EXPECT_EQ(errorFor(layout, 0), "");
}

TEST(LayoutError, TruncatedData) {
  expectMentions(errorFor(smallLayout(), 71), {"71", "72", "3 x 2"});
  CloudLayout padded = smallLayout();
  padded.row_step = 100;
  EXPECT_EQ(errorFor(padded, 136), "");
  expectMentions(errorFor(padded, 135), {"135", "136"});
}

TEST(LayoutError, RowsThatOverlap) {
  CloudLayout layout = smallLayout();
  layout.row_step = 35;
  expectMentions(errorFor(layout, 1000), {"row_step", "35", "36"});
  // Of a single row the step does not matter; drivers leave it 0.
  layout.height = 1;
  layout.row_step = 0;
  EXPECT_EQ(errorFor(layout, 36), "");
}

TEST(LayoutError, FieldsBeyondThePoint) {
  CloudLayout layout = smallLayout();
  layout.fields[1].offset = 9;
  expectMentions(errorFor(layout, 72), {"'y'", "13", "12"});
  layout = smallLayout();
  layout.fields[0].count = 4;
  expectMentions(errorFor(layout, 72), {"'x'", "16", "12"});
  layout = smallLayout();
  layout.fields[0].offset = UINT32_MAX;
  layout.fields[0].count = UINT32_MAX;
  expectMentions(errorFor(layout, 72), {"'x'"});
}

TEST(LayoutError, UnknownTypesAndPointsOfNoBytes) {
  CloudLayout layout = smallLayout();
  layout.fields[2].type = static_cast<ScalarType>(0);
  expectMentions(errorFor(layout, 72), {"'z'", "datatype 0"});
  layout.fields.clear();
  layout.point_step = 0;
  expectMentions(errorFor(layout, 72), {"point_step"});
}

TEST(LayoutError, HugeShapesDoNotWrapAround) {
  CloudLayout layout = smallLayout();
  layout.width = UINT32_MAX;
  layout.height = 2;
  layout.row_step = UINT32_MAX;
  EXPECT_NE(errorFor(layout, 72), "");
  layout.width = 1;
  layout.height = UINT32_MAX;
  EXPECT_NE(errorFor(layout, 72), "");
}

}  // namespace
}  // namespace ladar_perception
