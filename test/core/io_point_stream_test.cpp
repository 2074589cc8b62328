// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "io_test_files.h"
#include "ladar_perception/io/point_stream.h"

namespace ladar_perception {
namespace {

/// A road from west to east that rises to the east, with a wall along it. The file has the wall
/// first, as surveyed tiles have their objects one after the other.
Scan makeRoad() {
  std::vector<Column> columns = {{"x", ScalarType::kFloat64, {}},
                                 {"y", ScalarType::kFloat64, {}},
                                 {"z", ScalarType::kFloat64, {}},
                                 {"label", ScalarType::kUint16, {}}};
  const auto add = [&](double x, double y, double z, double label) {
    columns[0].values.push_back(4e5 + x);
    columns[1].values.push_back(5e6 + y);
    columns[2].values.push_back(0.1 * x + z);
    columns[3].values.push_back(label);
  };
  for (int i = 0; i < 1000; ++i) add(0.1 * i, 5.0, 1.0 + i % 10, 1400);
  for (int i = 0; i < 3000; ++i) add(0.1 * (i / 3), i % 3 - 1.0, 0.0, 1203);
  return makeScan(columns);
}

TEST(IoPointStream, PutsEveryPointInOneScan) {
  const Scan road = makeRoad();
  for (const StreamOrder order : {StreamOrder::kSweep, StreamOrder::kFile}) {
    std::vector<int> times(road.size(), 0);
    for (const StreamScan& scan : cutStream(road, {300, order})) {
      EXPECT_GE(scan.points.size(), 150u);
      EXPECT_LE(scan.points.size(), 450u);
      for (const std::size_t i : scan.points) ++times[i];
    }
    EXPECT_EQ(std::count(times.begin(), times.end(), 1), static_cast<long>(road.size()));
  }
}

TEST(IoPointStream, DrivesAlongTheRoadOnTheGround) {
  const std::vector<StreamScan> scans = cutStream(makeRoad(), {400, StreamOrder::kSweep});
  ASSERT_EQ(scans.size(), 10u);
  for (std::size_t i = 1; i + 1 < scans.size(); ++i) {
    const Eigen::Vector3d p = scans[i].T_map_vehicle.translation();
    EXPECT_NEAR(p.x(), 4e5 + 10.0 * static_cast<double>(i) + 5.0, 2.0);
    EXPECT_NEAR(p.y(), 5e6, 1.0);
    EXPECT_NEAR(p.z(), 0.1 * (p.x() - 4e5), 0.5);
  }
}

TEST(IoPointStream, ExpressesPointsInTheSensorFrame) {
  const Scan road = makeRoad();
  const StreamScan scan = cutStream(road, {400, StreamOrder::kSweep})[3];
  Eigen::Isometry3d T_map_sensor = scan.T_map_vehicle;
  T_map_sensor.translate(Eigen::Vector3d(0, 0, 2));
  const Scan taken = takeStreamScan(road, scan, T_map_sensor);
  EXPECT_EQ(taken.layout.describeFields(), "x:float32, y:float32, z:float32, label:uint16");
  const char* axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    const std::vector<double> p_map = readColumn(road, axes[k], scan.points);
    const std::vector<double> p_sensor = readColumn(taken, axes[k]);
    for (std::size_t i = 0; i < p_map.size(); ++i) {
      EXPECT_NEAR(p_sensor[i] + T_map_sensor.translation()[k], p_map[i], 1e-4);
    }
  }
  EXPECT_EQ(readColumn(taken, "label"), readColumn(road, "label", scan.points));
}

TEST(IoPointStream, StandsInvalidAndFewPoints) {
  const double nan = std::nan("");
  const Scan few = makeScan({{"x", ScalarType::kFloat32, {nan, 1, nan}},
                             {"y", ScalarType::kFloat32, {nan, 2, nan}},
                             {"z", ScalarType::kFloat32, {nan, 3, nan}}});
  const std::vector<StreamScan> scans = cutStream(few, {10, StreamOrder::kSweep});
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_TRUE(scans[0].T_map_vehicle.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
  const Scan taken = takeStreamScan(few, scans[0], scans[0].T_map_vehicle);
  EXPECT_EQ(taken.size(), 3u);
  EXPECT_FALSE(taken.is_dense);
  for (const StreamScan& scan : cutStream(few, {1, StreamOrder::kSweep})) {
    EXPECT_TRUE(scan.T_map_vehicle.translation().allFinite());
  }
}

}  // namespace
}  // namespace ladar_perception
