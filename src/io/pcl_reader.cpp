// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/pcl_reader.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "ply_header.h"
#include "text_table.h"

namespace ladar_perception {
namespace {

/// PCL prints its complaints; ours go into the exception.
class QuietPcl {
 public:
  QuietPcl() : level_(pcl::console::getVerbosityLevel()) {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }
  ~QuietPcl() { pcl::console::setVerbosityLevel(level_); }
  QuietPcl(const QuietPcl&) = delete;
  QuietPcl& operator=(const QuietPcl&) = delete;

 private:
  pcl::console::VERBOSITY_LEVEL level_;
};

[[noreturn]] void fail(const std::string& path, const std::string& message) {
  throw std::runtime_error(path + ": " + message);
}

std::uintmax_t sizeOf(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || !std::ifstream(path)) fail(path, "cannot be opened for reading");
  return size;
}

void expectBytes(const std::string& path, std::uintmax_t found, std::uintmax_t expected) {
  if (found >= expected) return;
  fail(path,
       "ends early: has " + std::to_string(found) + " bytes, expected " + std::to_string(expected));
}

template <typename Integer>
void convertToDouble(Scan& scan, const Field& field) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    uint8_t* at = scan.data.data() + i * scan.layout.point_step + field.offset;
    for (uint32_t k = 0; k < field.count; ++k, at += sizeof(double)) {
      Integer integer = 0;
      std::memcpy(&integer, at, sizeof integer);
      const double value = static_cast<double>(integer);
      std::memcpy(at, &value, sizeof value);
    }
  }
}

void addField(Scan& scan, const pcl::PCLPointField& in) {
  if (in.name == "_") return;  // padding
  Field field{in.name, in.offset, static_cast<ScalarType>(in.datatype),
              std::max<uint32_t>(in.count, 1)};
  if (in.datatype == pcl::PCLPointField::INT64) {
    convertToDouble<int64_t>(scan, field);
    field.type = ScalarType::kFloat64;
  } else if (in.datatype == pcl::PCLPointField::UINT64) {
    convertToDouble<uint64_t>(scan, field);
    field.type = ScalarType::kFloat64;
  } else if (in.datatype == pcl::PCLPointField::BOOL) {
    field.type = ScalarType::kUint8;
  }
  scan.layout.fields.push_back(field);
}

Scan toScan(const std::string& path, pcl::PCLPointCloud2&& cloud) {
  Scan scan;
  scan.layout.width = cloud.width;
  scan.layout.height = cloud.height;
  scan.layout.point_step = cloud.point_step;
  scan.layout.pack();
  scan.data.assign(cloud.data.begin(), cloud.data.end());
  const std::size_t expected = scan.size() * scan.layout.point_step;
  if (scan.data.size() < expected) {
    fail(path, "ends early: " + std::to_string(scan.data.size()) + " bytes of points, expected " +
                   std::to_string(expected));
  }
  for (const pcl::PCLPointField& field : cloud.fields) addField(scan, field);
  const std::string error = layoutError({scan.layout, scan.data.data(), scan.data.size()});
  if (!error.empty()) fail(path, error);
  for (const char* axis : {"x", "y", "z"}) {
    if (scan.layout.find(axis) == nullptr) {
      fail(path, std::string("has no field '") + axis +
                     "' (fields: " + scan.layout.describeFields() + ")");
    }
  }
  updateIsDense(scan);
  return scan;
}

/// Checks that `rows` lines of `cells` numbers follow the one that `lines` is at. PCL would take
/// a bad token for 0.
void checkAsciiBody(const std::string& path, LineReader& lines, std::size_t rows,
                    std::size_t cells) {
  std::vector<std::string_view> tokens;
  std::size_t row = 0;
  while (row < rows && lines.next()) {
    splitCells(lines.text(), tokens);
    if (tokens.empty()) continue;
    ++row;
    if (tokens.size() != cells) {
      lines.fail("found " + std::to_string(tokens.size()) + " values, expected " +
                 std::to_string(cells));
    }
    double ignored = 0.0;
    for (const std::string_view token : tokens) {
      if (!parseNumber(token, ignored)) {
        lines.fail("'" + std::string(token) + "' is not a number");
      }
    }
  }
  if (row < rows) {
    fail(path,
         "ends early: has " + std::to_string(row) + " points, expected " + std::to_string(rows));
  }
}

void checkPcdAscii(const std::string& path, const pcl::PCLPointCloud2& header) {
  std::size_t cells = 0;
  for (const pcl::PCLPointField& field : header.fields) cells += std::max(1u, field.count);
  LineReader lines(path);
  while (lines.next() && lines.text().rfind("DATA", 0) != 0) {
  }
  checkAsciiBody(path, lines, std::size_t{header.width} * header.height, cells);
}

void checkPcdCompressed(const std::string& path, std::uintmax_t size, std::uintmax_t body_at,
                        std::uintmax_t body_bytes) {
  uint32_t sizes[2] = {0, 0};  // compressed, uncompressed
  expectBytes(path, size, body_at + sizeof sizes);
  std::ifstream stream(path, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(body_at));
  stream.read(reinterpret_cast<char*>(sizes), sizeof sizes);
  expectBytes(path, size, body_at + sizeof sizes + sizes[0]);
  if (sizes[1] != body_bytes) {
    fail(path, "says it holds " + std::to_string(sizes[1]) + " bytes of points, expected " +
                   std::to_string(body_bytes) + " from its header");
  }
}

enum PcdEncoding { kPcdAscii = 0, kPcdBinary = 1, kPcdCompressed = 2 };  // numbers of PCL

/// The header of a file that has all its points.
pcl::PCLPointCloud2 checkPcd(const std::string& path, std::uintmax_t size) {
  pcl::PCLPointCloud2 header;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0;
  int encoding = 0;
  unsigned int body_at = 0;
  const int result =
      pcl::PCDReader().readHeader(path, header, origin, orientation, version, encoding, body_at);
  // PCL takes a text without a header for a cloud without fields, and crashes reading its points.
  if (result < 0 || header.fields.empty()) {
    fail(path, "has no valid PCD header (FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, POINTS, DATA)");
  }
  const std::uintmax_t body_bytes =
      std::uintmax_t{header.width} * header.height * header.point_step;
  if (encoding == kPcdAscii) checkPcdAscii(path, header);
  if (encoding == kPcdBinary) expectBytes(path, size, body_at + body_bytes);
  if (encoding == kPcdCompressed && body_bytes > 0) {
    checkPcdCompressed(path, size, body_at, body_bytes);
  }
  return header;
}

void checkPly(const std::string& path, std::uintmax_t size) {
  LineReader lines(path);
  const PlyHeader header = readPlyHeader(lines);
  if (header.ascii) {
    checkAsciiBody(path, lines, header.vertices, header.properties);
  } else {
    expectBytes(path, size, header.bytes + header.vertices * header.vertex_bytes);
  }
}

}  // namespace

Scan readPcdScan(const std::string& path) {
  const QuietPcl quiet;
  pcl::PCLPointCloud2 cloud = checkPcd(path, sizeOf(path));
  const bool has_points = cloud.width > 0 && cloud.height > 0;
  if (has_points && pcl::PCDReader().read(path, cloud) < 0) fail(path, "cannot be decoded as PCD");
  return toScan(path, std::move(cloud));
}

Scan readPlyScan(const std::string& path) {
  const QuietPcl quiet;
  checkPly(path, sizeOf(path));
  pcl::PCLPointCloud2 cloud;
  if (pcl::PLYReader().read(path, cloud) < 0) fail(path, "cannot be decoded as PLY");
  return toScan(path, std::move(cloud));
}

}  // namespace ladar_perception
