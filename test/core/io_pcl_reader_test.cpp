// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>

#include "io_test_files.h"
#include "ladar_perception/io/pcl_reader.h"

namespace ladar_perception {
namespace {

using Values = std::vector<double>;

std::string pcdHead(const std::string& encoding) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z ring time\nSIZE 4 4 4 2 8\nTYPE F F F U F\n"
         "COUNT 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA " +
         encoding + "\n";
}

template <typename T>
std::string bytes(T value) {
  return bytesOf<T>({value});
}

std::string binaryBody() {
  std::string body;
  for (int i = 0; i < 2; ++i) {
    for (const float k : {1.f, 2.f, 3.f}) body += bytes(k + 3.f * static_cast<float>(i));
    body += bytes(static_cast<uint16_t>(10 + i)) + bytes(1e9 + 0.5 * i);
  }
  return body;
}

// PCL stores one field after the other; LZF allows to give all as literals of up to 32 bytes.
std::string compressedBody() {
  std::string fields = bytesOf<float>({1, 4, 2, 5, 3, 6}) + bytesOf<uint16_t>({10, 11}) +
                       bytesOf<double>({1e9, 1e9 + 0.5});
  std::string lzf;
  for (std::size_t at = 0; at < fields.size(); at += 32) {
    const std::string run = fields.substr(at, 32);
    lzf += static_cast<char>(run.size() - 1) + run;
  }
  return bytes(static_cast<uint32_t>(lzf.size())) + bytes(static_cast<uint32_t>(fields.size())) +
         lzf;
}

const std::string kAsciiBody = "1 2 3 10 1000000000\n4 5 6 11 1000000000.5\n";

void expectTwoPoints(const Scan& scan) {
  ASSERT_EQ(scan.size(), 2u);
  EXPECT_EQ(scan.layout.describeFields(),
            "x:float32, y:float32, z:float32, ring:uint16, time:float64");
  EXPECT_EQ(readColumn(scan, "x"), (Values{1, 4}));
  EXPECT_EQ(readColumn(scan, "z"), (Values{3, 6}));
  EXPECT_EQ(readColumn(scan, "ring"), (Values{10, 11}));
  EXPECT_EQ(readColumn(scan, "time"), (Values{1e9, 1e9 + 0.5}));
  EXPECT_TRUE(scan.is_dense);
}

TEST(IoPclReader, ReadsEveryPcdEncoding) {
  expectTwoPoints(readPcdScan(writeFile("a.pcd", pcdHead("ascii") + kAsciiBody)));
  expectTwoPoints(readPcdScan(writeFile("b.pcd", pcdHead("binary") + binaryBody())));
  expectTwoPoints(readPcdScan(writeFile("c.pcd", pcdHead("binary_compressed") + compressedBody())));
}

TEST(IoPclReader, RefusesPcdThatEndsEarly) {
  const std::string whole[] = {pcdHead("binary") + binaryBody(),
                               pcdHead("binary_compressed") + compressedBody()};
  for (const std::string& file : whole) {
    const std::size_t body = file.find('\n', file.find("DATA")) + 1;
    for (const std::size_t size : {file.size() - 1, body + 6, body}) {
      const std::string path = writeFile("cut.pcd", file.substr(0, size));
      expectError([&] { readPcdScan(path); }, {path});
    }
  }
  const std::string path = writeFile("cut.pcd", pcdHead("ascii") + "1 2 3 10 0\n");
  expectError([&] { readPcdScan(path); }, {path, "ends early", "1 points", "expected 2"});
}

TEST(IoPclReader, RefusesPcdThatIsDamaged) {
  const auto expectMessage = [](const std::string& file, const std::vector<std::string>& parts) {
    const std::string path = writeFile("bad.pcd", file);
    expectError([&] { readPcdScan(path); }, parts);
  };
  expectMessage(pcdHead("ascii") + "1 2 3 10 0\n1 2 z 11 0\n", {"bad.pcd:13", "'z'"});
  expectMessage(pcdHead("ascii") + "1 2 3 10\n1 2 3 11 0\n", {"bad.pcd:12", "4 values", "5"});
  expectMessage("no header at all\n", {"bad.pcd"});
  expectMessage("", {"bad.pcd"});
  // A run that copies from before the start of the output.
  const std::string lzf = bytes(uint32_t{3}) + bytes(uint32_t{44}) + "\xE0\x20\x20";
  expectMessage(pcdHead("binary_compressed") + lzf, {"bad.pcd"});
  expectError([] { readPcdScan("/nowhere.pcd"); }, {"/nowhere.pcd", "cannot be opened"});
}

TEST(IoPclReader, ReadsPcdWithoutPoints) {
  for (const char* encoding : {"ascii", "binary", "binary_compressed"}) {
    const Scan scan = readPcdScan(writeFile(
        "a.pcd", std::string("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n") +
                     "WIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA " + encoding + "\n"));
    EXPECT_EQ(scan.size(), 0u) << encoding;
    EXPECT_EQ(scan.layout.fields.size(), 3u) << encoding;
  }
}

TEST(IoPclReader, KeepsInvalidPointsOrganisedCloudsAndWideFields) {
  const std::string head =
      "VERSION 0.7\nFIELDS x y z _ hist id\nSIZE 4 4 4 1 4 8\nTYPE F F F U F U\n"
      "COUNT 1 1 1 4 2 1\nWIDTH 1\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA binary\n";
  std::string body;
  for (const float x : {1.f, std::nanf("")}) {
    body += bytesOf<float>({x, 2, 3}) + "pad." + bytesOf<float>({7, 8}) + bytes(uint64_t{1} << 40);
  }
  const Scan scan = readPcdScan(writeFile("a.pcd", head + body));
  EXPECT_EQ(scan.layout.describeFields(),
            "x:float32, y:float32, z:float32, hist:float32[2], id:float64");
  EXPECT_EQ(scan.layout.width, 1u);
  EXPECT_EQ(scan.layout.height, 2u);
  EXPECT_FALSE(scan.is_dense);
  EXPECT_TRUE(std::isnan(readColumn(scan, "x")[1]));
  EXPECT_EQ(readColumn(scan, "id"), (Values{1099511627776.0, 1099511627776.0}));
}

std::string plyHead(const std::string& format, const std::string& more = "") {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex 2\n" +
         "property double x\nproperty double y\nproperty double z\nproperty float intensity\n" +
         more + "end_header\n";
}

const std::string kFace = "element face 1\nproperty list uchar int vertex_indices\n";

TEST(IoPclReader, ReadsPly) {
  const std::string body =
      bytesOf<double>({456789.125, 2, 3}) + bytes(0.5f) + bytesOf<double>({4, 5, 6}) + bytes(0.75f);
  const std::string face = std::string("\x02") + bytesOf<int32_t>({0, 1});
  const std::string files[] = {plyHead("ascii") + "456789.125 2 3 0.5\n4 5 6 0.75\n",
                               plyHead("binary_little_endian") + body,
                               plyHead("binary_little_endian", kFace) + body + face,
                               plyHead("ascii", kFace) + "456789.125 2 3 0.5\n4 5 6 0.75\n2 0 1\n"};
  for (const std::string& file : files) {
    const Scan scan = readPlyScan(writeFile("a.ply", file));
    ASSERT_EQ(scan.size(), 2u);
    EXPECT_EQ(readColumn(scan, "x"), (Values{456789.125, 4}));
    EXPECT_EQ(readColumn(scan, "intensity"), (Values{0.5, 0.75}));
  }
}

TEST(IoPclReader, ReadsPlyColours) {
  const std::string head =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  const std::string big_endian = std::string("\x3F\x80\0\0\x40\0\0\0\x40\x40\0\0", 12) + "\1\2\3";
  const std::string files[] = {
      "ply\nformat ascii 1.0\n" + head + "1 2 3 1 2 3\n1 2 3 1 2 3\n",
      "ply\nformat binary_big_endian 1.0\n" + head + big_endian + big_endian};
  for (const std::string& file : files) {
    const Scan scan = readPlyScan(writeFile("a.ply", file));
    ASSERT_EQ(scan.size(), 2u);
    EXPECT_EQ(readColumn(scan, "z"), (Values{3, 3}));
    const Field* rgb = scan.layout.find("rgb");
    ASSERT_NE(rgb, nullptr) << scan.layout.describeFields();
    uint32_t packed = 0;
    std::memcpy(&packed, scan.data.data() + rgb->offset, sizeof packed);
    EXPECT_EQ(packed & 0xFFFFFFu, 0x010203u);
  }
}

TEST(IoPclReader, RefusesPlyThatIsDamaged) {
  const auto expectMessage = [](const std::string& file, const std::vector<std::string>& parts) {
    const std::string path = writeFile("bad.ply", file);
    expectError([&] { readPlyScan(path); }, parts);
  };
  const std::string body(55, 'x');  // one byte short of two points
  expectMessage(plyHead("binary_little_endian") + body, {"bad.ply", "ends early"});
  expectMessage(plyHead("ascii") + "1 2 3 4\n", {"bad.ply", "ends early", "expected 2"});
  expectMessage(plyHead("ascii") + "1 2 3 4\n1 2 y 4\n", {"bad.ply:11", "'y'"});
  expectMessage("pla\n", {"bad.ply:1", "expected 'ply'"});
  expectMessage("ply\nformat ascii 1.0\n", {"bad.ply", "end_header"});
  expectMessage("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n", {"bad.ply:4"});
  expectMessage("ply\nformat ascii 1.0\n" + kFace + "end_header\n", {"bad.ply:3", "'vertex'"});
  expectMessage("ply\nformat ascii 1.0\nelement vertex 1\nproperty float a\nend_header\n1\n",
                {"bad.ply", "no field 'x'"});
}

}  // namespace
}  // namespace ladar_perception
