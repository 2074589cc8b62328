// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cloud_builder.h"
#include "ladar_perception/cloud/point_reader.h"
#include "ladar_perception/resample/sample_cloud.h"

namespace ladar_perception::test {
namespace {

ResampledCloud threeSamples() {
  ResampledCloud samples;
  samples.positions_m = {{1.25, -2.5, 3.75}, {-1e3, 0.1, 0.0}, {4.0, 5.0, 6.0}};
  samples.normals = {{0, 0, 1}, {0.6F, 0, -0.8F}, {0, 1, 0}};
  samples.sources = {4, 0, 4};
  samples.covering_radii = {9.5F, 0.5F, 0.25F};
  samples.weights = {1, 1, 1};
  return samples;
}

/// 2 x 3 points of these fields, padded; "id" numbers them.
CloudBuilder originals(const std::vector<std::pair<std::string, ScalarType>>& fields,
                       bool big_endian) {
  CloudBuilder cloud;
  cloud.layout.big_endian = big_endian;
  for (const auto& [name, type] : fields) cloud.layout.append(name, type);
  cloud.layout.append("id", ScalarType::kUint16);
  cloud.layout.width = 3;
  cloud.layout.height = 2;
  cloud.layout.row_step = 3 * cloud.layout.point_step + 5;
  cloud.allocate();
  for (std::size_t i = 0; i < 6; ++i) {
    for (const Field& field : cloud.layout.fields) {
      cloud.set(i / 3, i % 3, field.name, static_cast<double>(i));
    }
  }
  return cloud;
}

struct Written {
  CloudLayout layout;
  std::vector<uint8_t> bytes;

  std::vector<double> values(const std::string& name) const {
    std::vector<double> values;
    const Field* field = layout.find(name);
    EXPECT_NE(field, nullptr) << name << " is not in " << layout.describeFields();
    if (field != nullptr) readScalars({layout, bytes.data(), bytes.size()}, *field, &values);
    return values;
  }
};

Written write(const CloudBuilder& cloud, const ResampledCloud& samples) {
  Written written;
  written.layout = sampleLayout(cloud.layout);
  EXPECT_EQ(written.layout.pointCount(), 0U);
  writeSampleCloud(cloud.view(), samples, &written.layout, &written.bytes);
  const CloudView view{written.layout, written.bytes.data(), written.bytes.size()};
  EXPECT_EQ(layoutError(view), "");
  EXPECT_EQ(written.bytes.size(), std::size_t{written.layout.row_step});
  return written;
}

using Values = std::vector<double>;

TEST(SampleCloud, HasTheSamplesPlaceAndTheOriginalsFields) {
  for (const bool big_endian : {false, true}) {
    const CloudBuilder cloud = originals({{"x", ScalarType::kFloat32},
                                          {"y", ScalarType::kFloat32},
                                          {"z", ScalarType::kFloat32},
                                          {"intensity", ScalarType::kUint8}},
                                         big_endian);
    const Written out = write(cloud, threeSamples());
    EXPECT_EQ(out.layout.big_endian, big_endian);
    EXPECT_EQ(out.layout.width, 3U);
    EXPECT_EQ(out.layout.height, 1U);
    EXPECT_EQ(out.layout.describeFields(),
              "x:float32, y:float32, z:float32, intensity:uint8, id:uint16, normal_x:float32, "
              "normal_y:float32, normal_z:float32, covering_radius:float32");
    EXPECT_EQ(out.values("x"), (Values{1.25, -1000.0, 4.0}));
    EXPECT_EQ(out.values("y"), (Values{-2.5, 0.1F, 5.0}));
    EXPECT_EQ(out.values("z"), (Values{3.75, 0.0, 6.0}));
    EXPECT_EQ(out.values("intensity"), (Values{4, 0, 4}));
    EXPECT_EQ(out.values("id"), (Values{4, 0, 4}));
    EXPECT_EQ(out.values("normal_x"), (Values{0, 0.6F, 0}));
    EXPECT_EQ(out.values("normal_z"), (Values{1, -0.8F, 0}));
    EXPECT_EQ(out.values("covering_radius"), (Values{9.5, 0.5, 0.25}));
  }
}

TEST(SampleCloud, DoublesStayDoubles) {
  const CloudBuilder cloud = originals(
      {{"x", ScalarType::kFloat64}, {"y", ScalarType::kFloat64}, {"z", ScalarType::kFloat64}},
      true);
  ResampledCloud samples = threeSamples();
  samples.positions_m[0].x() = 1e6 + 1e-7;
  EXPECT_EQ(write(cloud, samples).values("x")[0], 1e6 + 1e-7);
}

TEST(SampleCloud, WholeNumbersMakeWayForPlaces) {
  const CloudBuilder cloud = originals(
      {{"x", ScalarType::kInt16}, {"y", ScalarType::kInt16}, {"z", ScalarType::kInt16}}, false);
  const Written out = write(cloud, threeSamples());
  EXPECT_EQ(out.values("x"), (Values{1.25, -1000.0, 4.0}));
  EXPECT_EQ(out.values("x_input"), (Values{4, 0, 4}));
  EXPECT_EQ(out.layout.find("x")->type, ScalarType::kFloat32);
}

TEST(SampleCloud, FieldsOfOurNamesMakeWay) {
  const CloudBuilder cloud = originals({{"x", ScalarType::kFloat32},
                                        {"y", ScalarType::kFloat32},
                                        {"z", ScalarType::kFloat32},
                                        {"normal_x", ScalarType::kFloat32},
                                        {"covering_radius", ScalarType::kUint8}},
                                       false);
  const Written out = write(cloud, threeSamples());
  EXPECT_EQ(out.values("normal_x"), (Values{0, 0.6F, 0}));
  EXPECT_EQ(out.values("normal_x_input"), (Values{4, 0, 4}));
  EXPECT_EQ(out.values("covering_radius_input"), (Values{4, 0, 4}));
  // A cloud that was re-sampled once can be again.
  const CloudLayout again = sampleLayout(out.layout);
  EXPECT_NE(again.find("normal_x_input_input"), nullptr) << again.describeFields();
}

TEST(SampleCloud, NoSamplesAreAnEmptyCloud) {
  const CloudBuilder cloud = originals(
      {{"x", ScalarType::kFloat32}, {"y", ScalarType::kFloat32}, {"z", ScalarType::kFloat32}},
      false);
  const Written out = write(cloud, {});
  EXPECT_EQ(out.layout.pointCount(), 0U);
  EXPECT_TRUE(out.bytes.empty());
}

}  // namespace
}  // namespace ladar_perception::test
