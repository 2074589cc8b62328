// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "io_test_files.h"
#include "ladar_perception/io/text_reader.h"

namespace ladar_perception {
namespace {

using Values = std::vector<double>;

TEST(IoTextReader, ReadsPlainColumns) {
  const Scan scan = readTextScan(writeFile("a.xyz", "# a comment\n1 2 3\n\n  4\t5  6 \n"));
  EXPECT_EQ(scan.layout.describeFields(), "x:float32, y:float32, z:float32");
  EXPECT_EQ(readColumn(scan, "x"), (Values{1, 4}));
  EXPECT_EQ(readColumn(scan, "z"), (Values{3, 6}));
  EXPECT_TRUE(scan.is_dense);
}

TEST(IoTextReader, NamesUnknownColumnsByTheirPlace) {
  const Scan scan = readTextScan(writeFile("a.txt", "1 2 3 0.5 7\n"));
  EXPECT_EQ(readColumn(scan, "c3"), (Values{0.5}));
  EXPECT_EQ(readColumn(scan, "c4"), (Values{7}));
}

TEST(IoTextReader, ReadsHeaderCommasAndWindowsLines) {
  const Scan scan = readTextScan(
      writeFile("a.csv", "\xEF\xBB\xBF\"intensity\" , X,Y,Z\r\n+9, 1 ,2,3\r\n8,4,5,6\r\n\r\n"));
  EXPECT_EQ(readColumn(scan, "intensity"), (Values{9, 8}));
  EXPECT_EQ(readColumn(scan, "x"), (Values{1, 4}));
  EXPECT_EQ(scan.layout.fields[0].name, "x");
}

TEST(IoTextReader, ReadsHeaderInAComment) {
  const Scan scan = readTextScan(writeFile("a.txt", "//X Y Z Reflectance\n1 2 3 4\n"));
  EXPECT_EQ(readColumn(scan, "Reflectance"), (Values{4}));
  // A comment that only sounds like one, by its count.
  const Scan plain = readTextScan(writeFile("b.txt", "# x y z in metres\n1 2 3\n"));
  EXPECT_EQ(plain.layout.fields.size(), 3u);
}

TEST(IoTextReader, TakesGivenNamesAndSkipsColumns) {
  const std::string path = writeFile("a.txt", "a b c d e\nmap 1 2 3 7\nmap 4 5 6 8\n");
  const Scan scan = readTextScan(path, {"_", "z", "y", "x", "t"});
  EXPECT_EQ(scan.layout.describeFields(), "x:float32, y:float32, z:float32, t:float32");
  EXPECT_EQ(readColumn(scan, "x"), (Values{3, 6}));
  expectError([&] { readTextScan(path, {"x", "y", "z"}); }, {path + ":2", "5 columns", "3"});
  expectError([&] { readTextScan(path, {"_", "x", "x", "y", "z"}); }, {"'x'"});
  expectError([&] { readTextScan(path, {"x", "a", "b", "y", "c"}); }, {"no column", "'z'"});
}

TEST(IoTextReader, KeepsInvalidPoints) {
  const Scan scan = readTextScan(writeFile("a.csv", "x,y,z\n1,2,3\nnan,NaN,-nan\n,,\n4,inf,6\n"));
  ASSERT_EQ(scan.size(), 4u);
  EXPECT_FALSE(scan.is_dense);
  EXPECT_TRUE(std::isnan(readColumn(scan, "z")[1]));
  EXPECT_TRUE(std::isnan(readColumn(scan, "z")[2]));
  EXPECT_TRUE(std::isinf(readColumn(scan, "y")[3]));
}

TEST(IoTextReader, KeepsLargeCoordinates) {
  const Scan scan = readTextScan(writeFile("utm.xyz", "456789.123 5412345.678 312.5 1.25\n"));
  EXPECT_EQ(scan.layout.describeFields(), "x:float64, y:float64, z:float64, c3:float32");
  EXPECT_EQ(readColumn(scan, "y"), (Values{5412345.678}));
}

TEST(IoTextReader, NamesTheLineAndTheToken) {
  const auto error = [](const std::string& text) {
    return errorOf([&] { readTextScan(writeFile("bad.xyz", text)); });
  };
  EXPECT_NE(error("# c\n1 2 3\n1 2 3x\n").find("bad.xyz:3: '3x'"), std::string::npos);
  EXPECT_NE(error("1 2 3\n1 2\n").find("bad.xyz:2: found 2 columns, expected 3"),
            std::string::npos);
  EXPECT_NE(error("1 2\n").find("bad.xyz:1"), std::string::npos);
  EXPECT_NE(error("1 2 1e999\n").find("'1e999'"), std::string::npos);
  EXPECT_NE(error("1,2 5,3\n").find("'2 5'"), std::string::npos);
  EXPECT_NE(error("# nothing\n").find("no points"), std::string::npos);
  EXPECT_NE(error("easting northing up\n1 2 3\n").find("easting,northing,up"), std::string::npos);
  expectError([] { readTextScan("/nowhere/a.xyz"); }, {"/nowhere/a.xyz", "cannot be opened"});
}

TEST(IoTextReader, ReadsOakland) {
  const Scan scan =
      readOaklandScan(writeFile("a.xyz_label_conf", "#File format\n1 2 3 1203 2\n4 5 6 9999 2\n"));
  EXPECT_EQ(scan.layout.find("label")->type, ScalarType::kUint16);
  EXPECT_EQ(readColumn(scan, "label"), (Values{1203, 9999}));
  EXPECT_EQ(readColumn(scan, "confidence"), (Values{2, 2}));
  for (const std::string bad : {"-1", "65536", "1.5", "nan"}) {
    const std::string path = writeFile("b.xyz_label_conf", "1 2 3 4 2\n1 2 3 " + bad + " 2\n");
    expectError([&] { readOaklandScan(path); }, {path + ":2", "label"});
  }
}

TEST(IoTextReader, TurnsThe3dtkFrame) {
  const Scan scan = read3dtkScan(writeFile("a.3d", "100 200 300 0.5\n"));  // right, up, forward
  EXPECT_FLOAT_EQ(static_cast<float>(readColumn(scan, "x")[0]), 3.0f);
  EXPECT_FLOAT_EQ(static_cast<float>(readColumn(scan, "y")[0]), -1.0f);
  EXPECT_FLOAT_EQ(static_cast<float>(readColumn(scan, "z")[0]), 2.0f);
  EXPECT_EQ(readColumn(scan, "c3"), (Values{0.5}));
}

const char kVtkHead[] = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\n";

TEST(IoTextReader, ReadsVtk) {
  const Scan scan = readVtkScan(writeFile(
      "a.vtk", std::string(kVtkHead) +
                   "POINTS 2 float\n1 2 3 4\n5 6\nVERTICES 2 4\n1 0\n1 1\n\nPOINT_DATA 2\n"
                   "SCALARS intensity float 1\nLOOKUP_TABLE default\n7\n8\n"
                   "NORMALS n float\n0 0 1 0 1 0\nFIELD data 2\nring 1 2 int\n3 4\n"
                   "meta 1 1 int\n5\nCELL_DATA 1\nSCALARS c float\nLOOKUP_TABLE default\n9\n"));
  ASSERT_EQ(scan.size(), 2u);
  EXPECT_EQ(readColumn(scan, "x"), (Values{1, 4}));
  EXPECT_EQ(readColumn(scan, "intensity"), (Values{7, 8}));
  EXPECT_EQ(readColumn(scan, "normal_z"), (Values{1, 0}));
  EXPECT_EQ(readColumn(scan, "ring"), (Values{3, 4}));
  EXPECT_EQ(scan.layout.find("c"), nullptr);
  EXPECT_EQ(scan.layout.find("meta"), nullptr);
}

TEST(IoTextReader, NamesWhatIsWrongInVtk) {
  const auto error = [](const std::string& text) {
    return errorOf([&] { readVtkScan(writeFile("bad.vtk", text)); });
  };
  const std::string head = kVtkHead;
  EXPECT_NE(error("").find("bad.vtk"), std::string::npos);
  EXPECT_NE(error("# vtk DataFile Version 3.0\nt\nBINARY\n").find("bad.vtk:3: found 'BINARY'"),
            std::string::npos);
  EXPECT_NE(error(head).find("before POINTS"), std::string::npos);
  EXPECT_NE(error(head + "POINTS 2 float\n1 2 3 4\n").find("ends here"), std::string::npos);
  EXPECT_NE(error(head + "POINTS 1 float\n1 2 x\n").find("bad.vtk:6: 'x'"), std::string::npos);
  EXPECT_NE(error(head + "POINTS 1 float\n1 2 3\nPOINT_DATA 2\n").find("bad.vtk:7"),
            std::string::npos);
  EXPECT_NE(error(head + "POINTS 1 float\n1 2 3\nCUBES 2\n").find("'CUBES'"), std::string::npos);
}

}  // namespace
}  // namespace ladar_perception
