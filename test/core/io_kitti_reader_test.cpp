// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "io_test_files.h"
#include "ladar_perception/io/kitti_reader.h"

namespace ladar_perception {
namespace {

using Values = std::vector<double>;

const std::string kTwoPoints = bytesOf<float>({1, 2, 3, 0.25f, 4, 5, 6, 0.5f});

TEST(IoKittiReader, ReadsPoints) {
  const Scan scan = readKittiScan(writeFile("000000.bin", kTwoPoints));
  EXPECT_EQ(scan.layout.describeFields(), "x:float32, y:float32, z:float32, intensity:float32");
  EXPECT_EQ(readColumn(scan, "y"), (Values{2, 5}));
  EXPECT_EQ(readColumn(scan, "intensity"), (Values{0.25, 0.5}));
  EXPECT_TRUE(scan.is_dense);
}

TEST(IoKittiReader, KeepsInvalidPointsAndReadsEmptyFiles) {
  const Scan scan =
      readKittiScan(writeFile("a.bin", bytesOf<float>({std::nanf(""), 0, 0, 0, 1, 1, 1, 1})));
  EXPECT_EQ(scan.size(), 2u);
  EXPECT_FALSE(scan.is_dense);
  EXPECT_EQ(readKittiScan(writeFile("b.bin", "")).size(), 0u);
}

TEST(IoKittiReader, NamesTheWrongSize) {
  const std::string path = writeFile("a.bin", kTwoPoints + "x");
  expectError([&] { readKittiScan(path); }, {path, "33 bytes", "multiple of 16"});
  expectError([] { readKittiScan("/nowhere.bin"); }, {"/nowhere.bin", "cannot be opened"});
}

TEST(IoKittiReader, FindsLabelsBesideAndInTheirFolder) {
  const uint32_t label = 40, instance = 3;
  const std::string labels = bytesOf<uint32_t>({label, label | instance << 16});
  const std::string beside = writeFile("a.bin", kTwoPoints);
  writeFile("a.label", labels);
  const std::string in_folder = writeFile("00/velodyne/b.bin", kTwoPoints);
  writeFile("00/labels/b.label", labels);
  for (const std::string& path : {beside, in_folder}) {
    const Scan scan = readKittiScan(path);
    EXPECT_EQ(readColumn(scan, "label"), (Values{40, 40}));
    EXPECT_EQ(readColumn(scan, "instance"), (Values{0, 3}));
    EXPECT_EQ(readColumn(scan, "z"), (Values{3, 6}));
  }
}

TEST(IoKittiReader, NamesTheWrongCountOfLabels) {
  const std::string path = writeFile("a.bin", kTwoPoints);
  const std::string labels = writeFile("a.label", bytesOf<uint32_t>({1, 2, 3}));
  expectError([&] { readKittiScan(path); }, {labels, "3 labels", "expected 2"});
  writeFile("a.label", "12345");
  expectError([&] { readKittiScan(path); }, {labels, "5 bytes", "multiple of 4"});
}

}  // namespace
}  // namespace ladar_perception
