// SPDX-License-Identifier: BSD-3-Clause
// Clouds no scan should be: each is counted under its reason, and the next good one is labelled.
#include <algorithm>
#include <cmath>
#include <limits>

#include "ros_terrain_client.h"

namespace ladar_perception::test {
namespace {

constexpr double kDensity = 0.2;

class BadData : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(terrain_.ready());
    terrain_->sendMount();
    terrain_->send(drive_.vehicleTransforms(0, 100));
    ASSERT_TRUE(terrain_->label(next()));
  }
  void TearDown() override {
    // Alive, and as good as before.
    const auto labeled = terrain_->label(next());
    ASSERT_TRUE(labeled);
    EXPECT_GT(recallOf(*labeled, kSurfaceLabel), 0.9);
    ASSERT_TRUE(terrain_->waitForStatistics([&](const auto& s) {
      return s.header.stamp == labeled->header.stamp;
    }));
    const TerrainStatistics& s = terrain_->statistics;
    EXPECT_EQ(s.points_in, s.points_inserted + sumOf(s.points_dropped));
  }
  sensor_msgs::PointCloud2 next() { return drive_.scan(scan_++, kDensity); }

  /// Points a scan claims, but no more than its data has room for.
  static uint64_t pointsThatCame(const sensor_msgs::PointCloud2& scan) {
    if (scan.point_step == 0) return 0;
    return std::min<uint64_t>(uint64_t{scan.width} * scan.height,
                              scan.data.size() / scan.point_step);
  }

  /// Expects that a scan is dropped for `reason`, all its points with it, and nothing else is.
  void expectDropped(const sensor_msgs::PointCloud2& scan, const std::string& reason) {
    SCOPED_TRACE(reason);
    const TerrainStatistics before = terrain_->statistics;
    const uint64_t drops = sumOf(before.scans_dropped);
    terrain_->send(scan);
    ASSERT_TRUE(terrain_->waitForStatistics(
        [&](const auto& s) { return sumOf(s.scans_dropped) > drops; }));
    const TerrainStatistics& after = terrain_->statistics;
    EXPECT_EQ(sumOf(after.scans_dropped), drops + 1);
    EXPECT_EQ(countOf(after.scans_dropped, reason), countOf(before.scans_dropped, reason) + 1);
    EXPECT_EQ(countOf(after.points_dropped, reason) - countOf(before.points_dropped, reason),
              pointsThatCame(scan));
  }

  Drive drive_;
  int scan_ = 0;
  LoadedTerrain terrain_{"/bad", {{"tf_timeout_s", 1.0}}};
};

TEST_F(BadData, EmptyClouds) {
  sensor_msgs::PointCloud2 scan = next();
  scan.width = 0;
  scan.row_step = 0;
  scan.data.clear();
  expectDropped(scan, "empty");
  sensor_msgs::PointCloud2 nothing;
  nothing.header = next().header;
  expectDropped(nothing, "empty");
}

TEST_F(BadData, FieldsThatCannotBeRead) {
  sensor_msgs::PointCloud2 no_z = next();
  no_z.fields[2].name = "depth";
  expectDropped(no_z, "bad_cloud");
  sensor_msgs::PointCloud2 no_fields = next();
  no_fields.fields.clear();
  expectDropped(no_fields, "bad_cloud");
  sensor_msgs::PointCloud2 no_type = next();
  no_type.fields[0].datatype = 0;
  expectDropped(no_type, "bad_cloud");
  sensor_msgs::PointCloud2 odd_type = next();
  odd_type.fields[3].datatype = 77;
  expectDropped(odd_type, "bad_cloud");
  sensor_msgs::PointCloud2 outside = next();
  outside.fields[2].offset = 0xfffffffe;
  expectDropped(outside, "bad_cloud");
  sensor_msgs::PointCloud2 endless = next();
  endless.fields[3].count = 0xffffffff;
  expectDropped(endless, "bad_cloud");
}

TEST_F(BadData, SizesThatContradictTheData) {
  sensor_msgs::PointCloud2 truncated = next();
  truncated.data.resize(truncated.data.size() / 2);
  expectDropped(truncated, "bad_cloud");
  sensor_msgs::PointCloud2 no_data = next();
  no_data.data.clear();
  expectDropped(no_data, "bad_cloud");
  sensor_msgs::PointCloud2 no_step = next();
  no_step.point_step = 0;
  expectDropped(no_step, "bad_cloud");
  sensor_msgs::PointCloud2 wide = next();
  wide.width = 0xffffffff;
  wide.height = 1;
  expectDropped(wide, "bad_cloud");
  sensor_msgs::PointCloud2 high = next();
  high.height = 0xffffffff;
  expectDropped(high, "bad_cloud");
  sensor_msgs::PointCloud2 overlapping = next();
  overlapping.row_step = 0;
  expectDropped(overlapping, "bad_cloud");
}

TEST_F(BadData, NeitherTimeNorPlace) {
  sensor_msgs::PointCloud2 no_stamp = next();
  no_stamp.header.stamp = ros::Time();
  expectDropped(no_stamp, "no_stamp");
  sensor_msgs::PointCloud2 elsewhere = next();
  elsewhere.header.frame_id = "elsewhere";
  expectDropped(elsewhere, "no_transform");
  sensor_msgs::PointCloud2 frameless = next();
  frameless.header.frame_id.clear();
  expectDropped(frameless, "no_transform");
}

TEST_F(BadData, APoseThatIsNone) {
  // Farther out than a map can be indexed.
  geometry_msgs::TransformStamped far = drive_.vehicleTransform(drive_.scanStamp(0));
  far.child_frame_id = "lost";
  far.header.frame_id = kVehicleFrame;
  far.transform.translation.x = 1e12;
  const sensor_msgs::PointCloud2 before = next();
  sensor_msgs::PointCloud2 scan = next();
  far.header.stamp = before.header.stamp;
  terrain_->send({far});
  far.header.stamp = scan.header.stamp + ros::Duration(0.01);
  terrain_->send({far});
  scan.header.frame_id = "lost";
  expectDropped(scan, "bad_pose");
}

TEST_F(BadData, PointsThatAreNotFiniteStayInPlace) {
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity()};
  CloudBuilder cloud = drive_.cloud(scan_, kDensity);
  const ros::Time stamp = drive_.scanStamp(scan_++);
  const std::size_t points = cloud.layout.pointCount();
  std::vector<bool> bad(points, false);
  uint64_t bad_count = 0;
  for (std::size_t i = 0; i < points; i += 7) {
    const char* axis = i % 3 == 0 ? "x" : i % 3 == 1 ? "y" : "z";
    cloud.set(i / cloud.layout.width, i % cloud.layout.width, axis, kBad[i % 5 % 3]);
    bad[i] = true;
    ++bad_count;
  }
  const uint64_t before = countOf(terrain_->statistics.points_dropped, "not_finite");
  const sensor_msgs::PointCloud2 scan = toMessage(cloud, stamp, kSensorFrame);
  const auto labeled = terrain_->label(scan);
  ASSERT_TRUE(labeled);
  EXPECT_EQ(labeled->width, scan.width);
  EXPECT_EQ(labeled->height, scan.height);
  EXPECT_FALSE(labeled->is_dense);
  const std::vector<double> label = fieldValues(*labeled, "label");
  const std::vector<double> confidence = fieldValues(*labeled, "confidence");
  ASSERT_EQ(label.size(), points);
  int known = 0;
  for (std::size_t i = 0; i < points; ++i) {
    if (bad[i]) {
      ASSERT_EQ(label[i], 0.0) << "point " << i;
      ASSERT_EQ(confidence[i], 0.0) << "point " << i;
    }
    known += label[i] > 0.0 ? 1 : 0;
  }
  EXPECT_GT(known, 0.9 * static_cast<double>(points - bad_count));
  for (const char* axis : {"x", "y", "z"}) {
    const std::vector<double> in = fieldValues(scan, axis);
    const std::vector<double> out = fieldValues(*labeled, axis);
    for (std::size_t i = 0; i < points; ++i) {
      ASSERT_TRUE(in[i] == out[i] || (std::isnan(in[i]) && std::isnan(out[i]))) << axis << i;
    }
  }
  ASSERT_TRUE(terrain_->waitForStatistics([&](const auto& s) { return s.header.stamp == stamp; }));
  EXPECT_EQ(countOf(terrain_->statistics.points_dropped, "not_finite"), before + bad_count);
}

TEST_F(BadData, NothingButNaN) {
  CloudBuilder cloud = drive_.cloud(scan_, kDensity);
  const ros::Time stamp = drive_.scanStamp(scan_++);
  for (std::size_t i = 0; i < cloud.layout.pointCount(); ++i) {
    cloud.set(i / cloud.layout.width, i % cloud.layout.width, "y",
              std::numeric_limits<double>::quiet_NaN());
  }
  const auto labeled = terrain_->label(toMessage(cloud, stamp, kSensorFrame));
  ASSERT_TRUE(labeled);
  EXPECT_EQ(fieldValues(*labeled, "label"), std::vector<double>(cloud.layout.pointCount(), 0.0));
}

TEST_F(BadData, OddButGoodClouds) {
  // A leading slash is a habit of old drivers, and a count of 0 means 1.
  sensor_msgs::PointCloud2 slash = next();
  slash.header.frame_id = std::string("/") + kSensorFrame;
  for (auto& field : slash.fields) field.count = 0;
  const auto labeled = terrain_->label(slash);
  ASSERT_TRUE(labeled);
  EXPECT_GT(recallOf(*labeled, kSurfaceLabel), 0.9);

  // The other byte order, in doubles.
  const CloudBuilder little = drive_.cloud(scan_, kDensity);
  CloudBuilder big;
  big.layout.big_endian = true;
  for (const char* name : {"x", "y", "z"}) big.layout.append(name, ScalarType::kFloat64);
  big.layout.append("truth", ScalarType::kUint8);
  big.layout.width = static_cast<uint32_t>(little.layout.pointCount());
  big.layout.pack();
  big.allocate();
  for (const char* name : {"x", "y", "z", "truth"}) {
    std::vector<double> values;
    readScalars(little.view(), *little.layout.find(name), &values);
    for (std::size_t i = 0; i < values.size(); ++i) big.set(0, i, name, values[i]);
  }
  const auto scan = toMessage(big, drive_.scanStamp(scan_++), kSensorFrame);
  const auto labeled_big = terrain_->label(scan);
  ASSERT_TRUE(labeled_big);
  EXPECT_TRUE(labeled_big->is_bigendian);
  EXPECT_EQ(fieldValues(*labeled_big, "x"), fieldValues(scan, "x"));
  EXPECT_GT(recallOf(*labeled_big, kSurfaceLabel), 0.9);
  EXPECT_GT(recallOf(*labeled_big, kLinearLabel), 0.9);
  const std::vector<double> confidence = fieldValues(*labeled_big, "confidence");
  for (const double value : confidence) ASSERT_TRUE(value >= 0.0 && value <= 1.0);
}

}  // namespace
}  // namespace ladar_perception::test

int main(int argc, char** argv) {
  return ladar_perception::test::runRosTest(argc, argv, "bad_data_test");
}
