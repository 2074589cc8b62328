// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include "io_test_files.h"
#include "ladar_perception/io/scan.h"

namespace ladar_perception {
namespace {

Scan makeTestScan() {
  return makeScan({{"x", ScalarType::kFloat32, {1, 2}},
                   {"y", ScalarType::kFloat32, {3, 4}},
                   {"z", ScalarType::kFloat32, {5, 6}}});
}

TEST(IoScan, KeepsTheExtremesOfEveryType) {
  const auto expectKept = [](ScalarType type, const std::vector<double>& values) {
    Scan scan = makeTestScan();
    addColumn(scan, {"value", type, values});
    EXPECT_EQ(readColumn(scan, "value"), values) << scalarName(type);
    EXPECT_EQ(readColumn(scan, "z"), (std::vector<double>{5, 6}));
    EXPECT_EQ(layoutError({scan.layout, scan.data.data(), scan.data.size()}), "");
  };
  expectKept(ScalarType::kInt8, {-128, 127});
  expectKept(ScalarType::kUint8, {0, 255});
  expectKept(ScalarType::kInt16, {-32768, 32767});
  expectKept(ScalarType::kUint16, {0, 65535});
  expectKept(ScalarType::kInt32, {-2147483648.0, 2147483647.0});
  expectKept(ScalarType::kUint32, {0, 4294967295.0});
  expectKept(ScalarType::kFloat32, {-0.5, 1.0e30f});
  expectKept(ScalarType::kFloat64, {0.1, 1e300});
}

TEST(IoScan, ReadsRowsWithPadding) {
  Scan scan = makeTestScan();
  // The same two points as two rows of one point and four bytes of padding.
  scan.layout.width = 1;
  scan.layout.height = 2;
  scan.layout.row_step = scan.layout.point_step + 4;
  scan.data.insert(scan.data.begin() + scan.layout.point_step, 4, uint8_t{0xFF});
  EXPECT_EQ(readColumn(scan, "y"), (std::vector<double>{3, 4}));
  addColumn(scan, {"label", ScalarType::kUint8, {7, 8}});
  EXPECT_EQ(readColumn(scan, "y"), (std::vector<double>{3, 4}));
  EXPECT_EQ(readColumn(scan, "label"), (std::vector<double>{7, 8}));
  EXPECT_EQ(readColumn(scan, "label", {1}), (std::vector<double>{8}));
}

TEST(IoScan, IsDenseOnlyIfEveryCoordinateIsFinite) {
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(makeTestScan().is_dense);
  for (const double bad : {nan, inf, -inf}) {
    const Scan scan = makeScan({{"x", ScalarType::kFloat32, {1, 2}},
                                {"y", ScalarType::kFloat32, {3, 4}},
                                {"z", ScalarType::kFloat32, {5, bad}}});
    EXPECT_FALSE(scan.is_dense);
  }
}

TEST(IoScan, TakesDoublesWhenFloatsLoseAMillimetre) {
  EXPECT_EQ(positionType({100.123}, {-200.456}, {3}), ScalarType::kFloat32);
  EXPECT_EQ(positionType({1}, {5412345.678}, {3}), ScalarType::kFloat64);
  EXPECT_EQ(positionType({1}, {5412345.0}, {std::nan("")}), ScalarType::kFloat32);
  EXPECT_EQ(attributeType({255, 0.25}), ScalarType::kFloat32);
  EXPECT_EQ(attributeType({1635236489.369082}), ScalarType::kFloat64);
}

TEST(IoScan, NamesTheFieldThatIsMissingOrThereAlready) {
  Scan scan = makeTestScan();
  expectError([&] { readColumn(scan, "label"); }, {"'label'", "x:float32, y:float32"});
  expectError([&] { addColumn(scan, {"x", ScalarType::kUint8, {0, 0}}); }, {"already", "'x'"});
}

}  // namespace
}  // namespace ladar_perception
