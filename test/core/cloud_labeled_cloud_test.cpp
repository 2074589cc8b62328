// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "cloud_builder.h"
#include "ladar_perception/cloud/labeled_cloud.h"
#include "ladar_perception/cloud/point_reader.h"
#include "test_random.h"

namespace ladar_perception {
namespace {

using test::CloudBuilder;
using test::TestRandom;

/// Random bytes in an odd layout with padding everywhere.
CloudBuilder randomCloud(uint32_t width, uint32_t height, bool big_endian) {
  CloudBuilder cloud;
  CloudLayout& layout = cloud.layout;
  layout.fields = {{"z", 1, ScalarType::kFloat32, 1},   {"x", 7, ScalarType::kFloat64, 1},
                   {"y", 15, ScalarType::kInt16, 1},    {"covariance", 18, ScalarType::kFloat32, 3},
                   {"ring", 30, ScalarType::kUint8, 0}, {"t", 31, ScalarType::kUint32, 1}};
  layout.point_step = 37;
  layout.width = width;
  layout.height = height;
  layout.row_step = width * 37 + 9;
  layout.big_endian = big_endian;
  cloud.allocate();
  TestRandom random(1);
  for (uint8_t& byte : cloud.bytes) byte = static_cast<uint8_t>(random.integer(0, 255));
  return cloud;
}

std::vector<PointLabel> someLabels(std::size_t count) {
  std::vector<PointLabel> labels;
  for (std::size_t i = 0; i < count; ++i) {
    const auto n = static_cast<uint32_t>(i);
    labels.push_back({static_cast<uint8_t>(n % 17), 0.01F * static_cast<float>(n % 100),
                      (n * 7919) & 0xffffffU});
  }
  return labels;
}

void expectAdded(const CloudLayout& layout, const std::vector<uint8_t>& bytes,
                 const std::vector<PointLabel>& labels) {
  const CloudView view{layout, bytes.data(), bytes.size()};
  ASSERT_EQ(layoutError(view), "");
  std::vector<uint32_t> rgb;
  std::vector<double> label;
  std::vector<double> confidence;
  readColors(view, *layout.find("rgb"), &rgb);
  readScalars(view, *layout.find("label"), &label);
  readScalars(view, *layout.find("confidence"), &confidence);
  ASSERT_EQ(rgb.size(), labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    EXPECT_EQ(rgb[i], labels[i].rgb);
    EXPECT_EQ(label[i], labels[i].label);
    EXPECT_EQ(confidence[i], static_cast<double>(labels[i].confidence));
  }
}

TEST(LabeledLayout, KeepsEveryFieldAndAddsThree) {
  const CloudBuilder cloud = randomCloud(5, 2, false);
  const CloudLayout output = labeledLayout(cloud.layout);
  ASSERT_EQ(output.fields.size(), cloud.layout.fields.size() + 3);
  for (std::size_t i = 0; i < cloud.layout.fields.size(); ++i) {
    EXPECT_EQ(output.fields[i].name, cloud.layout.fields[i].name);
    EXPECT_EQ(output.fields[i].offset, cloud.layout.fields[i].offset);
    EXPECT_EQ(output.fields[i].type, cloud.layout.fields[i].type);
    EXPECT_EQ(output.fields[i].count, cloud.layout.fields[i].count);
  }
  EXPECT_EQ(output.find("rgb")->type, ScalarType::kFloat32);
  EXPECT_EQ(output.find("confidence")->type, ScalarType::kFloat32);
  EXPECT_EQ(output.find("label")->type, ScalarType::kUint8);
  for (const char* name : {"rgb", "confidence", "label"}) {
    EXPECT_GE(output.find(name)->offset, cloud.layout.point_step);
  }
  EXPECT_EQ(output.width, 5U);
  EXPECT_EQ(output.height, 2U);
  EXPECT_EQ(output.row_step, 5 * output.point_step);
}

TEST(LabeledLayout, FieldsInTheWayAreRenamed) {
  CloudLayout input;
  for (const char* name : {"x", "label", "label_input", "rgb", "confidence"}) {
    input.append(name, ScalarType::kUint32);
  }
  const CloudLayout output = labeledLayout(input);
  const char* expected[] = {
      "x",   "label_input_input", "label_input", "rgb_input", "confidence_input",
      "rgb", "confidence",        "label"};
  ASSERT_EQ(output.fields.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(output.fields[i].name, expected[i]);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(output.fields[i].offset, 4 * i);
  EXPECT_EQ(output.find("label")->type, ScalarType::kUint8);
}

class WriteLabeledCloud : public testing::TestWithParam<bool> {};

TEST_P(WriteLabeledCloud, EveryInputByteStaysAndRowsArePacked) {
  const CloudBuilder cloud = randomCloud(6, 4, GetParam());
  const CloudLayout layout = labeledLayout(cloud.layout);
  const std::vector<PointLabel> labels = someLabels(24);
  std::vector<uint8_t> output = {1, 2, 3};
  writeLabeledCloud(cloud.view(), labels, layout, &output);
  ASSERT_EQ(output.size(), std::size_t{24} * layout.point_step);
  for (std::size_t i = 0; i < 24; ++i) {
    const uint8_t* in = cloud.view().point(i / 6, i % 6);
    EXPECT_TRUE(std::equal(in, in + 37, output.data() + i * layout.point_step)) << i;
  }
  EXPECT_EQ(layout.big_endian, GetParam());
  expectAdded(layout, output, labels);
}

TEST_P(WriteLabeledCloud, ARenamedFieldKeepsItsValues) {
  CloudBuilder cloud = test::xyzCloud({{1, 2, 3}, {4, 5, 6}});
  cloud.layout.append("label", ScalarType::kInt16);
  cloud.layout.big_endian = GetParam();
  cloud.layout.pack();
  cloud.allocate();
  cloud.set(0, 0, "label", -300);
  cloud.set(0, 1, "label", 1234);
  const CloudLayout layout = labeledLayout(cloud.layout);
  std::vector<uint8_t> output;
  writeLabeledCloud(cloud.view(), someLabels(2), layout, &output);
  std::vector<double> values;
  readScalars({layout, output.data(), output.size()}, *layout.find("label_input"), &values);
  EXPECT_EQ(values, (std::vector<double>{-300, 1234}));
  expectAdded(layout, output, someLabels(2));
}

TEST_P(WriteLabeledCloud, TheSameInputGivesTheSameBytes) {
  // Bytes no field covers are defined too: bags are compared byte by byte.
  const CloudBuilder cloud = randomCloud(3, 1, GetParam());
  const CloudLayout layout = labeledLayout(cloud.layout);
  std::vector<uint8_t> first(1000, 0xff);
  std::vector<uint8_t> second;
  writeLabeledCloud(cloud.view(), someLabels(3), layout, &first);
  writeLabeledCloud(cloud.view(), someLabels(3), layout, &second);
  EXPECT_EQ(first, second);
}

TEST_P(WriteLabeledCloud, EmptyClouds) {
  for (const auto& [width, height] : {std::pair<uint32_t, uint32_t>{0, 1}, {0, 5}, {5, 0}}) {
    const CloudBuilder cloud = randomCloud(width, height, GetParam());
    std::vector<uint8_t> output = {1};
    writeLabeledCloud(cloud.view(), {}, labeledLayout(cloud.layout), &output);
    EXPECT_TRUE(output.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(ByteOrders, WriteLabeledCloud, testing::Bool(),
                         [](const auto& order) { return order.param ? "big" : "little"; });

TEST(LabeledCloud, TheCamerasColorIsNotTheClasss) {
  CloudLayout raw;
  EXPECT_EQ(cameraColorField(raw), nullptr);
  raw.append("rgb", ScalarType::kFloat32);
  ASSERT_NE(cameraColorField(raw), nullptr);
  EXPECT_EQ(cameraColorField(raw)->name, "rgb");
  const CloudLayout labeled = labeledLayout(raw);
  ASSERT_NE(cameraColorField(labeled), nullptr);
  EXPECT_EQ(cameraColorField(labeled)->name, "rgb_input");
  EXPECT_EQ(cameraColorField(labeledLayout({})), nullptr) << "of a cloud without colours";

  CloudLayout alpha;
  alpha.append("label", ScalarType::kUint8);  // of another labeller, which gives no colours
  alpha.append("rgba", ScalarType::kUint32);
  ASSERT_NE(cameraColorField(alpha), nullptr);
  EXPECT_EQ(cameraColorField(alpha)->name, "rgba");
  CloudLayout odd;
  odd.append("rgb", ScalarType::kFloat64);
  EXPECT_EQ(cameraColorField(odd), nullptr) << "not the bits of a colour";
}

}  // namespace
}  // namespace ladar_perception
