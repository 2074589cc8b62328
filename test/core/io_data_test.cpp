// SPDX-License-Identifier: BSD-3-Clause
// The readers on real files; skipped where there are none (see LADAR_DATA).
#include "io_test_files.h"
#include "ladar_perception/io/class_mapping.h"
#include "ladar_perception/io/point_stream.h"
#include "ladar_perception/io/pose_file.h"
#include "ladar_perception/io/scan_file.h"

namespace ladar_perception {
namespace {

class IoData : public ::testing::Test {
 protected:
  void SetUp() override {
    if (dataFolder().empty()) GTEST_SKIP() << "no data: set LADAR_DATA to its folder";
  }

  static void expectScan(const std::string& file, ScanFormat format, std::size_t points,
                         const std::string& fields) {
    const std::string path = dataFolder() + "/" + file;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
    const Scan scan = readScan(path, format);
    EXPECT_EQ(scan.size(), points) << path;
    EXPECT_EQ(scan.layout.describeFields(), fields) << path;
    EXPECT_TRUE(scan.is_dense) << path;
  }
};

TEST_F(IoData, Kitti) {
  expectScan("kitti00/000000.bin", ScanFormat::kKitti, 124668,
             "x:float32, y:float32, z:float32, intensity:float32");
}

TEST_F(IoData, PcdBinary) {
  expectScan("hdl_pair/251370668.pcd", ScanFormat::kPcd, 69088,
             "x:float32, y:float32, z:float32, intensity:float32");
}

TEST_F(IoData, PcdCompressed) {
  expectScan("pjlab/2021-10-26-16-21-29-468.pcd", ScanFormat::kPcd, 80787,
             "x:float32, y:float32, z:float32, intensity:float32, ring:uint16, timestamp:float64");
}

TEST_F(IoData, PcdAsciiOfAnOldVersion) {
  expectScan("pcl_outdoor/lamppost.pcd", ScanFormat::kPcd, 1771, "x:float32, y:float32, z:float32");
}

TEST_F(IoData, Vtk) {
  expectScan("norlab_car/cloud.00000.vtk", ScanFormat::kVtk, 24989,
             "x:float32, y:float32, z:float32");
}

TEST_F(IoData, CsvWithHeader) {
  expectScan("norlab_car/car_cloud400.csv", ScanFormat::kXyz, 24989,
             "x:float32, y:float32, z:float32, nx:float32, ny:float32, nz:float32");
}

TEST_F(IoData, Poses) {
  const std::string path = dataFolder() + "/kitti00/icp_reference_T_lidar0_lidari.txt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Poses poses = readPoses(path, PoseFormat::kKitti);
  ASSERT_EQ(poses.T_map_lidar.size(), 16u);
  EXPECT_NEAR(poses.T_map_lidar[1].translation().x(), 0.683534770, 1e-9);
}

TEST_F(IoData, OaklandStreamStaysAroundTheVehicle) {
  const std::string path = dataFolder() + "/oakland/tiles/oakland_part3_an.xyz_label_conf";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Scan tile = readScan(path, ScanFormat::kOakland);
  addTruth(tile, "label", loadClassMapping(LADAR_SOURCE_DIR "/config/classes/oakland_three.yaml"));
  std::size_t near = 0;
  std::size_t total = 0;
  for (const StreamScan& scan : cutStream(tile, StreamConfig())) {
    const Scan taken = takeStreamScan(tile, scan, scan.T_map_vehicle);
    const std::vector<double> x = readColumn(taken, "x");
    const std::vector<double> y = readColumn(taken, "y");
    const std::vector<double> z = readColumn(taken, "z");
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (std::abs(x[i]) <= 20 && std::abs(y[i]) <= 20 && z[i] >= -2 && z[i] <= 18) ++near;
    }
    total += taken.size();
  }
  EXPECT_EQ(total, 100000u);
  EXPECT_GT(near, total * 9 / 10);
}

}  // namespace
}  // namespace ladar_perception
