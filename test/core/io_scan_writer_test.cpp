// SPDX-License-Identifier: BSD-3-Clause
// What is written is read again, with every field.
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "io_test_files.h"
#include "ladar_perception/io/scan_writer.h"

namespace ladar_perception {
namespace {

using Values = std::vector<double>;

const double kNaN = std::nan("");

/// A number whose float32 has the bits 0x00RRGGBB.
double colorBits(uint32_t rgb) {
  float value = 0.0F;
  std::memcpy(&value, &rgb, sizeof value);
  return value;
}

uint32_t bitsOfColor(double value) {
  const auto single = static_cast<float>(value);
  uint32_t bits = 0;
  std::memcpy(&bits, &single, sizeof bits);
  return bits;
}

Scan everyType() {
  return makeScan(
      {{"x", ScalarType::kFloat64, {4567890.125, -2.0, kNaN}},
       {"y", ScalarType::kFloat64, {0.1, 2.0, kNaN}},
       {"z", ScalarType::kFloat64, {-1e-7, 3.0, kNaN}},
       {"rgb", ScalarType::kFloat32, {colorBits(0x010203), colorBits(0xfffefd), 0.0}},
       {"normal_x", ScalarType::kFloat32, {0.5, -0.5, 0.0}},
       {"normal_y", ScalarType::kFloat32, {0.25, 0.0, 1.0}},
       {"normal_z", ScalarType::kFloat32, {0.75, 0.0, 0.0}},
       {"a", ScalarType::kInt8, {-128, 0, 127}},
       {"b", ScalarType::kUint8, {0, 128, 255}},
       {"c", ScalarType::kInt16, {-32768, 0, 32767}},
       {"d", ScalarType::kUint16, {0, 1, 65535}},
       {"e", ScalarType::kInt32, {-2147483648.0, 0, 2147483647}},
       {"f", ScalarType::kUint32, {0, 1, 4294967295.0}},
       {"radius", ScalarType::kFloat32, {std::numeric_limits<double>::infinity(), 0.125, 1e-30}}});
}

std::string written(const Scan& scan, ScanFormat format) {
  std::ostringstream stream;
  writeScan(scan, format, &stream);
  return stream.str();
}

Scan rewritten(const Scan& scan, const std::string& name) {
  const ScanFormat format = writtenFormat(name);
  return readScan(writeFile(name, written(scan, format)), format);
}

void expectSameColumn(const Scan& scan, const Scan& again, const std::string& name) {
  const Values before = readColumn(scan, name);
  const Values after = readColumn(again, name);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (std::isnan(before[i])) {
      EXPECT_TRUE(std::isnan(after[i])) << name;
    } else {
      EXPECT_EQ(static_cast<float>(after[i]), static_cast<float>(before[i])) << name << " " << i;
    }
  }
}

class IoScanWriter : public ::testing::TestWithParam<const char*> {};

TEST_P(IoScanWriter, EveryTypeOfFieldComesBack) {
  const Scan scan = everyType();
  const Scan again = rewritten(scan, std::string("a") + GetParam());
  ASSERT_EQ(again.size(), 3u);
  EXPECT_FALSE(again.is_dense);
  for (const Field& field : scan.layout.fields) {
    if (field.name != "rgb") expectSameColumn(scan, again, field.name);
  }
  EXPECT_NEAR(readColumn(again, "x")[0], 4567890.125, 1e-9) << again.layout.describeFields();
  if (std::string(GetParam()) == ".xyz") {
    EXPECT_EQ(readColumn(again, "red"), (Values{1, 255, 0}));
    EXPECT_EQ(readColumn(again, "green"), (Values{2, 254, 0}));
    EXPECT_EQ(readColumn(again, "blue"), (Values{3, 253, 0}));
  } else {
    const Values colors = readColumn(again, "rgb");
    EXPECT_EQ(bitsOfColor(colors[0]) & 0xffffffU, 0x010203U);
    EXPECT_EQ(bitsOfColor(colors[1]) & 0xffffffU, 0xfffefdU);
  }
}

TEST_P(IoScanWriter, CloudsWithoutPointsAreFiles) {
  const Scan empty = makeScan({{"x", ScalarType::kFloat32, {}},
                               {"y", ScalarType::kFloat32, {}},
                               {"z", ScalarType::kFloat32, {}}});
  const std::string name = std::string("empty") + GetParam();
  if (writtenFormat(name) == ScanFormat::kXyz) {
    EXPECT_EQ(written(empty, ScanFormat::kXyz), "x y z\n");
  } else {
    EXPECT_EQ(rewritten(empty, name).size(), 0u);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, IoScanWriter, ::testing::Values(".pcd", ".ply", ".xyz"),
                         [](const auto& format) { return std::string(format.param + 1); });

TEST(IoScanWriter, KeepsRowsTypesAndWideFieldsOfPcd) {
  Scan scan = makeScan({{"x", ScalarType::kFloat32, {1, 2, 3, 4}},
                        {"y", ScalarType::kFloat32, {5, 6, 7, 8}},
                        {"z", ScalarType::kFloat32, {0, 0, 0, 0}},
                        {"my field", ScalarType::kUint16, {1, 2, 3, 4}},
                        {"more", ScalarType::kUint16, {5, 6, 7, 8}}});
  scan.layout.fields.pop_back();
  scan.layout.fields.back().count = 2;
  scan.layout.width = 2;
  scan.layout.height = 2;
  scan.layout.pack();
  const Scan again = rewritten(scan, "a.pcd");
  EXPECT_EQ(again.layout.width, 2u);
  EXPECT_EQ(again.layout.height, 2u);
  EXPECT_EQ(again.layout.describeFields(), "x:float32, y:float32, z:float32, my_field:uint16[2]");
  EXPECT_EQ(readColumn(again, "x"), (Values{1, 2, 3, 4}));
  EXPECT_EQ(written(scan, ScanFormat::kXyz).substr(0, 45),
            "x y z my_field_0 my_field_1\n1 5 0 1 5\n2 6 0 2");
}

TEST(IoScanWriter, PlyHasTheNamesThatOthersExpect) {
  const std::string ply = written(everyType(), ScanFormat::kPly);
  for (const char* line :
       {"format binary_little_endian 1.0\n", "element vertex 3\n", "property double x\n",
        "property uchar red\nproperty uchar green\nproperty uchar blue\n", "property float nx\n",
        "property char a\n", "property uint f\n"}) {
    EXPECT_NE(ply.find(line), std::string::npos) << line;
  }
}

TEST(IoScanWriter, RefusesOtherFormats) {
  EXPECT_EQ(writtenFormat("a/b.c/x.csv"), ScanFormat::kXyz);
  expectError([] { writtenFormat("x.bin"); }, {"x.bin", "'.bin'", ".pcd"});
  expectError([] { writtenFormat("pcd"); }, {"''", ".ply"});
  expectError([] { written(everyType(), ScanFormat::kVtk); }, {"vtk", "pcd, ply or xyz"});
  Scan scan = everyType();
  scan.layout.big_endian = true;
  expectError([&] { written(scan, ScanFormat::kPcd); }, {"big-endian"});
}

}  // namespace
}  // namespace ladar_perception
